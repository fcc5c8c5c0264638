//! One measurement of the leading states of a vessel, fused.
//!
//! With H = [I_m 0] the innovation is the difference of the first m states, longitude and course
//! wrapped; S = H P H' + R, the gain K = P H' S^-1 by Cholesky, NIS = y' S^-1 y, and the covariance
//! in Joseph's form (I - K H) P (I - K H)' + K R K', which stays positive definite under rounding
//! (Bucy and Joseph, *Filtering for Stochastic Processes with Applications to Guidance*, 1968).

use super::earth::{degree, wrap_course, wrap_difference};
use super::motion::{Matrix, Prediction, State};
use nalgebra::{SMatrix, SVector};

/// Most components that a measurement has: latitude, longitude, speed, course.
pub const COMPONENTS: usize = 4;

/// What was measured, in the units of the state.
#[derive(Debug, Clone, Copy)]
pub struct Measurement {
    /// Latitude, longitude, speed, course; what was not measured is NaN.
    pub z: [f64; COMPONENTS],
    /// How many of the leading states were measured: 2, 3 or 4.
    pub observed: usize,
    /// Standard deviations: position in metres, speed in knots, course in degrees.
    pub sigma: [f64; 3],
}

impl Measurement {
    /// Variances of the components.
    pub fn variances(&self) -> [f64; COMPONENTS] {
        let [position, speed, course] = self.sigma;
        let here = degree(self.z[0]);
        let (north, east) = (position / here.north, position / here.east);
        [north * north, east * east, speed * speed, course * course]
    }
}

/// What a measurement made of a prediction.
#[derive(Debug, Clone, Copy)]
pub struct Update {
    /// Updated state.
    pub x: State,
    /// Its covariance.
    pub p: Matrix,
    /// (I - K H) F: how the error of the last update enters this one.
    pub a: Matrix,
    /// Measurement minus predicted measurement; NaN beyond the observed components.
    pub innovation: [f64; COMPONENTS],
    /// Its covariance, NaN beyond.
    pub s: [[f64; COMPONENTS]; COMPONENTS],
    /// Normalised innovation squared.
    pub nis: f64,
}

/// Fuses a measurement; the leading minor of S that is not positive where there is one.
pub fn update(prediction: &Prediction, measured: &Measurement) -> Result<Update, usize> {
    match measured.observed {
        2 => fuse::<2>(prediction, measured),
        3 => fuse::<3>(prediction, measured),
        _ => fuse::<4>(prediction, measured),
    }
}

fn fuse<const M: usize>(at: &Prediction, measured: &Measurement) -> Result<Update, usize> {
    let y = innovation::<M>(&at.x, &measured.z);
    let variances = measured.variances();
    let mut s: SMatrix<f64, M, M> = at.p.fixed_view::<M, M>(0, 0).into_owned();
    for i in 0..M {
        s[(i, i)] += variances[i];
    }
    let lower = cholesky(&s)?;
    let observed: SMatrix<f64, M, 5> = at.p.fixed_rows::<M>(0).into_owned();
    let gain = solve(&lower, &observed).transpose();
    let mut x = at.x + gain * y;
    x[1] = wrap_difference(x[1]);
    x[3] = wrap_course(x[3]);
    let mut kept = Matrix::identity();
    for (mut column, k) in kept.column_iter_mut().zip(gain.column_iter()) {
        column -= k;
    }
    let mut noisy = gain;
    for (mut column, variance) in noisy.column_iter_mut().zip(variances) {
        column *= variance;
    }
    let p = kept * at.p * kept.transpose() + noisy * gain.transpose();
    Ok(Update {
        x,
        p: (p + p.transpose()) * 0.5,
        a: kept * at.f,
        innovation: std::array::from_fn(|i| if i < M { y[i] } else { f64::NAN }),
        s: std::array::from_fn(|i| {
            std::array::from_fn(|j| if i < M && j < M { s[(i, j)] } else { f64::NAN })
        }),
        nis: y.dot(&solve(&lower, &y)),
    })
}

fn innovation<const M: usize>(x: &State, z: &[f64; COMPONENTS]) -> SVector<f64, M> {
    let mut y = SVector::<f64, M>::from_fn(|i, _| z[i] - x[i]);
    y[1] = wrap_difference(y[1]);
    if M == 4 {
        y[3] = wrap_difference(y[3]);
    }
    y
}

/// L of S = L L', or the size of the first leading minor that is not positive.
fn cholesky<const M: usize>(s: &SMatrix<f64, M, M>) -> Result<SMatrix<f64, M, M>, usize> {
    let mut lower = SMatrix::<f64, M, M>::zeros();
    for j in 0..M {
        let pivot = s[(j, j)] - (0..j).map(|k| lower[(j, k)] * lower[(j, k)]).sum::<f64>();
        // Written so that NaN fails too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return Err(j + 1);
        }
        lower[(j, j)] = pivot.sqrt();
        for i in j + 1..M {
            let rest = s[(i, j)] - (0..j).map(|k| lower[(i, k)] * lower[(j, k)]).sum::<f64>();
            lower[(i, j)] = rest / lower[(j, j)];
        }
    }
    Ok(lower)
}

/// S^-1 B by two substitutions.
fn solve<const M: usize, const N: usize>(
    lower: &SMatrix<f64, M, M>,
    right: &SMatrix<f64, M, N>,
) -> SMatrix<f64, M, N> {
    let mut x = *right;
    for column in 0..N {
        for i in 0..M {
            let known = (0..i).map(|k| lower[(i, k)] * x[(k, column)]).sum::<f64>();
            x[(i, column)] = (x[(i, column)] - known) / lower[(i, i)];
        }
        for i in (0..M).rev() {
            let known = (i + 1..M).map(|k| lower[(k, i)] * x[(k, column)]).sum::<f64>();
            x[(i, column)] = (x[(i, column)] - known) / lower[(i, i)];
        }
    }
    x
}
