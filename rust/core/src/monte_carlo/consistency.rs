//! What is kept of the errors of a batch of runs to judge whether a filter is honest.
//!
//! For the error e of each run and step, with its covariance P, the columns
//!
//! | column | mean over runs |
//! | --- | --- |
//! | q = e' P^-1 e | ANEES (over the dimension) |
//! | q^2 | spread of NEES |
//! | b = 10 log10 q | inclination: its mean, less what an honest filter expects |
//! | \|b - E b\| | noncredibility index |
//! | e_j, each state | bias |
//! | e_j^2 | RMSE |
//! | e_j / sqrt(P_jj) | normalised mean error |
//!
//! are summed on the tree of run numbers ([`super::tree`]); q is counted under the thresholds of
//! coverage and in the bins of its histogram; and each run gives its own sums over steps, from which
//! settings are compared run by run.
//!
//! References: Bar-Shalom, Li and Kirubarajan (2001), ch. 5.4; Li and Zhao (2006), "Measuring
//! estimator's credibility: noncredibility index", doi:10.1109/ICIF.2006.301770.

use super::batch::Batch;
pub use super::columns::{FORM_COLUMNS, STATE_COLUMNS};
use super::group::Group;
use super::histogram::{BINS, bin};
use super::tree::{Tree, pieces};
use crate::error::Result;
use crate::{simd, threads};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// At most 2^this runs go through the lanes together.
const TOGETHER: u32 = 3;

/// What is counted and centred, set by the number of dimensions.
#[derive(Debug, Clone, Copy)]
pub struct Levels<'a> {
    /// The expectation of 10 log10 q for an honest filter.
    pub decibels: f64,
    /// Quantiles of q for an honest filter.
    pub thresholds: &'a [f64],
}

/// What is kept of a batch.
#[derive(Debug, Default)]
pub struct Sums {
    /// For each canonical node of the runs: q, q^2, b and |b - E b|, each over the steps, then e, e^2
    /// and e / sqrt(P_jj), each over states and steps.
    pub nodes: Vec<f64>,
    /// For each run: steps that counted, the sum of q, and the sum of squares of each state.
    pub runs: Vec<f64>,
    /// Over the steps, the runs that counted; and for each threshold those under it.
    pub counts: Vec<i64>,
    /// For each step the histogram of q.
    pub histogram: Vec<i64>,
}

/// Numbers in the row of a run.
fn width(batch: &Batch<'_>) -> usize {
    batch.steps * (FORM_COLUMNS + STATE_COLUMNS * batch.dimension())
}

/// What is kept of a batch of runs; see the head of this file.
///
/// # Errors
/// [`crate::Error::Length`] for arrays that do not fit together, [`crate::Error::NotFinite`] for a state, and what
/// `quadratic_forms` says of a covariance; each names the first run and step at fault. An innovation
/// of which any component is NaN was not measured and is left out.
pub fn consistency_sums(batch: Batch<'_>, levels: Levels<'_>) -> Result<Sums> {
    batch.check()?;
    let runs = batch.first_run..batch.first_run + batch.runs as u64;
    let mut parts: Vec<_> = pieces(runs, width(&batch))
        .into_iter()
        .map(|runs| Part::new(runs, &batch, &levels))
        .collect();
    threads::fill(&mut parts, 1, |_, parts| {
        parts.iter_mut().try_for_each(|part| part.reduce(&batch, &levels))
    })?;
    Ok(whole(&batch, &levels, parts))
}

fn whole(batch: &Batch<'_>, levels: &Levels<'_>, parts: Vec<Part>) -> Sums {
    let mut all = Part::new(0..0, batch, levels);
    for part in parts {
        all.tree.append(&part.tree);
        all.of_runs.extend_from_slice(&part.of_runs);
        all.counts.iter_mut().zip(&part.counts).for_each(|(sum, &x)| *sum += x);
        all.histogram.iter_mut().zip(&part.histogram).for_each(|(sum, &x)| *sum += x);
    }
    let Part { tree, of_runs, counts, histogram, .. } = all;
    Sums { nodes: tree.into_sums(), runs: of_runs, counts, histogram }
}

/// A piece of the runs, reduced by one thread.
struct Part {
    runs: Range<u64>,
    tree: Tree,
    of_runs: Vec<f64>,
    counts: Vec<i64>,
    histogram: Vec<i64>,
}

impl Part {
    fn new(runs: Range<u64>, batch: &Batch<'_>, levels: &Levels<'_>) -> Self {
        Self {
            runs,
            tree: Tree::new(width(batch)),
            of_runs: Vec::new(),
            counts: vec![0; batch.steps * (1 + levels.thresholds.len())],
            histogram: vec![0; batch.steps * BINS],
        }
    }

    fn reduce(&mut self, batch: &Batch<'_>, levels: &Levels<'_>) -> Result<()> {
        let mut forms = Vec::new();
        let mut run = self.runs.start;
        while run < self.runs.end {
            let level = node_level(run, self.runs.end);
            let (first, runs) = ((run - batch.first_run) as usize, 1 << level);
            let group = Group { batch, first, runs, expected: levels.decibels };
            forms.resize(runs * batch.steps, 0.0);
            let from = self.of_runs.len();
            self.of_runs.resize(from + runs * (2 + batch.dimension()), 0.0);
            let of_runs = &mut self.of_runs[from..];
            self.tree.push(run, level, |row| group.reduce(row, of_runs, &mut forms))?;
            let Self { counts, histogram, .. } = self;
            simd::dispatch(Count { forms: &forms, levels: *levels, counts, histogram });
            run += runs as u64;
        }
        Ok(())
    }
}

/// The level of the largest node that begins at `start`, does not pass `stop`, and is worth it.
fn node_level(start: u64, stop: u64) -> u32 {
    start.trailing_zeros().min((stop - start).ilog2()).min(TOGETHER)
}

/// Counts the forms of some runs: those that were measured, those under each threshold, and by bins.
struct Count<'a> {
    forms: &'a [f64],
    levels: Levels<'a>,
    counts: &'a mut [i64],
    histogram: &'a mut [i64],
}

impl WithSimd for Count<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let steps = self.histogram.len() / BINS;
        for forms in self.forms.chunks_exact(steps) {
            count(forms, self.counts, self.levels.thresholds);
            let bins = self.histogram.chunks_exact_mut(BINS).zip(forms);
            bins.filter(|(_, x)| !x.is_nan()).for_each(|(bins, &x)| bins[bin(x)] += 1);
        }
    }
}

#[inline(always)]
fn count(forms: &[f64], counts: &mut [i64], thresholds: &[f64]) {
    let (measured, under) = counts.split_at_mut(forms.len());
    for (n, form) in measured.iter_mut().zip(forms) {
        *n += i64::from(!form.is_nan());
    }
    for (under, &threshold) in under.chunks_exact_mut(forms.len()).zip(thresholds) {
        under.iter_mut().zip(forms).for_each(|(n, &x)| *n += i64::from(x <= threshold));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: Levels<'_> = Levels { decibels: 1.5, thresholds: &[1.0, 4.0] };

    fn batch<'a>(truth: &'a [f64], covariances: &'a [f64], first_run: u64) -> Batch<'a> {
        let runs = truth.len() / 6;
        Batch {
            truth,
            estimates: None,
            covariances,
            runs,
            steps: 3,
            periods: &[0.0, 0.0],
            first_run,
        }
    }

    #[test]
    fn one_run_is_its_own_columns() {
        let truth = [3.0, 4.0, 0.0, 2.0, f64::NAN, 1.0];
        let covariances = [4.0, 0.0, 0.0, 16.0, 1.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        let sums = consistency_sums(batch(&truth, &covariances, 0), LEVELS).unwrap();
        assert_eq!(sums.nodes[..6], [3.25, 1.0, 0.0, 10.5625, 1.0, 0.0]);
        let b = 10.0 * 3.25f64.log10();
        assert!((sums.nodes[6] - b).abs() < 1e-14 && (sums.nodes[9] - (b - 1.5)).abs() < 1e-14);
        assert_eq!(sums.nodes[7..9], [0.0, 0.0]);
        assert_eq!(sums.nodes[10..12], [1.5, 0.0]);
        assert_eq!(sums.nodes[12..18], [3.0, 0.0, 0.0, 4.0, 2.0, 0.0]);
        assert_eq!(sums.nodes[18..24], [9.0, 0.0, 0.0, 16.0, 4.0, 0.0]);
        assert_eq!(sums.nodes[24..], [1.5, 0.0, 0.0, 1.0, 1.0, 0.0]);
        assert_eq!(sums.runs, [2.0, 4.25, 9.0, 20.0]);
        assert_eq!(sums.counts, [1, 1, 0, 0, 1, 0, 1, 1, 0]);
        assert_eq!(sums.histogram.iter().sum::<i64>(), 2);
        assert_eq!(sums.histogram[bin(3.25)], 1);
    }

    #[test]
    fn the_run_at_fault_is_named() {
        let truth = [1.0; 60];
        let mut covariances: Vec<f64> = [1.0, 0.0, 0.0, 1.0].repeat(30);
        covariances[4 * 17] = -1.0;
        let error = consistency_sums(batch(&truth, &covariances, 5), LEVELS).unwrap_err();
        assert!(error.to_string().starts_with("innovation_covariances[5][2] is not positive"));
        let mut truth = truth;
        truth[6 * 4 + 3] = f64::INFINITY;
        let error = consistency_sums(batch(&truth, &covariances, 5), LEVELS).unwrap_err();
        assert_eq!(error.to_string(), "innovations[4][1][1] is not finite: inf");
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let error = consistency_sums(batch(&[0.0; 6], &[0.0; 11], 0), LEVELS).unwrap_err();
        assert_eq!(error.to_string(), "innovation_covariances has 11 numbers, innovations has 12");
        let none = Batch { periods: &[], ..batch(&[], &[], 0) };
        assert!(consistency_sums(none, LEVELS).is_err());
    }
}
