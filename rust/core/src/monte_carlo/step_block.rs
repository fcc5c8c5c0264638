//! As many steps as a vector has lanes, of `R` runs with `D` states: what is added up and counted.

use super::batch::Batch;
use super::elementwise::{FORM_COLUMNS, STATE_COLUMNS, decibels, wrap};
use super::histogram::{BINS, bin};
use super::run_block::Group;
use crate::consistency::batched_ldl::Block;
use crate::simd::MAX_LANES;
use crate::simd::transpose::{Load, lanes, store};
use pulp::{Simd, bytemuck};

/// Starts a cache line: a vector across two lines costs twice.
#[repr(align(64))]
pub(super) struct Tile<S: Simd, const D: usize, const R: usize> {
    /// Of each run and state.
    errors: [[S::f64s; D]; R],
    variances: [[S::f64s; D]; R],
    /// q of each run; NaN where nothing was measured, and for the runs that the group does not have.
    forms: [S::f64s; R],
    /// The lanes of each run that count.
    counted: [S::m64s; R],
    /// The lanes that hold a step.
    within: S::m64s,
    /// The first step.
    step: usize,
    /// How many lanes hold a step.
    count: usize,
}

impl<S: Simd, const D: usize, const R: usize> Tile<S, D, R> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let (zero, nan) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::NAN));
        let none = simd.less_than_f64s(zero, zero);
        let (errors, counted) = ([[zero; D]; R], [none; R]);
        let forms = [nan; R];
        Self { errors, variances: errors, forms, counted, within: none, step: 0, count: 0 }
    }

    /// The next steps.
    #[inline(always)]
    pub(super) fn go_to(&mut self, simd: S, step: usize, count: usize) {
        (self.step, self.count) = (step, count);
        let mut numbers = simd.splat_f64s(0.0);
        lanes(&mut numbers).iter_mut().enumerate().for_each(|(l, x)| *x = l as f64);
        self.within = simd.less_than_f64s(numbers, simd.splat_f64s(count as f64));
    }

    /// Loads the steps of a run, and computes their forms.
    #[inline(always)]
    pub(super) fn load<L: Load<S>>(
        &mut self,
        simd: S,
        load: L,
        block: &mut Block<S, L, D>,
        group: &Group<'_>,
        run: usize,
    ) {
        let Batch { truth, estimates, covariances, periods, .. } = *group.batch;
        let at = group.place(run, self.step);
        let next = group.next(run, self.step, S::F64_LANES);
        let here = estimates.map(|values| &values[at * D..]);
        block.load_residuals(&truth[at * D..], here, self.count);
        block.load_covariances(&covariances[at * D * D..], self.count);
        wrap(block.residuals(), periods);
        self.errors[run] = *block.residuals();
        self.variances[run] = block.variances();
        load.fetch(simd, &truth[next.start * D..next.end * D]);
        if let Some(estimates) = estimates {
            load.fetch(simd, &estimates[next.start * D..next.end * D]);
        }
        self.forms[run] = block.own(&covariances[next.start * D * D..next.end * D * D]);
    }

    /// Whether a form is NaN though something was measured.
    #[inline(always)]
    pub(super) fn is_doubtful(&self, simd: S, group: &Group<'_>) -> bool {
        let zero = simd.splat_f64s(0.0);
        let mut total = zero;
        for &form in &self.forms[..group.runs] {
            total = simd.add_f64s(total, simd.select_f64s(self.within, form, zero));
        }
        let doubtful = !simd.reduce_sum_f64s(total).is_finite();
        doubtful && (group.batch.estimates.is_some() || self.measured_is_nan(group.runs))
    }

    #[cold]
    fn measured_is_nan(&self, runs: usize) -> bool {
        let is_nan = |mut vector: S::f64s, l: usize| lanes(&mut vector)[l].is_nan();
        (0..runs).any(|run| {
            (0..self.count).any(|l| {
                is_nan(self.forms[run], l) && !self.errors[run].iter().any(|&e| is_nan(e, l))
            })
        })
    }

    /// Takes the forms of the group that were computed with every check.
    #[cold]
    pub(super) fn settle(&mut self, settled: &[f64], steps: usize) {
        for (forms, settled) in self.forms.iter_mut().zip(settled.chunks_exact(steps)) {
            let settled = &settled[self.step..self.step + self.count];
            lanes(forms)[..self.count].copy_from_slice(settled);
        }
    }

    /// The steps whose forms are numbers.
    #[inline(always)]
    pub(super) fn decide_what_counts(&mut self, simd: S) {
        for (counted, &form) in self.counted.iter_mut().zip(&self.forms) {
            *counted = simd.and_m64s(self.within, simd.equal_f64s(form, form));
        }
    }

    /// Writes q, q^2, b and |b - E b|.
    #[inline(always)]
    pub(super) fn write_forms(&self, simd: S, expected: f64, row: &mut [f64], steps: usize) {
        let mut columns = [[simd.splat_f64s(0.0); R]; FORM_COLUMNS];
        for (run, &form) in self.forms.iter().enumerate() {
            let b = decibels(form);
            let distance = simd.abs_f64s(simd.sub_f64s(b, simd.splat_f64s(expected)));
            columns[0][run] = form;
            columns[1][run] = simd.mul_f64s(form, form);
            columns[2][run] = b;
            columns[3][run] = distance;
        }
        for (i, column) in columns.into_iter().enumerate() {
            self.write(simd, i, column, row, steps);
        }
    }

    /// Writes e, e^2 and e / sqrt(P_jj) of each state.
    #[inline(always)]
    pub(super) fn write_states(&self, simd: S, row: &mut [f64], steps: usize) {
        for j in 0..D {
            let mut columns = [[simd.splat_f64s(0.0); R]; STATE_COLUMNS];
            for (run, (errors, variances)) in self.errors.iter().zip(&self.variances).enumerate() {
                let (e, variance) = (errors[j], variances[j]);
                columns[0][run] = e;
                columns[1][run] = simd.mul_f64s(e, e);
                columns[2][run] = simd.div_f64s(e, simd.sqrt_f64s(variance));
            }
            for (block, column) in columns.into_iter().enumerate() {
                self.write(simd, FORM_COLUMNS + block * D + j, column, row, steps);
            }
        }
    }

    /// Writes the sum of a column over the runs, halves first.
    #[inline(always)]
    fn write(&self, simd: S, column: usize, mut runs: [S::f64s; R], row: &mut [f64], steps: usize) {
        let zero = simd.splat_f64s(0.0);
        for (x, &counted) in runs.iter_mut().zip(&self.counted) {
            // Runs that the group does not have add 0, which leaves everything but -0 as it is.
            *x = simd.add_f64s(simd.select_f64s(counted, *x, zero), zero);
        }
        let mut nodes = R;
        while nodes > 1 {
            nodes /= 2;
            for i in 0..nodes {
                runs[i] = simd.add_f64s(runs[2 * i], runs[2 * i + 1]);
            }
        }
        store(runs[0], &mut row[column * steps + self.step..][..self.count]);
    }

    /// Counts the runs of each step, and those whose form is under each threshold.
    #[inline(always)]
    pub(super) fn count_under(
        &self,
        simd: S,
        thresholds: &[f64],
        counts: &mut [i64],
        steps: usize,
    ) {
        let (zero, one) = (simd.splat_u64s(0), simd.splat_u64s(1));
        let levels = std::iter::once(&f64::INFINITY).chain(thresholds);
        for (counts, &threshold) in counts.chunks_exact_mut(steps).zip(levels) {
            let (threshold, mut under) = (simd.splat_f64s(threshold), zero);
            for &form in &self.forms {
                let is_under = simd.less_than_or_equal_f64s(form, threshold);
                under = simd.add_u64s(under, simd.select_u64s(is_under, one, zero));
            }
            let under = [under];
            let under: &[i64] = bytemuck::cast_slice(&under);
            let counts = &mut counts[self.step..self.step + self.count];
            counts.iter_mut().zip(under).for_each(|(n, x)| *n += x);
        }
    }

    /// Counts the forms of the runs by bins.
    #[inline(always)]
    pub(super) fn count_bins(&mut self, runs: usize, histogram: &mut [i64]) {
        for forms in &mut self.forms[..runs] {
            let forms = &lanes(forms)[..self.count];
            for (histogram, &form) in histogram.chunks_exact_mut(BINS).zip(forms) {
                histogram[bin(form)] += i64::from(!form.is_nan());
            }
        }
    }
}

/// For each run the number of steps that counted, the sum of q, and of the squares of each state.
///
/// Over steps that are `MAX_LANES` apart first, so that the order is the same for every width.
pub(super) struct RunSums<S: Simd, const D: usize, const R: usize> {
    /// For each run and part of the steps.
    forms: Vec<[S::f64s; 2]>,
    squares: Vec<[S::f64s; D]>,
}

impl<S: Simd, const D: usize, const R: usize> RunSums<S, D, R> {
    const PARTS: usize = MAX_LANES / S::F64_LANES;

    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let (zero, parts) = (simd.splat_f64s(0.0), R * Self::PARTS);
        Self { forms: vec![[zero; 2]; parts], squares: vec![[zero; D]; parts] }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, tile: &Tile<S, D, R>) {
        let (zero, part) = (simd.splat_f64s(0.0), tile.step % MAX_LANES / S::F64_LANES);
        for run in 0..R {
            let counted = tile.counted[run];
            let [count, form] = &mut self.forms[run * Self::PARTS + part];
            *count = simd.add_f64s(*count, simd.select_f64s(counted, simd.splat_f64s(1.0), zero));
            *form = simd.add_f64s(*form, simd.select_f64s(counted, tile.forms[run], zero));
            let squares = &mut self.squares[run * Self::PARTS + part];
            for (sum, e) in squares.iter_mut().zip(tile.errors[run]) {
                let e = simd.select_f64s(counted, e, zero);
                *sum = simd.add_f64s(*sum, simd.mul_f64s(e, e));
            }
        }
    }

    pub(super) fn finish(&self, of_runs: &mut [f64]) {
        let parts = self.forms.chunks_exact(Self::PARTS);
        let parts = parts.zip(self.squares.chunks_exact(Self::PARTS));
        for (sums, (forms, squares)) in of_runs.chunks_exact_mut(2 + D).zip(parts) {
            for i in 0..2 {
                sums[i] = pairwise(|part| forms[part][i]);
            }
            for j in 0..D {
                sums[2 + j] = pairwise(|part| squares[part][j]);
            }
        }
    }
}

/// The sum of the lanes of the parts.
fn pairwise<V: bytemuck::Pod>(part: impl Fn(usize) -> V) -> f64 {
    let size = lanes(&mut part(0)).len();
    let x = |k: usize| lanes(&mut part(k / size))[k % size];
    ((x(0) + x(1)) + (x(2) + x(3))) + ((x(4) + x(5)) + (x(6) + x(7)))
}
