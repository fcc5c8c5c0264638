//! A row of costs in one pass: distances from one point to all points of the other set, cut off,
//! with the least of them and where it stands.
//!
//! The points of the other set stand axis by axis, each axis padded to whole vectors with
//! infinity, so that what is beyond the end is beyond the cutoff. Sums of squares are written
//! without fused multiply-add, axis after axis: the same bits on every machine.

use super::cutoff::{Cutoff, Power};
use super::matching::Workspace;
use super::sets::Sets;
use crate::points::Points;
use pulp::Simd;

/// Rows are padded to a multiple of this many numbers: the widest vector, so that the layout does
/// not depend on the machine.
pub(super) const PADDING: usize = 8;

const LANES: [f64; PADDING] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The least of many numbers below a bound, and the first place where it stands.
#[derive(Clone, Copy)]
pub(super) struct Lowest<S: Simd> {
    value: S::f64s,
    /// Where each lane's least value stands.
    place: S::f64s,
    here: S::f64s,
    step: S::f64s,
}

impl<S: Simd> Lowest<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, bound: f64) -> Self {
        let first = S::as_simd_f64s(&LANES).0[0];
        Self {
            value: simd.splat_f64s(bound),
            place: first,
            here: first,
            step: simd.splat_f64s(S::F64_LANES as f64),
        }
    }

    /// Looks at the next vector of numbers.
    #[inline(always)]
    pub(super) fn take(&mut self, simd: S, values: S::f64s) {
        let less = simd.less_than_f64s(values, self.value);
        // Not a selection by `less`: from one vector to the next only this one is waited for.
        self.value = simd.min_f64s(values, self.value);
        self.place = simd.select_f64s(less, self.here, self.place);
        self.here = simd.add_f64s(self.here, self.step);
    }

    /// The least value and the first place of it; the bound, and some place, where none is below.
    #[inline(always)]
    pub(super) fn finish(self, simd: S) -> (f64, usize) {
        let least = simd.reduce_min_f64s(self.value);
        let here = simd.equal_f64s(self.value, simd.splat_f64s(least));
        let places = simd.select_f64s(here, self.place, simd.splat_f64s(f64::INFINITY));
        (least, small_integer(simd.reduce_min_f64s(places)))
    }
}

/// A whole number below 2^32 as one, without the questions that `as` asks: they take as long as a
/// vector of costs.
#[inline(always)]
fn small_integer(value: f64) -> usize {
    const LAST_PLACE_IS_ONE: f64 = 4_503_599_627_370_496.0;
    (value + LAST_PLACE_IS_ONE).to_bits() as u32 as usize
}

/// Writes the points of a set axis by axis.
#[inline(always)]
pub(super) fn lay_out(points: Points, axes: &mut Vec<f64>) {
    let stride = points.len().next_multiple_of(PADDING);
    axes.resize(points.dimension() * stride, 0.0);
    match points.dimension() {
        1 => lay_out_axes::<1>(points, stride, axes),
        2 => lay_out_axes::<2>(points, stride, axes),
        3 => lay_out_axes::<3>(points, stride, axes),
        4 => lay_out_axes::<4>(points, stride, axes),
        d => {
            for (k, axis) in axes.chunks_exact_mut(stride).enumerate() {
                let values = points.coordinates().iter().skip(k).step_by(d);
                axis.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
                axis[points.len()..].fill(f64::INFINITY);
            }
        }
    }
}

#[inline(always)]
fn lay_out_axes<const D: usize>(points: Points, stride: usize, axes: &mut [f64]) {
    let points = points.coordinates().as_chunks::<D>().0;
    for (k, axis) in axes.chunks_exact_mut(stride).enumerate().take(D) {
        let (values, padding) = axis.split_at_mut(points.len());
        values.iter_mut().zip(points).for_each(|(to, point)| *to = point[k]);
        padding.fill(f64::INFINITY);
    }
}

/// Enters every point of `x` as a row of costs against the points laid out in `axes`.
#[inline(always)]
pub(super) fn enter_points<S: Simd>(
    simd: S,
    x: Points,
    axes: &[f64],
    cutoff: &Cutoff,
    work: &mut Workspace,
) {
    match (x.dimension(), cutoff.power()) {
        (1, Power::Two) => fused::<S, 1, false>(simd, x, axes, cutoff, work),
        (2, Power::Two) => fused::<S, 2, false>(simd, x, axes, cutoff, work),
        (3, Power::Two) => fused::<S, 3, false>(simd, x, axes, cutoff, work),
        (4, Power::Two) => fused::<S, 4, false>(simd, x, axes, cutoff, work),
        (1, Power::One) => fused::<S, 1, true>(simd, x, axes, cutoff, work),
        (2, Power::One) => fused::<S, 2, true>(simd, x, axes, cutoff, work),
        (3, Power::One) => fused::<S, 3, true>(simd, x, axes, cutoff, work),
        (4, Power::One) => fused::<S, 4, true>(simd, x, axes, cutoff, work),
        _ => stepwise(simd, x, axes, cutoff, work),
    }
}

/// Up to four dimensions, order 1 (`ROOT`) or 2: everything in one pass.
#[inline(always)]
fn fused<S: Simd, const D: usize, const ROOT: bool>(
    simd: S,
    x: Points,
    axes: &[f64],
    cutoff: &Cutoff,
    work: &mut Workspace,
) {
    let stride = work.stride();
    let near = simd.splat_f64s(cutoff.square());
    let most = simd.splat_f64s(cutoff.most());
    let axes: [&[S::f64s]; D] =
        std::array::from_fn(|k| S::as_simd_f64s(&axes[k * stride..(k + 1) * stride]).0);
    for (i, point) in x.coordinates().chunks_exact(D).enumerate() {
        let point: [S::f64s; D] = std::array::from_fn(|k| simd.splat_f64s(point[k]));
        let row = S::as_mut_simd_f64s(work.row(i)).0;
        let mut lowest = Lowest::new(simd, cutoff.most());
        for (b, to) in row.iter_mut().enumerate() {
            let square = squared_distance(simd, &point, &axes, b);
            let raised = if ROOT { simd.sqrt_f64s(square) } else { square };
            let cost = simd.select_f64s(simd.less_than_f64s(square, near), raised, most);
            *to = cost;
            lowest.take(simd, cost);
        }
        work.enter(i, lowest.finish(simd));
    }
}

#[inline(always)]
fn squared_distance<S: Simd, const D: usize>(
    simd: S,
    point: &[S::f64s; D],
    axes: &[&[S::f64s]; D],
    b: usize,
) -> S::f64s {
    let first = simd.sub_f64s(point[0], axes[0][b]);
    let mut sum = simd.mul_f64s(first, first);
    for k in 1..D {
        let difference = simd.sub_f64s(point[k], axes[k][b]);
        sum = simd.add_f64s(sum, simd.mul_f64s(difference, difference));
    }
    sum
}

/// Any dimension and order: squares axis by axis, then costs, then the least of them.
#[inline(always)]
fn stepwise<S: Simd>(simd: S, x: Points, axes: &[f64], cutoff: &Cutoff, work: &mut Workspace) {
    for i in 0..x.len() {
        let row = work.row(i);
        row.fill(0.0);
        for (a, axis) in x.point(i).iter().zip(axes.chunks_exact(row.len())) {
            for (sum, b) in row.iter_mut().zip(axis) {
                *sum += (a - b) * (a - b);
            }
        }
        row.iter_mut().for_each(|cost| *cost = cutoff.cost_of_square(*cost));
        enter_row(simd, i, cutoff, work);
    }
}

/// Enters rows of costs that are computed one by one.
#[inline(always)]
pub(super) fn enter_costs<S: Simd>(
    simd: S,
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut Workspace,
) {
    let (m, n) = sets.sizes();
    for i in 0..m {
        let (costs, padding) = work.row(i).split_at_mut(n);
        costs.iter_mut().enumerate().for_each(|(j, cost)| *cost = sets.cost(i, j, cutoff));
        padding.fill(cutoff.most());
        enter_row(simd, i, cutoff, work);
    }
}

/// Enters a row whose costs are written.
#[inline(always)]
fn enter_row<S: Simd>(simd: S, i: usize, cutoff: &Cutoff, work: &mut Workspace) {
    let mut lowest = Lowest::new(simd, cutoff.most());
    S::as_simd_f64s(work.row(i)).0.iter().for_each(|costs| lowest.take(simd, *costs));
    work.enter(i, lowest.finish(simd));
}
