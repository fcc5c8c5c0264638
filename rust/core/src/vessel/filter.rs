//! Many tracks through the filter in one call: reports packed track by track, a row for each.

use super::lifecycle::{Life, Outcome, Row, Track};
use super::motion::{Matrix, Motion, STATES, State};
use super::update::{COMPONENTS, Measurement, Update};
use crate::error::{Error, Result};

/// Numbers of a track in [`Tracks::life`].
pub const LIFE: usize = 7;

/// Reports of many tracks: those of track i are `starts[i] .. starts[i + 1]`.
#[derive(Debug, Clone, Copy)]
pub struct Reports<'a> {
    /// Offsets, one more than tracks.
    pub starts: &'a [i64],
    /// Times in seconds.
    pub times: &'a [f64],
    /// Latitude, longitude, speed, course of each; what was not measured is not read.
    pub z: &'a [f64],
    /// How many of the leading states each measured: 2, 3 or 4.
    pub observed: &'a [i64],
    /// Standard deviations of each: position in metres, speed in knots, course in degrees.
    pub sigmas: &'a [f64],
}

/// Many tracks between two calls.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks {
    /// Reports taken, starts, time of the last report, time, latitude, longitude and position
    /// sigma of the first.
    pub life: Vec<f64>,
    /// States.
    pub x: Vec<f64>,
    /// Their covariances.
    pub p: Vec<f64>,
}

/// A row for each report; what a report has no value for is NaN.
#[derive(Debug, Clone)]
pub struct Rows {
    /// What became of it: [`Outcome`].
    pub outcome: Vec<i64>,
    /// How often its track had started, this report included.
    pub start: Vec<i64>,
    /// Predicted state.
    pub x_pred: Vec<f64>,
    /// Its covariance.
    pub p_pred: Vec<f64>,
    /// Measurement minus predicted measurement.
    pub innovation: Vec<f64>,
    /// Its covariance.
    pub s: Vec<f64>,
    /// Covariance of the measurement's noise.
    pub r: Vec<f64>,
    /// Normalised innovation squared.
    pub nis: Vec<f64>,
    /// State after the report.
    pub x: Vec<f64>,
    /// Its covariance.
    pub p: Vec<f64>,
    /// (I - K H) F.
    pub a: Vec<f64>,
}

impl Rows {
    fn new(n: usize) -> Self {
        let nan = |width: usize| vec![f64::NAN; n * width];
        let (matrix, square) = (STATES * STATES, COMPONENTS * COMPONENTS);
        Self {
            outcome: vec![0; n],
            start: vec![0; n],
            x_pred: nan(STATES),
            p_pred: nan(matrix),
            innovation: nan(COMPONENTS),
            s: nan(square),
            r: nan(square),
            nis: nan(1),
            x: nan(STATES),
            p: nan(matrix),
            a: nan(matrix),
        }
    }

    fn write(&mut self, i: usize, row: &Row, track: &Track, measured: &Measurement) {
        self.outcome[i] = row.outcome as i64;
        self.start[i] = track.starts as i64;
        if row.outcome == Outcome::Late {
            return;
        }
        put(&mut self.x, i, track.x.as_slice());
        put(&mut self.p, i, track.p.as_slice());
        let r = &mut self.r[i * COMPONENTS * COMPONENTS..][..COMPONENTS * COMPONENTS];
        let variances = measured.variances();
        for j in 0..measured.observed {
            for k in 0..measured.observed {
                r[j * COMPONENTS + k] = if j == k { variances[j] } else { 0.0 };
            }
        }
        if let Some((prediction, Update { a, innovation, s, nis, .. })) = &row.fused {
            put(&mut self.x_pred, i, prediction.x.as_slice());
            put(&mut self.p_pred, i, prediction.p.as_slice());
            // nalgebra stands column by column, NumPy row by row; covariances do not mind.
            put(&mut self.a, i, a.transpose().as_slice());
            put(&mut self.innovation, i, innovation);
            put(&mut self.s, i, s.as_flattened());
            self.nis[i] = *nis;
        }
    }
}

fn put(column: &mut [f64], i: usize, values: &[f64]) {
    column[i * values.len()..(i + 1) * values.len()].copy_from_slice(values);
}

impl Tracks {
    /// How many.
    pub fn len(&self) -> usize {
        self.life.len() / LIFE
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.life.is_empty()
    }

    fn get(&self, i: usize) -> Track {
        let life = &self.life[i * LIFE..(i + 1) * LIFE];
        Track {
            reports: life[0] as usize,
            starts: life[1] as usize,
            time: life[2],
            first_time: life[3],
            first: [life[4], life[5]],
            first_sigma: life[6],
            x: State::from_column_slice(&self.x[i * STATES..(i + 1) * STATES]),
            p: Matrix::from_column_slice(&self.p[i * STATES * STATES..(i + 1) * STATES * STATES]),
        }
    }

    fn set(&mut self, i: usize, track: &Track) {
        let [latitude, longitude] = track.first;
        let life = [
            track.reports as f64,
            track.starts as f64,
            track.time,
            track.first_time,
            latitude,
            longitude,
            track.first_sigma,
        ];
        put(&mut self.life, i, &life);
        put(&mut self.x, i, track.x.as_slice());
        put(&mut self.p, i, track.p.as_slice());
    }
}

impl Reports<'_> {
    fn measurement(&self, i: usize) -> Measurement {
        let (z, sigma) = (&self.z[i * COMPONENTS..], &self.sigmas[i * 3..]);
        Measurement {
            z: [z[0], z[1], z[2], z[3]],
            observed: self.observed[i] as usize,
            sigma: [sigma[0], sigma[1], sigma[2]],
        }
    }

    fn check(&self, tracks: usize) -> Result<()> {
        let n = self.times.len();
        let rises = self.starts.len() == tracks + 1
            && self.starts.first() == Some(&0)
            && self.starts.last() == Some(&(n as i64))
            && self.starts.is_sorted();
        if !rises {
            return Err(Error::Offsets { argument: "starts", points: n });
        }
        for (argument, found) in [
            ("z", self.z.len() / COMPONENTS),
            ("observed", self.observed.len()),
            ("sigmas", self.sigmas.len() / 3),
        ] {
            if found != n {
                let (other, unit) = ("times", "reports");
                return Err(Error::Length { argument, found, other, expected: n, unit });
            }
        }
        (0..n).try_for_each(|i| self.check_report(i))
    }

    fn check_report(&self, i: usize) -> Result<()> {
        let not_finite = |argument, index, value| Err(Error::NotFinite { argument, index, value });
        let out = |argument, index, requirement, value| {
            Err(Error::Element { argument, index, requirement, value })
        };
        if !self.times[i].is_finite() {
            return not_finite("times", vec![i], self.times[i]);
        }
        let observed = self.observed[i];
        if !(2..=COMPONENTS as i64).contains(&observed) {
            return out("observed", vec![i], "2, 3 or 4", observed as f64);
        }
        let measured = self.measurement(i);
        let seen = observed as usize;
        if let Some(k) = measured.z[..seen].iter().position(|v| !v.is_finite()) {
            return not_finite("z", vec![i, k], measured.z[k]);
        }
        if measured.z[0].abs() > 90.0 {
            return out("z", vec![i, 0], "a latitude within 90 degrees", measured.z[0]);
        }
        let sigma = &measured.sigma[..seen - 1];
        if let Some(k) = sigma.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
            return out("sigmas", vec![i, k], "positive and finite", sigma[k]);
        }
        Ok(())
    }
}

/// Takes reports into their tracks, in the order given, and tells what each did.
///
/// # Errors
/// The first report that is not finite or out of range; [`Error::NotPositiveDefinite`] names the
/// report at which an innovation covariance is not.
pub fn filter(
    tracks: &mut Tracks,
    reports: &Reports<'_>,
    motion: &Motion,
    life: &Life,
) -> Result<Rows> {
    motion.check()?;
    life.check()?;
    reports.check(tracks.len())?;
    let mut rows = Rows::new(reports.times.len());
    for t in 0..tracks.len() {
        let mut track = tracks.get(t);
        for i in reports.starts[t] as usize..reports.starts[t + 1] as usize {
            let measured = reports.measurement(i);
            let row = track.take(reports.times[i], &measured, motion, life).map_err(|minor| {
                Error::NotPositiveDefinite { argument: "S", index: vec![i], minor }
            })?;
            rows.write(i, &row, &track, &measured);
        }
        tracks.set(t, &track);
    }
    Ok(rows)
}
