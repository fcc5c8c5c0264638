//! A few runs at once, reduced to one node of the tree while their numbers are in registers.
//!
//! Steps go side by side in the lanes; for as many steps as there are lanes the runs of the group
//! follow each other, and their columns are added pairwise as the tree of run numbers does, so that
//! only the sum of the group is written. What comes out has the same bits for every width of the
//! vectors, and as if each run had been a group of its own.

use super::batch::Batch;
use super::columns::{FORM_COLUMNS, Node, STATE_COLUMNS, Steps, wrap};
use crate::consistency::lanes::{Aligned, Block, widest};
use crate::consistency::quadratic_form::SYMMETRY;
use crate::error::Result;
use crate::lanes::{Load, MOST, WithLanes, dispatch, lanes, store};
use crate::simd::Width;
use pulp::{Simd, bytemuck};
use std::ops::Range;

/// Bytes of a line of the cache.
const LINE: usize = 64;

/// Runs whose number is a power of two, and the first a multiple of it.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub(super) batch: &'a Batch<'a>,
    /// The place of the first run in the batch.
    pub(super) first: usize,
    /// How many runs.
    pub(super) runs: usize,
    /// The expectation of 10 log10 q.
    pub(super) expected: f64,
}

/// What is written of a group.
struct Output<'a> {
    /// The sums over its runs, columns by steps.
    row: &'a mut [f64],
    /// For each run: steps that counted, the sum of q, and the sums of squares.
    of_runs: &'a mut [f64],
    /// q of each run and step, NaN where nothing was measured.
    forms: &'a mut [f64],
}

impl Group<'_> {
    /// Fills the row of the group, the sums of its runs over the steps, and its forms.
    pub(super) fn reduce(
        self,
        row: &mut [f64],
        of_runs: &mut [f64],
        forms: &mut [f64],
    ) -> Result<()> {
        let mut output = Output { row, of_runs, forms };
        if self.fast(&mut output) {
            return Ok(());
        }
        output.forms.copy_from_slice(&self.batch.forms(self.first, self.runs)?);
        dispatch(Settled { group: self, output: &mut output });
        Ok(())
    }

    /// Whether all forms were beyond doubt.
    fn fast(self, output: &mut Output<'_>) -> bool {
        match self.batch.dimension() {
            1 => self.in_lanes::<1>(output),
            2 => self.in_lanes::<2>(output),
            3 => self.in_lanes::<3>(output),
            4 => self.in_lanes::<4>(output),
            5 => self.in_lanes::<5>(output),
            6 => self.in_lanes::<6>(output),
            7 => self.in_lanes::<7>(output),
            8 => self.in_lanes::<8>(output),
            9 => self.in_lanes::<9>(output),
            _ => false,
        }
    }

    fn in_lanes<const D: usize>(self, output: &mut Output<'_>) -> bool {
        dispatch(Fast::<D> { group: self, output });
        // A form in doubt is NaN.
        output.of_runs.chunks_exact(2 + D).all(|sums| sums[1].is_finite())
    }

    /// The place of a step among all of the batch.
    #[inline(always)]
    fn place(&self, run: usize, step: usize) -> usize {
        (self.first + run) * self.batch.steps + step
    }
}

/// Forms and all in one pass, for states of `D` numbers.
struct Fast<'a, 'b, const D: usize> {
    group: Group<'a>,
    output: &'a mut Output<'b>,
}

impl<const D: usize> WithLanes for Fast<'_, '_, D> {
    type Output = ();

    const WIDEST: Width = widest(D);

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) {
        let block = Block::<S, L, D>::new(simd, load, SYMMETRY);
        let [errors, variances] = [(); 2].map(|()| Aligned([simd.splat_f64s(0.0); D]));
        let source = Computed { group: self.group, load, block, errors, variances };
        reduce(simd, source, self.group, D, self.output);
    }
}

/// With forms that were computed before, for states of any number.
struct Settled<'a, 'b> {
    group: Group<'a>,
    output: &'a mut Output<'b>,
}

impl WithLanes for Settled<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, _: L) {
        let d = self.group.batch.dimension();
        let errors = vec![simd.splat_f64s(0.0); d];
        let source = Known { group: self.group, variances: errors.clone(), errors };
        reduce(simd, source, self.group, d, self.output);
    }
}

/// Where errors, variances and forms come from.
trait Source<S: Simd> {
    /// As many steps of a run as `forms` are; the lanes beyond are not to be used. `forms` holds what
    /// was known of them before.
    fn steps(&mut self, simd: S, run: usize, step: usize, forms: &[f64]) -> Steps<'_, S>;
}

/// Errors and covariances are loaded transposed, and the forms computed.
struct Computed<'a, S: Simd, L, const D: usize> {
    group: Group<'a>,
    load: L,
    block: Block<S, L, D>,
    errors: Aligned<[S::f64s; D]>,
    variances: Aligned<[S::f64s; D]>,
}

impl<S: Simd, L: Load<S>, const D: usize> Source<S> for Computed<'_, S, L, D> {
    #[inline(always)]
    fn steps(&mut self, simd: S, run: usize, step: usize, forms: &[f64]) -> Steps<'_, S> {
        let Batch { truth, estimates, covariances, periods, .. } = *self.group.batch;
        let (at, count) = (self.group.place(run, step), forms.len());
        let next = self.next(run, step);
        let estimates_here = estimates.map(|values| &values[at * D..]);
        self.block.load_residuals(&truth[at * D..], estimates_here, count);
        self.block.load_covariances(&covariances[at * D * D..], count);
        wrap(self.block.residuals(), periods);
        self.errors.0 = *self.block.residuals();
        self.variances.0 = self.block.variances();
        self.load.fetch(simd, &truth[next.start * D..next.end * D]);
        if let Some(estimates) = estimates {
            self.load.fetch(simd, &estimates[next.start * D..next.end * D]);
        }
        let forms = self.block.own(&covariances[next.start * D * D..next.end * D * D]);
        let counted = match estimates {
            Some(_) => simd.equal_f64s(simd.splat_f64s(0.0), simd.splat_f64s(0.0)),
            None => measured(simd, &self.errors.0),
        };
        Steps { errors: &self.errors.0, variances: &self.variances.0, forms, counted }
    }
}

impl<S: Simd, L, const D: usize> Computed<'_, S, L, D> {
    /// What the same run, or its successor in the next group, gives to the lanes next.
    #[inline(always)]
    fn next(&self, run: usize, step: usize) -> Range<usize> {
        let Group { batch, runs, .. } = self.group;
        let ahead = match step + S::F64_LANES < batch.steps {
            true => self.group.place(run, step + S::F64_LANES),
            false => self.group.place(run + runs, 0),
        };
        let all = batch.runs * batch.steps;
        ahead.min(all)..(ahead + S::F64_LANES).min(all)
    }
}

/// The lanes in which no error is NaN.
#[inline(always)]
fn measured<S: Simd>(simd: S, errors: &[S::f64s]) -> S::m64s {
    let mut measured = simd.equal_f64s(errors[0], errors[0]);
    for &e in &errors[1..] {
        measured = simd.and_m64s(measured, simd.equal_f64s(e, e));
    }
    measured
}

/// Errors and variances are read one by one.
struct Known<'a, V> {
    group: Group<'a>,
    errors: Vec<V>,
    variances: Vec<V>,
}

impl<S: Simd> Source<S> for Known<'_, S::f64s> {
    #[inline(always)]
    fn steps(&mut self, simd: S, run: usize, step: usize, forms: &[f64]) -> Steps<'_, S> {
        let Batch { truth, estimates, covariances, periods, .. } = *self.group.batch;
        let d = self.errors.len();
        let at = self.group.place(run, step);
        for (l, k) in (at..at + forms.len()).enumerate() {
            for j in 0..d {
                let estimate = estimates.map_or(0.0, |values| values[k * d + j]);
                lanes(&mut self.errors[j])[l] = truth[k * d + j] - estimate;
                lanes(&mut self.variances[j])[l] = covariances[k * d * d + j * (d + 1)];
            }
        }
        wrap(&mut self.errors, periods);
        let mut known = simd.splat_f64s(f64::NAN);
        lanes(&mut known).iter_mut().zip(forms).for_each(|(x, form)| *x = *form);
        let counted = simd.equal_f64s(known, known);
        Steps { errors: &self.errors, variances: &self.variances, forms: known, counted }
    }
}

/// Goes through the steps, and for as many as there are lanes through the runs.
#[inline(always)]
fn reduce<S: Simd>(
    simd: S,
    mut source: impl Source<S>,
    group: Group<'_>,
    d: usize,
    output: &mut Output<'_>,
) {
    let (steps, runs) = (group.batch.steps, group.runs);
    let mut memory = Vec::new();
    let mut sums = Sums::<S>::new(&mut memory, runs, d);
    for step in (0..steps).step_by(S::F64_LANES) {
        let count = S::F64_LANES.min(steps - step);
        let within = first_lanes(simd, count);
        for run in 0..runs {
            let forms = &mut output.forms[run * steps + step..][..count];
            let mut found = source.steps(simd, run, step, forms);
            store(found.forms, forms);
            found.counted = simd.and_m64s(found.counted, within);
            sums.add(simd, run, &found, group.expected);
            sums.add_to_run(simd, run, step, &found);
        }
        for (row, &sum) in output.row.chunks_exact_mut(steps).zip(sums.whole()) {
            store(sum, &mut row[step..step + count]);
        }
    }
    let of_runs = bytemuck::cast_slice::<S::f64s, f64>(sums.of_runs).as_chunks().0;
    output.of_runs.iter_mut().zip(of_runs).for_each(|(sum, parts)| *sum = pairwise(parts));
}

/// What is added up while a group goes through its steps.
struct Sums<'a, S: Simd> {
    /// Columns.
    width: usize,
    /// For each level of the tree the node that waits for its sibling; the last is the whole group.
    nodes: &'a mut [S::f64s],
    /// For each run the steps that count, q and the squares of the errors, each over steps that are
    /// `MOST` apart.
    of_runs: &'a mut [S::f64s],
}

impl<'a, S: Simd> Sums<'a, S> {
    const PARTS: usize = MOST / S::F64_LANES;

    /// In memory whose lines begin where those of the cache do.
    fn new(memory: &'a mut Vec<f64>, runs: usize, d: usize) -> Self {
        let width = FORM_COLUMNS + STATE_COLUMNS * d;
        let nodes = (1 + runs.ilog2() as usize) * width * S::F64_LANES;
        let of_runs = runs * (2 + d) * MOST;
        memory.resize(nodes + of_runs + MOST, 0.0);
        let start = memory.as_ptr().align_offset(LINE).min(MOST);
        let (nodes, rest) = memory[start..].split_at_mut(nodes);
        let of_runs = bytemuck::cast_slice_mut(&mut rest[..of_runs]);
        Self { width, nodes: bytemuck::cast_slice_mut(nodes), of_runs }
    }

    /// Adds the columns of a run to those of the runs before that wait for it.
    #[inline(always)]
    fn add(&mut self, simd: S, run: usize, steps: &Steps<'_, S>, expected: f64) {
        let level = run.trailing_ones() as usize;
        let (waiting, columns) = self.nodes.split_at_mut(level * self.width);
        let node = Node { waiting, columns: &mut columns[..self.width] };
        steps.columns(simd, expected, node);
    }

    /// Adds to the sums of a run over its steps.
    #[inline(always)]
    fn add_to_run(&mut self, simd: S, run: usize, step: usize, steps: &Steps<'_, S>) {
        let d = steps.errors.len();
        let sums = &mut self.of_runs[run * (2 + d) * Self::PARTS..][..(2 + d) * Self::PARTS];
        let part = step % MOST / S::F64_LANES;
        let one = steps.counted_or_zero(simd, simd.splat_f64s(1.0));
        sums[part] = simd.add_f64s(sums[part], one);
        let form = steps.counted_or_zero(simd, steps.forms);
        sums[Self::PARTS + part] = simd.add_f64s(sums[Self::PARTS + part], form);
        for (sums, &e) in sums.chunks_exact_mut(Self::PARTS).skip(2).zip(steps.errors) {
            let square = steps.counted_or_zero(simd, simd.mul_f64s(e, e));
            sums[part] = simd.add_f64s(sums[part], square);
        }
    }

    /// The sums of the whole group.
    fn whole(&self) -> &[S::f64s] {
        &self.nodes[self.nodes.len() - self.width..]
    }
}

/// The first `count` lanes.
#[inline(always)]
fn first_lanes<S: Simd>(simd: S, count: usize) -> S::m64s {
    let mut numbers = simd.splat_f64s(0.0);
    lanes(&mut numbers).iter_mut().enumerate().for_each(|(l, x)| *x = l as f64);
    simd.less_than_f64s(numbers, simd.splat_f64s(count as f64))
}

/// A sum whose order is the same for every width of the vectors.
fn pairwise(x: &[f64; MOST]) -> f64 {
    ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]))
}
