//! What the likelihood of noises is taken of: a log, and factors.

/// A log as the likelihood sees it: `updates` rows, flat and row by row.
#[derive(Debug, Clone, Copy)]
pub struct NoiseLog<'a> {
    /// `(updates, m)`: innovations, NaN where a component is missing or not used.
    pub innovations: &'a [f64],
    /// `(updates, m, n)`: H.
    pub observations: &'a [f64],
    /// `(updates, m, m)`: R.
    pub measurement_noises: &'a [f64],
    /// `(updates,)`: index of the measurement factor of each update.
    pub types: &'a [i64],
    /// `(updates, n, n)`: F from the update before; that of a track's first update is not used.
    pub transitions: &'a [f64],
    /// `(updates, groups, n, n)`: Q of each group; that of a track's first update is not used.
    pub process_noises: &'a [f64],
    /// `(updates, n)`: updated minus predicted state of the filter.
    pub corrections: &'a [f64],
    /// `(updates, m)`: period of each component that is an angle, NaN for the others.
    pub periods: &'a [f64],
    /// `(tracks, n, n)`: covariance of the first prediction error of each track.
    pub initial: &'a [f64],
    /// `(tracks + 1,)`: first update of each track, and the number of updates.
    pub starts: &'a [i64],
    /// n, the number of states.
    pub states: usize,
    /// m, the largest number of components of a measurement.
    pub components: usize,
    /// How many groups of process noise there are.
    pub groups: usize,
}

/// The factors at which the likelihood is taken, and the distribution of the innovations.
#[derive(Debug, Clone, Copy)]
pub struct NoiseFactors<'a> {
    /// Factor of each group of process noise.
    pub process: &'a [f64],
    /// Factor of each measurement type.
    pub measurement: &'a [f64],
    /// Factor of the initial covariances.
    pub initial: f64,
    /// Degrees of freedom of Student's t distribution; infinite for the normal distribution.
    pub tail_dof: f64,
    /// `(m + 1,)`: the scale s of each number of components.
    pub tail_scales: &'a [f64],
}

impl NoiseFactors<'_> {
    /// How many factors there are.
    pub fn count(&self) -> usize {
        self.process.len() + self.measurement.len() + 1
    }
}
