//! The life of a vessel's track: started, tentative, active, deleted and started again.
//!
//! A track is tentative for its first reports: it has no NIS, and speed and course come from a full
//! report where there is one, else from the first and the latest position, with the uncertainty
//! that these leave (speed: that of the distance over the time; course: the angle that this
//! subtends at the speed, and that of a uniform course, 104 deg = 360 / sqrt 12, at most). From the
//! next report on the filter runs. A report older than the last one is late and not used; one that
//! comes more than `delete_after` seconds after it starts the track anew.
//!
//! With placeholders the start is that of an estimator that takes what a truncated report does not
//! say for known: speed 0 kt +- 3, course 360 deg +- 10, turn rate 0 +- 0.5 deg/s (1 after a full
//! report), and a covariance that stays as it is while the track is tentative.

use super::earth::{KNOT, RADIAN, degree, wrap_course, wrap_difference};
use super::motion::{Matrix, Motion, Prediction, State};
use super::update::{Measurement, Update, update};
use crate::error::Error;

/// Standard deviation of a speed of which nothing is known, kt: most vessels do less than twice it.
pub const SPEED_PRIOR: f64 = 15.0;
/// Standard deviation of a course of which nothing is known: uniform on the circle, 360 / sqrt 12.
pub const COURSE_PRIOR: f64 = 103.92304845413264;

/// How a track begins and ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Life {
    /// How many reports a track stays tentative; at least 1.
    pub tentative: usize,
    /// Standard deviation of the turn rate of a new track, deg/s.
    pub turn_rate: f64,
    /// Whether a new track takes placeholders for known.
    pub placeholders: bool,
    /// After how many seconds without a report a track ends.
    pub delete_after: f64,
}

impl Life {
    /// Refuses what is not positive.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let positive = |argument, value: f64| {
            let requirement = "positive";
            if value > 0.0 {
                Ok(())
            } else {
                Err(Error::Parameter { argument, requirement, value })
            }
        };
        positive("tentative", self.tentative as f64)?;
        positive("turn_rate", self.turn_rate)?;
        positive("delete_after", self.delete_after)
    }
}

/// What became of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i64)]
pub enum Outcome {
    /// Older than the last report of its track: not used.
    Late = 0,
    /// The first of a track, or the first after its end.
    Started = 1,
    /// Taken into a tentative track.
    Tentative = 2,
    /// Fused by the filter.
    Fused = 3,
}

/// A track between two reports.
#[derive(Debug, Clone, Copy)]
pub struct Track {
    /// How many reports it has taken since its start; 0 before the first.
    pub reports: usize,
    /// How often it has started.
    pub starts: usize,
    /// Time of the last report.
    pub time: f64,
    /// Time of the first.
    pub first_time: f64,
    /// Latitude and longitude of the first.
    pub first: [f64; 2],
    /// Standard deviation of the first position, in metres.
    pub first_sigma: f64,
    /// State after the last report.
    pub x: State,
    /// Its covariance.
    pub p: Matrix,
}

/// What one report did.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// What became of it.
    pub outcome: Outcome,
    /// The prediction and the update, where the filter ran.
    pub fused: Option<(Prediction, Update)>,
}

impl Track {
    /// Takes a report in; the leading minor of S that is not positive where there is one.
    pub fn take(
        &mut self,
        time: f64,
        measured: &Measurement,
        motion: &Motion,
        life: &Life,
    ) -> Result<Row, usize> {
        if self.reports > 0 && time < self.time {
            return Ok(Row { outcome: Outcome::Late, fused: None });
        }
        if self.reports == 0 || time - self.time > life.delete_after {
            self.start(time, measured, life);
            return Ok(Row { outcome: Outcome::Started, fused: None });
        }
        self.reports += 1;
        if self.reports <= life.tentative {
            self.learn(time, measured, life);
            self.time = time;
            return Ok(Row { outcome: Outcome::Tentative, fused: None });
        }
        let prediction = motion.predict(&self.x, &self.p, time - self.time);
        let updated = update(&prediction, measured)?;
        (self.time, self.x, self.p) = (time, updated.x, updated.p);
        Ok(Row { outcome: Outcome::Fused, fused: Some((prediction, updated)) })
    }

    fn start(&mut self, time: f64, measured: &Measurement, life: &Life) {
        let (x, p) = first_state(measured, life);
        *self = Self {
            reports: 1,
            starts: self.starts + 1,
            time,
            first_time: time,
            first: [measured.z[0], measured.z[1]],
            first_sigma: measured.sigma[0],
            x,
            p,
        };
    }

    /// What a tentative track knows after one more report.
    fn learn(&mut self, time: f64, measured: &Measurement, life: &Life) {
        let history = self.history(time, measured);
        if life.placeholders {
            let (speed, course) = history.map_or((0.0, 0.0), |h| (h.speed, h.course));
            self.x = State::new(measured.z[0], measured.z[1], speed, course, 0.0);
            return;
        }
        let (mut x, mut p) = first_state(measured, life);
        if let Some(history) = history.filter(|h| h.speed_sigma < SPEED_PRIOR) {
            if measured.observed < 3 {
                (x[2], p[(2, 2)]) = (history.speed, history.speed_sigma * history.speed_sigma);
            }
            if measured.observed < 4 {
                (x[3], p[(3, 3)]) = (history.course, history.course_sigma * history.course_sigma);
            }
        }
        (self.x, self.p) = (x, p);
    }

    /// Speed and course from the first position to this one; `None` where no time has passed.
    fn history(&self, time: f64, measured: &Measurement) -> Option<History> {
        let seconds = time - self.first_time;
        if seconds <= 0.0 {
            return None;
        }
        let here = degree(0.5 * (self.first[0] + measured.z[0]));
        let north = (measured.z[0] - self.first[0]) * here.north;
        let east = wrap_difference(measured.z[1] - self.first[1]) * here.east;
        let speed = north.hypot(east) / seconds;
        let sigma = self.first_sigma.hypot(measured.sigma[0]) / seconds;
        Some(History {
            speed: speed / KNOT,
            speed_sigma: sigma / KNOT,
            course: wrap_course(east.atan2(north) / RADIAN),
            course_sigma: (sigma / speed.max(1e-6) / RADIAN).min(COURSE_PRIOR),
        })
    }
}

struct History {
    speed: f64,
    speed_sigma: f64,
    course: f64,
    course_sigma: f64,
}

/// What one report says of a vessel by itself.
fn first_state(measured: &Measurement, life: &Life) -> (State, Matrix) {
    let full = measured.observed == 4;
    let (speed, course, rate) = match (life.placeholders, full) {
        (true, true) => (0.0, 0.0, 1.0),
        (true, false) => (3.0, 10.0, 0.5),
        (false, _) => (SPEED_PRIOR, COURSE_PRIOR, life.turn_rate),
    };
    let mut x = State::new(0.0, 0.0, 0.0, if life.placeholders { 360.0 } else { 0.0 }, 0.0);
    let mut p =
        Matrix::from_diagonal(&State::new(0.0, 0.0, speed * speed, course * course, rate * rate));
    let variances = measured.variances();
    for i in 0..measured.observed {
        x[i] = measured.z[i];
        p[(i, i)] = variances[i];
    }
    (x, p)
}
