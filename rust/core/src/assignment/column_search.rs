//! What a search over the columns of a cost matrix keeps of each, and its two passes over them, in
//! lanes.
//!
//! A pass does for every column, in lanes, what the definition does one column after another: each
//! number comes from the same operations in the same order (and never from a fused one), so that
//! its bits do not depend on the width.

use crate::simd::{LANE, MAX_LANES, lower, raise};
use pulp::Simd;
use std::ops::{Deref, DerefMut};

/// One number of each kind for each column.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// Dual of the column, `v`; minus infinity closes a column: nothing is lower than infinity.
    pub dual: Aligned,
    /// The length of the shortest path found so far; infinity once the column is reached.
    pub distance: Aligned,
    /// How many columns were reached when that path was found: it leads through the last of them.
    pub via: Aligned,
    /// Of columns at the same distance the one of the lowest rank is the nearest.
    pub rank: Aligned,
}

impl Columns {
    /// Starts afresh with `columns` columns; all but the duals are the caller's to write.
    pub fn reset(&mut self, columns: usize) {
        let padded = columns.next_multiple_of(MAX_LANES);
        for values in [&mut self.dual, &mut self.distance, &mut self.via, &mut self.rank] {
            values.resize(padded);
        }
        let (duals, padding) = self.dual.split_at_mut(columns);
        duals.fill(0.0);
        padding.fill(f64::NEG_INFINITY);
        // A pass ends with the last vector that holds a column. Where vectors are narrower than the
        // padding, those behind it keep what an earlier, larger problem left: never the least.
        self.distance[columns..].fill(f64::INFINITY);
    }

    /// All of them as vectors.
    #[inline(always)]
    pub fn vectors<S: Simd>(&mut self) -> Vectors<'_, S> {
        Vectors {
            dual: S::as_mut_simd_f64s(&mut self.dual).0,
            distance: S::as_mut_simd_f64s(&mut self.distance).0,
            via: S::as_mut_simd_f64s(&mut self.via).0,
            rank: S::as_mut_simd_f64s(&mut self.rank).0,
        }
    }
}

/// The same for the time of a search.
pub(super) struct Vectors<'a, S: Simd> {
    dual: &'a mut [S::f64s],
    distance: &'a mut [S::f64s],
    via: &'a mut [S::f64s],
    rank: &'a mut [S::f64s],
}

/// Numbers of which the first stands at the beginning of a cache line, so that no vector of them
/// straddles two.
#[derive(Debug, Default)]
pub(super) struct Aligned {
    values: Vec<f64>,
    first: usize,
    length: usize,
}

impl Aligned {
    fn resize(&mut self, length: usize) {
        const LINE: usize = 64;
        if self.values.len() < length + MAX_LANES {
            self.values.resize(length + MAX_LANES, 0.0);
        }
        self.first = self.values.as_ptr().align_offset(LINE).min(MAX_LANES);
        self.length = length;
    }
}

impl Deref for Aligned {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &self.values[self.first..self.first + self.length]
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.values[self.first..self.first + self.length]
    }
}

/// How long a path becomes by one more edge.
pub(super) trait Step: Copy {
    /// The step from a row with this dual at the end of a path of this length.
    fn new(length: f64, row_dual: f64) -> Self;

    /// The length of the paths to columns with these costs and duals.
    fn through<S: Simd>(self, simd: S, costs: S::f64s, duals: S::f64s) -> S::f64s;
}

/// The length is the sum of the reduced costs on the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sum {
    length: f64,
    row_dual: f64,
}

impl Step for Sum {
    #[inline(always)]
    fn new(length: f64, row_dual: f64) -> Self {
        Self { length, row_dual }
    }

    #[inline(always)]
    fn through<S: Simd>(self, simd: S, costs: S::f64s, duals: S::f64s) -> S::f64s {
        let sum = simd.add_f64s(simd.splat_f64s(self.length), costs);
        simd.sub_f64s(simd.sub_f64s(sum, simd.splat_f64s(self.row_dual)), duals)
    }
}

/// The length is the largest cost on the path; duals are 0, or minus infinity for a closed column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Largest {
    length: f64,
}

impl Step for Largest {
    #[inline(always)]
    fn new(length: f64, _row_dual: f64) -> Self {
        Self { length }
    }

    #[inline(always)]
    fn through<S: Simd>(self, simd: S, costs: S::f64s, duals: S::f64s) -> S::f64s {
        simd.max_f64s(simd.sub_f64s(costs, duals), simd.splat_f64s(self.length))
    }
}

impl<S: Simd> Vectors<'_, S> {
    /// The dual of a column.
    #[inline(always)]
    pub fn dual(&self, column: usize) -> f64 {
        pulp::bytemuck::cast_slice::<S::f64s, f64>(self.dual)[column]
    }

    /// The rank of a column.
    #[inline(always)]
    pub fn rank(&self, column: usize) -> f64 {
        pulp::bytemuck::cast_slice::<S::f64s, f64>(self.rank)[column]
    }
}

/// Finds the paths that consist of one step, and the least distance of a column.
#[inline(always)]
pub(super) fn begin<S: Simd>(
    simd: S,
    costs: &[f64],
    step: impl Step,
    columns: &mut Vectors<'_, S>,
) -> f64 {
    let (infinity, none) = (simd.splat_f64s(f64::INFINITY), simd.splat_f64s(0.0));
    pass(
        simd,
        costs,
        columns,
        #[inline(always)]
        |costs, dual, distance, via| {
            let through = step.through(simd, costs, dual);
            // NaN, where sums overflow, is no path.
            let shorter = simd.less_than_f64s(through, infinity);
            *distance = simd.select_f64s(shorter, through, infinity);
            *via = none;
            *distance
        },
    )
}

/// Shortens the paths that lead through the last of `reached` columns, and finds the least distance
/// of a column.
#[inline(always)]
pub(super) fn relax<S: Simd>(
    simd: S,
    costs: &[f64],
    step: impl Step,
    reached: usize,
    columns: &mut Vectors<'_, S>,
) -> f64 {
    let (reached, none) = (simd.splat_f64s(reached as f64), simd.splat_f64s(0.0));
    pass(
        simd,
        costs,
        columns,
        #[inline(always)]
        |costs, dual, distance, via| {
            let through = step.through(simd, costs, dual);
            let shorter = simd.less_than_f64s(through, *distance);
            // The minimum and the maximum write whole vectors. A compiler turns a selection into a
            // store of some lanes, for which the next load has to wait.
            *distance = simd.min_f64s(through, *distance);
            *via = simd.max_f64s(simd.select_f64s(shorter, reached, none), *via);
            *distance
        },
    )
}

/// The least of what `each` returns for costs, duals, distances and the columns before, in lanes.
#[inline(always)]
fn pass<S: Simd>(
    simd: S,
    costs: &[f64],
    columns: &mut Vectors<'_, S>,
    mut each: impl FnMut(S::f64s, S::f64s, &mut S::f64s, &mut S::f64s) -> S::f64s,
) -> f64 {
    let Vectors { dual: duals, distance: distances, via, .. } = columns;
    let (distances, via) = (&mut distances[..duals.len()], &mut via[..duals.len()]);
    let mut lowest = simd.splat_f64s(f64::INFINITY);
    each_vector(
        simd,
        costs,
        duals.len(),
        #[inline(always)]
        |costs, k| {
            lowest = simd.min_f64s(lowest, each(costs, duals[k], &mut distances[k], &mut via[k]));
        },
    );
    simd.reduce_min_f64s(lowest)
}

/// Shows `look` every vector of a row and its place, padded with zeros to a whole one at the end.
/// There are at most `most` places.
#[inline(always)]
pub(super) fn each_vector<S: Simd>(
    simd: S,
    row: &[f64],
    most: usize,
    mut look: impl FnMut(S::f64s, usize),
) {
    let (whole, rest) = S::as_simd_f64s(row);
    let whole = &whole[..whole.len().min(most)];
    for (k, &vector) in whole.iter().enumerate() {
        look(vector, k);
    }
    if !rest.is_empty() {
        look(simd.partial_load_f64s(rest), whole.len());
    }
}

/// The lowest and the second lowest of the costs less the duals, and the column of the lowest.
#[inline(always)]
pub(super) fn two_lowest<S: Simd>(simd: S, costs: &[f64], columns: &Columns) -> (f64, f64, usize) {
    let infinity = simd.splat_f64s(f64::INFINITY);
    let (duals, _) = S::as_simd_f64s(&columns.dual);
    let mut lane = S::as_simd_f64s(&LANE).0[0];
    let step = simd.splat_f64s(S::F64_LANES as f64);
    let (mut lowest, mut second, mut column) = (infinity, infinity, infinity);
    each_vector(
        simd,
        costs,
        duals.len(),
        #[inline(always)]
        |costs, k| {
            let reduced = simd.sub_f64s(costs, duals[k]);
            let lower = simd.less_than_f64s(reduced, lowest);
            second = simd.min_f64s(simd.max_f64s(reduced, lowest), second);
            column = simd.select_f64s(lower, lane, column);
            lowest = simd.min_f64s(reduced, lowest);
            lane = simd.add_f64s(lane, step);
        },
    );
    let least = simd.reduce_min_f64s(lowest);
    let there = simd.equal_f64s(lowest, simd.splat_f64s(least));
    let first = simd.reduce_min_f64s(simd.select_f64s(there, column, infinity));
    let here = simd.equal_f64s(column, simd.splat_f64s(first));
    (least, simd.reduce_min_f64s(simd.select_f64s(here, second, lowest)), first as usize)
}

/// The lowest rank of the columns at this distance.
#[inline(always)]
pub(super) fn lowest_rank<S: Simd>(simd: S, distance: f64, columns: &Vectors<'_, S>) -> f64 {
    let (wanted, infinity) = (simd.splat_f64s(distance), simd.splat_f64s(f64::INFINITY));
    let mut lowest = infinity;
    for (&distance, &rank) in columns.distance.iter().zip(&*columns.rank) {
        let here = simd.equal_f64s(distance, wanted);
        lowest = simd.min_f64s(lowest, simd.select_f64s(here, rank, infinity));
    }
    simd.reduce_min_f64s(lowest)
}

/// Closes a column.
#[inline(always)]
pub(super) fn close<S: Simd>(simd: S, column: usize, columns: &mut Vectors<'_, S>) {
    lower(simd, columns.dual, column, f64::NEG_INFINITY);
    raise(simd, columns.distance, column, f64::INFINITY);
}

/// Gives a column another rank.
#[inline(always)]
pub(super) fn rerank<S: Simd>(simd: S, column: usize, rank: f64, columns: &mut Vectors<'_, S>) {
    let before = columns.rank(column);
    let chunk = &mut columns.rank[column / S::F64_LANES];
    let here = simd.equal_f64s(*chunk, simd.splat_f64s(before));
    let change = simd.select_f64s(here, simd.splat_f64s(rank - before), simd.splat_f64s(0.0));
    *chunk = simd.add_f64s(*chunk, change);
}
