//! A batch of runs as it comes, and the quadratic forms of some of them with every check.

use crate::arrays::Array;
use crate::consistency::quadratic_form::{Residuals, Rules, quadratic_forms};
use crate::error::{Error, Result};
use std::ops::Range;

/// The errors of a batch of runs.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// True states, `(runs, steps, d)`; innovations where there are no estimates.
    pub truth: &'a [f64],
    /// Estimates of the same shape.
    pub estimates: Option<&'a [f64]>,
    /// Covariances, `(runs, steps, d, d)`.
    pub covariances: &'a [f64],
    /// How many runs.
    pub runs: usize,
    /// Steps of each run.
    pub steps: usize,
    /// The period of each state that is an angle, 0 for the others.
    pub periods: &'a [f64],
    /// The number of the first run.
    pub first_run: u64,
}

impl Batch<'_> {
    pub(super) fn dimension(&self) -> usize {
        self.periods.len()
    }

    /// Innovations may be missing, where nothing was measured; states may not.
    fn arguments(&self) -> (&'static str, &'static str) {
        match self.estimates {
            Some(_) => ("truth", "covariances"),
            None => ("innovations", "innovation_covariances"),
        }
    }

    /// # Errors
    /// [`Error::Length`] where the arrays do not fit together, [`Error::Parameter`] without states.
    pub(super) fn check(&self) -> Result<()> {
        let (truth, covariances) = self.arguments();
        let d = self.dimension();
        if d * self.steps == 0 {
            let (argument, requirement) = (truth, "of at least one step and one dimension");
            return Err(Error::Parameter { argument, requirement, value: 0.0 });
        }
        let states = self.runs * self.steps * d;
        require(truth, self.truth.len(), "runs, steps and states", states)?;
        if let Some(estimates) = self.estimates {
            require("estimates", estimates.len(), truth, states)?;
        }
        require(covariances, self.covariances.len(), truth, states * d)
    }

    /// Where the states of some runs stand.
    fn states(&self, first: usize, runs: usize) -> Range<usize> {
        let size = self.steps * self.dimension();
        first * size..(first + runs) * size
    }

    /// Where their covariances stand.
    fn matrices(&self, first: usize, runs: usize) -> Range<usize> {
        let states = self.states(first, runs);
        states.start * self.dimension()..states.end * self.dimension()
    }

    /// The forms of some runs, NaN for what was not measured.
    pub(super) fn forms(&self, first: usize, runs: usize) -> Result<Vec<f64>> {
        let (truth, covariances) =
            (&self.truth[self.states(first, runs)], &self.covariances[self.matrices(first, runs)]);
        let forms = match self.estimates {
            Some(estimates) => {
                let estimates = Some(&estimates[self.states(first, runs)]);
                self.quadratic_forms(truth, estimates, covariances)
            }
            None if truth.iter().any(|x| x.is_nan()) => self.measured_forms(truth, covariances),
            None => self.quadratic_forms(truth, None, covariances),
        };
        forms.map_err(|error| later(error, first))
    }

    fn quadratic_forms(
        &self,
        truth: &[f64],
        estimates: Option<&[f64]>,
        covariances: &[f64],
    ) -> Result<Vec<f64>> {
        let (d, steps) = (self.dimension(), self.steps);
        let states = [truth.len() / (steps * d), steps, d];
        let matrices = [states[0], steps, d, d];
        let arguments = self.arguments();
        let truth = Array::new(arguments.0, truth, &states)?;
        let residuals = match estimates {
            None => Residuals::Given(truth),
            Some(estimates) => {
                Residuals::Between { truth, estimate: Array::new("estimates", estimates, &states)? }
            }
        };
        let covariances = Array::new(arguments.1, covariances, &matrices)?;
        let angles = self.periods.iter().any(|&period| period > 0.0);
        let periods = if angles { self.periods } else { &[] };
        let rules = Rules { periods, ..Rules::default() };
        let mut forms = quadratic_forms(residuals, covariances, &rules)?;
        // Where finite numbers overflow.
        forms.iter_mut().filter(|form| form.is_nan()).for_each(|form| *form = f64::INFINITY);
        Ok(forms)
    }

    /// The forms of what was measured, NaN for the others; these are computed as zeros with a unit
    /// covariance, so that what stands there does not matter.
    fn measured_forms(&self, innovations: &[f64], covariances: &[f64]) -> Result<Vec<f64>> {
        let d = self.dimension();
        let (mut errors, mut covariances) = (innovations.to_vec(), covariances.to_vec());
        let mut missing = Vec::with_capacity(errors.len() / d);
        for (e, p) in errors.chunks_exact_mut(d).zip(covariances.chunks_exact_mut(d * d)) {
            let absent = e.iter().any(|x| x.is_nan());
            missing.push(absent);
            if absent {
                e.fill(0.0);
                p.fill(0.0);
                p.iter_mut().step_by(d + 1).for_each(|x| *x = 1.0);
            }
        }
        let mut forms = self.quadratic_forms(&errors, None, &covariances)?;
        let absent = forms.iter_mut().zip(&missing).filter(|(_, missing)| **missing);
        absent.for_each(|(form, _)| *form = f64::NAN);
        Ok(forms)
    }
}

/// The error of a run that is this many runs later in the batch.
fn later(mut error: Error, first: usize) -> Error {
    if let Error::NotFinite { index, .. }
    | Error::NotSymmetric { index, .. }
    | Error::NotPositiveDefinite { index, .. } = &mut error
        && let Some(run) = index.first_mut()
    {
        *run += first;
    }
    error
}

fn require(
    argument: &'static str,
    found: usize,
    other: &'static str,
    expected: usize,
) -> Result<()> {
    match found == expected {
        true => Ok(()),
        false => Err(Error::Length { argument, found, other, expected, unit: "numbers" }),
    }
}
