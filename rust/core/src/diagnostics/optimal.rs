//! The optimal partitions of one sequence, by dynamic programming over its last segment.
//!
//! best(s, b) = max over a of best(s - 1, a) - M(a, b) ln(N(a, b) / M(a, b)),
//!
//! as in `segmentation`. The arrays over the beginnings a are filled up to a whole number of
//! `MAX_LANES`, so that no loop has a rest. Only best is kept: where the last segment of best(s, b)
//! begins is asked for few b, and found by evaluating that row again. Ties go to the earlier cut.

use super::likelihood::best;
use super::partitions::Partitions;
use crate::simd::MAX_LANES;
use pulp::{Simd, WithSimd};

/// Buffers that sequences share: one number for each beginning.
#[derive(Default)]
pub(super) struct Work {
    /// Sum of the values from each beginning on, and of their degrees of freedom.
    sums: Vec<f64>,
    dofs: Vec<f64>,
    /// The likelihood of the segment from each beginning on; -infinity where it is too short.
    row: Vec<f64>,
    /// best(s, b), a row for each s.
    best: Vec<Vec<f64>>,
}

impl Work {
    fn reset(&mut self, n: usize, most: usize) {
        let size = (n + 1).next_multiple_of(MAX_LANES);
        self.best.resize_with(most, Vec::new);
        for best in &mut self.best {
            best.clear();
            best.resize(size, f64::NEG_INFINITY);
        }
        for column in [&mut self.sums, &mut self.dofs, &mut self.row] {
            column.clear();
            column.resize(size, 0.0);
        }
    }

    /// The likelihood of the segments that end at `end`, from the sums of each.
    #[inline(always)]
    fn evaluate(&mut self, end: usize, least: usize) {
        let size = end.next_multiple_of(MAX_LANES);
        let sums = self.sums[..size].iter().zip(&self.dofs[..size]);
        for (row, (sum, dof)) in self.row[..size].iter_mut().zip(sums) {
            *row = best(*sum, *dof);
        }
        self.row[(end + 1).saturating_sub(least)..size].fill(f64::NEG_INFINITY);
    }

    /// The largest of best(s, a) plus the row, over every beginning a before `end`.
    #[inline(always)]
    fn largest<S: Simd>(&self, simd: S, s: usize, end: usize) -> f64 {
        let size = end.next_multiple_of(MAX_LANES);
        let (best, _) = S::as_simd_f64s(&self.best[s][..size]);
        let (row, _) = S::as_simd_f64s(&self.row[..size]);
        let lowest = simd.splat_f64s(f64::NEG_INFINITY);
        let sums = best.iter().zip(row).map(|(best, row)| simd.add_f64s(*best, *row));
        simd.reduce_max_f64s(sums.fold(lowest, |largest, sum| simd.max_f64s(largest, sum)))
    }

    /// The first beginning at which that largest sum stands.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, s: usize, end: usize) -> usize {
        let largest = self.largest(simd, s, end);
        let mut sums = self.best[s].iter().zip(&self.row).map(|(best, row)| best + row);
        sums.position(|sum| sum >= largest).unwrap_or(0)
    }
}

/// The best partitions of a sequence into 1 to `most` segments of `least` values or more.
pub(super) struct Optimal<'a> {
    pub(super) values: &'a [f64],
    pub(super) dof: &'a [f64],
    pub(super) least: usize,
    pub(super) most: usize,
    pub(super) work: &'a mut Work,
}

impl WithSimd for Optimal<'_> {
    type Output = Partitions;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Partitions {
        let (n, least, most) = (self.values.len(), self.least, self.most);
        self.work.reset(n, most);
        self.forward(simd);
        let feasible = |s: usize| n > 0 && n >= (s + 1) * least;
        let gain = |s: usize| match s {
            0 => 0.0,
            s if feasible(s) => self.work.best[s][n] - self.work.best[0][n],
            _ => f64::NEG_INFINITY,
        };
        let gains = (0..most).map(gain).collect();
        let cuts = |s: usize| if feasible(s) { self.cuts(simd, s) } else { vec![] };
        Partitions { gains, cuts: (0..most).map(cuts).collect() }
    }
}

impl Optimal<'_> {
    #[inline(always)]
    fn forward<S: Simd>(&mut self, simd: S) {
        let Self { values, dof, least, most, work } = self;
        for end in 1..=values.len() {
            // Sums are kept for every beginning and grow by one value, rather than differences of
            // cumulative sums: after a huge value a difference has lost the small ones.
            grow(simd, &mut work.sums, values[end - 1], end);
            grow(simd, &mut work.dofs, dof[end - 1], end);
            if end < *least {
                continue;
            }
            work.evaluate(end, *least);
            work.best[0][end] = work.row[0];
            for s in 1..*most {
                work.best[s][end] = work.largest(simd, s - 1, end);
            }
        }
    }

    /// Where the second and later of `s` + 1 segments of the whole sequence begin.
    #[inline(always)]
    fn cuts<S: Simd>(&mut self, simd: S, s: usize) -> Vec<usize> {
        let mut cuts = vec![0; s];
        let mut end = self.values.len();
        for level in (1..=s).rev() {
            sum_up_to(&mut self.work.sums, &self.values[..end]);
            sum_up_to(&mut self.work.dofs, &self.dof[..end]);
            self.work.evaluate(end, self.least);
            end = self.work.place(simd, level - 1, end);
            cuts[level - 1] = end;
        }
        cuts
    }
}

/// Adds a value to the sum of every beginning before `end`.
#[inline(always)]
fn grow<S: Simd>(simd: S, sums: &mut [f64], value: f64, end: usize) {
    let size = end.next_multiple_of(MAX_LANES);
    let added = simd.splat_f64s(value);
    let (vectors, _) = S::as_mut_simd_f64s(&mut sums[..size]);
    for sums in vectors {
        *sums = simd.add_f64s(*sums, added);
    }
    sums[end..size].fill(0.0);
}

/// Sums from each beginning to the end.
fn sum_up_to(sums: &mut [f64], values: &[f64]) {
    let mut sum = 0.0;
    for (sum_from, value) in sums.iter_mut().zip(values).rev() {
        sum += value;
        *sum_from = sum;
    }
}
