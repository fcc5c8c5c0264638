//! What is kept of the errors of a batch of runs to judge whether a filter is consistent.
//!
//! For the error e of each run and step, with its covariance P, the columns
//!
//! | column | mean over runs |
//! | --- | --- |
//! | q = e' P^-1 e | ANEES (over the dimension) |
//! | q^2 | spread of NEES |
//! | b = 10 log10 q | inclination: its mean, less what a consistent filter expects |
//! | \|b - E b\| | noncredibility index |
//! | e_j, each state | bias |
//! | e_j^2 | RMSE |
//! | e_j / sqrt(P_jj) | normalised mean error |
//!
//! are summed on the tree of run numbers ([`super::pairwise_tree`]); q is counted under the thresholds of
//! coverage and in the bins of its histogram; and each run gives its own sums over steps, from which
//! settings are compared run by run.
//!
//! References: Bar-Shalom, Li and Kirubarajan (2001), ch. 5.4; Li and Zhao (2006), "Measuring
//! estimator's credibility: noncredibility index", doi:10.1109/ICIF.2006.301770.

use super::batch::Batch;
pub use super::elementwise::{FORM_COLUMNS, STATE_COLUMNS};
use super::histogram::BINS;
use super::pairwise_tree::{Tree, pieces};
use super::reduce::{reduce, runs_together};
pub use super::run_block::Levels;
use super::run_block::{Group, Output};
use crate::error::Result;
use crate::threads;
use std::ops::Range;

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
        let Self { tree, of_runs, counts, histogram, .. } = self;
        let mut run = self.runs.start;
        while run < self.runs.end {
            let runs = runs_together(run, self.runs.end, batch.dimension());
            let first = (run - batch.first_run) as usize;
            let group = Group { batch, first, runs, levels };
            let from = of_runs.len();
            of_runs.resize(from + runs * (2 + batch.dimension()), 0.0);
            let of_runs = &mut of_runs[from..];
            tree.push(run, runs.ilog2(), |row| {
                reduce(
                    group,
                    Output { row, of_runs, counts: &mut *counts, histogram: &mut *histogram },
                )
            })?;
            run += runs as u64;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::histogram::bin;
    use super::super::pairwise_tree::run_sums;
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

    /// Errors and covariances L D L' whose forms are exact with and without fused operations: some
    /// were not measured, some covariances are in doubt.
    fn exact(runs: usize, steps: usize, d: usize) -> (Vec<f64>, Vec<f64>) {
        let hash = |i: usize| (i.wrapping_mul(2_654_435_761) >> 7) % 1000;
        let mut truth: Vec<f64> = (0..runs * steps * d).map(|i| hash(i) as f64 - 500.0).collect();
        let mut covariances = Vec::new();
        for k in 0..runs * steps {
            let pivot = |j: usize| if hash(k + j) < 20 { 2f64.powi(-38) } else { 2.0 };
            let lower = |i: usize, j: usize| if i == j { 1.0 } else { (hash(k) % 3) as f64 };
            for (i, j) in (0..d * d).map(|at| (at / d, at % d)) {
                let term = |m| lower(i, m) * pivot(m) * lower(j, m);
                covariances.push((0..=i.min(j)).map(term).sum());
            }
            if hash(k + 17) < 50 {
                truth[k * d + k % d] = f64::NAN;
            }
        }
        (truth, covariances)
    }

    #[test]
    fn a_group_has_the_bits_of_its_runs() {
        let (runs, steps) = (23, 13);
        for d in [1, 2, 3, 4, 5, 9, 10] {
            let (truth, covariances) = exact(runs, steps, d);
            let mut periods = vec![0.0; d];
            periods[d - 1] = 512.0;
            let sums = |first: usize, runs: usize| {
                let states = first * steps * d..(first + runs) * steps * d;
                let batch = Batch {
                    truth: &truth[states.clone()],
                    estimates: None,
                    covariances: &covariances[states.start * d..states.end * d],
                    runs,
                    steps,
                    periods: &periods,
                    first_run: first as u64 + 3,
                };
                consistency_sums(batch, LEVELS).unwrap()
            };
            let (whole, width) = (sums(0, runs), steps * (FORM_COLUMNS + STATE_COLUMNS * d));
            let alone: Vec<_> = (0..runs).map(|run| sums(run, 1)).collect();
            let rows: Vec<f64> = alone.iter().flat_map(|one| one.nodes.clone()).collect();
            assert_eq!(whole.nodes, run_sums(&rows, width, 3).unwrap(), "{d}");
            assert!(alone.iter().flat_map(|one| &one.runs).eq(&whole.runs), "{d}");
            for (i, &count) in whole.counts.iter().enumerate() {
                assert_eq!(alone.iter().map(|one| one.counts[i]).sum::<i64>(), count, "{d}");
            }
            assert_eq!(whole.histogram.iter().sum::<i64>(), whole.counts[..steps].iter().sum());
            assert!(whole.counts[..steps].iter().sum::<i64>() < (runs * steps) as i64);
        }
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
