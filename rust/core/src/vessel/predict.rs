//! Many states carried forward, each by its own time.

use super::motion::{Matrix, Motion, STATES, State};
use crate::error::{Error, Result};

/// Elements of a covariance.
pub(crate) const SQUARE: usize = STATES * STATES;

impl Motion {
    /// Refuses densities below zero and a time constant that is not positive.
    pub(crate) fn check(&self) -> Result<()> {
        for (argument, value) in
            [("acceleration", self.acceleration), ("turn", self.turn), ("course", self.course)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Parameter {
                    argument,
                    requirement: "at least 0 and finite",
                    value,
                });
            }
        }
        let (argument, requirement, value) = ("decay", "positive", self.decay);
        if value > 0.0 { Ok(()) } else { Err(Error::Parameter { argument, requirement, value }) }
    }
}

/// States and covariances as flat arrays: `(n, 5)` and `(n, 5, 5)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// The states.
    pub x: Vec<f64>,
    /// Their covariances.
    pub p: Vec<f64>,
    /// The Jacobians.
    pub f: Vec<f64>,
}

/// Predicts every state by its time, with covariance and Jacobian.
///
/// # Errors
/// Where lengths differ, a value is not finite or a time is negative.
pub fn predict(x: &[f64], p: &[f64], times: &[f64], motion: &Motion) -> Result<Predicted> {
    check(x, p, times, motion)?;
    let n = times.len();
    let (mut xs, mut ps, mut fs) = (
        Vec::with_capacity(x.len()),
        Vec::with_capacity(n * SQUARE),
        Vec::with_capacity(n * SQUARE),
    );
    for ((x, p), &time) in x.chunks_exact(STATES).zip(p.chunks_exact(SQUARE)).zip(times) {
        let (x, p) = (State::from_column_slice(x), Matrix::from_row_slice(p));
        let at = motion.predict(&x, &p, time);
        xs.extend_from_slice(at.x.as_slice());
        ps.extend_from_slice(at.p.as_slice());
        fs.extend_from_slice(at.f.transpose().as_slice());
    }
    Ok(Predicted { x: xs, p: ps, f: fs })
}

/// Advances every state by its time, without noise.
///
/// # Errors
/// As [`predict`].
pub fn advance(x: &[f64], times: &[f64], motion: &Motion) -> Result<Vec<f64>> {
    check_states(x, times, motion)?;
    let mut output = Vec::with_capacity(x.len());
    for (x, &time) in x.chunks_exact(STATES).zip(times) {
        output.extend_from_slice(motion.advance(&State::from_column_slice(x), time).as_slice());
    }
    Ok(output)
}

fn length(argument: &'static str, found: usize, expected: usize) -> Error {
    Error::Length { argument, found, other: "times", expected, unit: "states" }
}

/// Refuses what [`predict`] cannot take.
pub(crate) fn check(x: &[f64], p: &[f64], times: &[f64], motion: &Motion) -> Result<()> {
    check_states(x, times, motion)?;
    if p.len() != times.len() * SQUARE {
        return Err(length("P", p.len() / SQUARE, times.len()));
    }
    match p.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::NotFinite { argument: "P", index: vec![i / SQUARE], value: p[i] }),
    }
}

fn check_states(x: &[f64], times: &[f64], motion: &Motion) -> Result<()> {
    motion.check()?;
    if x.len() != times.len() * STATES {
        return Err(length("x", x.len() / STATES, times.len()));
    }
    if let Some(i) = x.iter().position(|v| !v.is_finite()) {
        let index = vec![i / STATES, i % STATES];
        return Err(Error::NotFinite { argument: "x", index, value: x[i] });
    }
    match times.iter().position(|t| !(*t >= 0.0 && t.is_finite())) {
        None => Ok(()),
        Some(i) => Err(Error::Element {
            argument: "times",
            index: vec![i],
            requirement: "at least 0 and finite",
            value: times[i],
        }),
    }
}
