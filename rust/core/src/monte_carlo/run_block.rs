//! The data of a block of runs: what is counted, which runs they are, and where sums are written.

use super::batch::Batch;
use std::ops::Range;

/// What is counted and centred, set by the number of dimensions.
#[derive(Debug, Clone, Copy)]
pub struct Levels<'a> {
    /// The expectation of 10 log10 q for a consistent filter.
    pub decibels: f64,
    /// Quantiles of q for a consistent filter.
    pub thresholds: &'a [f64],
}

/// Runs whose number is a power of two, and the first a multiple of it.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub(super) batch: &'a Batch<'a>,
    /// The place of the first run in the batch.
    pub(super) first: usize,
    /// How many runs.
    pub(super) runs: usize,
    pub(super) levels: &'a Levels<'a>,
}

/// What is written of a group.
pub(super) struct Output<'a> {
    /// The sums over its runs, columns by steps.
    pub(super) row: &'a mut [f64],
    /// For each run: steps that counted, the sum of q, and the sums of squares.
    pub(super) of_runs: &'a mut [f64],
    /// Added to: for each step the runs that counted, then those under each threshold.
    pub(super) counts: &'a mut [i64],
    /// Added to: for each step the bins.
    pub(super) histogram: &'a mut [i64],
}

impl Group<'_> {
    /// The place of a step among all of the batch.
    #[inline(always)]
    pub(super) fn place(&self, run: usize, step: usize) -> usize {
        (self.first + run) * self.batch.steps + step
    }

    /// What the same run, or its successor in the next group, gives to the lanes next.
    #[inline(always)]
    pub(super) fn next(&self, run: usize, step: usize, lanes: usize) -> Range<usize> {
        let ahead = match step + lanes < self.batch.steps {
            true => self.place(run, step + lanes),
            false => self.place(run + self.runs, 0),
        };
        let all = self.batch.runs * self.batch.steps;
        ahead.min(all)..(ahead + lanes).min(all)
    }
}
