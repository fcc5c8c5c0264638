//! The costs of pairs of points, in lanes: the nearest column of eight rows at a time, and single
//! rows of costs.
//!
//! The rows stand side by side in the lanes, so that the nearest column of each is found without a
//! look across them. Only squares are compared there: a power of the least square is the least
//! power. Whole rows of costs are written for the few rows that need them.
//!
//! Points stand axis by axis, each axis padded to whole vectors with infinity, so that what is beyond
//! the end is beyond the cutoff. Sums of squares are written without fused multiply-add, axis after
//! axis: the same bits on every machine.

use super::cutoff::{Cutoff, Power};
use crate::points::Points;
use crate::simd::MAX_LANES;
use pulp::Simd;

/// The points of a set, axis by axis.
#[derive(Debug, Default)]
pub(crate) struct Axes {
    values: Vec<f64>,
    stride: usize,
}

impl Axes {
    /// Forgets the points.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.values.clear();
    }

    /// Whether there are no points.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Writes the points of a set.
    #[inline(always)]
    pub(super) fn lay_out(&mut self, points: Points) {
        self.stride = points.len().next_multiple_of(MAX_LANES);
        self.values.resize(points.dimension() * self.stride, 0.0);
        match points.dimension() {
            1 => self.lay_out_axes::<1>(points),
            2 => self.lay_out_axes::<2>(points),
            3 => self.lay_out_axes::<3>(points),
            4 => self.lay_out_axes::<4>(points),
            d => {
                for (k, axis) in self.values.chunks_exact_mut(self.stride).enumerate() {
                    let values = points.coordinates().iter().skip(k).step_by(d);
                    axis.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
                    axis[points.len()..].fill(f64::INFINITY);
                }
            }
        }
    }

    #[inline(always)]
    fn lay_out_axes<const D: usize>(&mut self, points: Points) {
        let mut axes = self.values.chunks_exact_mut(self.stride);
        let mut axes: [&mut [f64]; D] = std::array::from_fn(|_| axes.next().unwrap_or_default());
        for (i, point) in points.coordinates().as_chunks::<D>().0.iter().enumerate() {
            for (axis, x) in axes.iter_mut().zip(point) {
                axis[i] = *x;
            }
        }
        axes.iter_mut().for_each(|axis| axis[points.len()..].fill(f64::INFINITY));
    }

    /// The vectors of each axis.
    #[inline(always)]
    fn vectors<S: Simd, const D: usize>(&self) -> [&[S::f64s]; D] {
        std::array::from_fn(|k| S::as_simd_f64s(self.axis(k)).0)
    }

    /// One coordinate of all points.
    #[inline(always)]
    fn axis(&self, k: usize) -> &[f64] {
        &self.values[k * self.stride..(k + 1) * self.stride]
    }
}

/// The least cost of every row, the column of it, and the second least; padded to whole vectors.
#[derive(Debug, Default)]
pub(crate) struct Nearest {
    pub(super) least: Vec<f64>,
    pub(super) column: Vec<u64>,
    pub(super) second: Vec<f64>,
    /// The least by which the second least is costlier, of the rows with a column below the cutoff.
    pub(super) gap: f64,
    rows: Axes,
    /// 0, 1, 2 and so on: a place is loaded sooner than it is counted.
    places: Vec<u64>,
}

impl Nearest {
    /// Reserves memory for so many rows.
    #[inline(always)]
    pub(super) fn start(&mut self, rows: usize) {
        let padded = rows.next_multiple_of(MAX_LANES);
        self.least.resize(padded, 0.0);
        self.column.resize(padded, 0);
        self.second.resize(padded, 0.0);
    }

    /// Finds the nearest of the points `y` for every point of `x`, and if `SECOND` the cost of the
    /// second nearest. A row without a column below the cutoff has the cost of the cutoff, and any
    /// column.
    #[inline(always)]
    pub(super) fn find<S: Simd, const SECOND: bool>(
        &mut self,
        simd: S,
        x: Points,
        y: Points,
        cutoff: &Cutoff,
    ) {
        self.start(x.len());
        self.rows.lay_out(x);
        self.places.extend(self.places.len() as u64..y.len() as u64);
        let gap = match x.dimension() {
            1 => self.find_axes::<S, 1, SECOND>(simd, y, cutoff),
            2 => self.find_axes::<S, 2, SECOND>(simd, y, cutoff),
            3 => self.find_axes::<S, 3, SECOND>(simd, y, cutoff),
            4 => self.find_axes::<S, 4, SECOND>(simd, y, cutoff),
            _ => self.find_any::<S, SECOND>(simd, y, cutoff),
        };
        if SECOND {
            self.gap = simd.reduce_min_f64s(gap);
        }
    }

    #[inline(always)]
    fn find_axes<S: Simd, const D: usize, const SECOND: bool>(
        &mut self,
        simd: S,
        y: Points,
        cutoff: &Cutoff,
    ) -> S::f64s {
        let mut gap = simd.splat_f64s(f64::INFINITY);
        let points = y.coordinates().as_chunks::<D>().0;
        for b in 0..self.least.len() / S::F64_LANES {
            let rows = self.rows.vectors::<S, D>().map(|axis| axis[b]);
            let mut lanes = Lanes::new(simd, cutoff);
            for (point, &place) in points.iter().zip(&self.places) {
                let square = squared_distance(simd, point, |k| rows[k]);
                lanes.take::<SECOND>(simd, square, place);
            }
            gap = simd.min_f64s(gap, self.store::<S, SECOND>(simd, b, lanes, cutoff));
        }
        gap
    }

    #[inline(always)]
    fn find_any<S: Simd, const SECOND: bool>(
        &mut self,
        simd: S,
        y: Points,
        cutoff: &Cutoff,
    ) -> S::f64s {
        let mut gap = simd.splat_f64s(f64::INFINITY);
        for b in 0..self.least.len() / S::F64_LANES {
            let mut lanes = Lanes::new(simd, cutoff);
            let points = y.coordinates().chunks_exact(y.dimension());
            for (point, &place) in points.zip(&self.places) {
                let axis = |k| S::as_simd_f64s(self.rows.axis(k)).0[b];
                lanes.take::<SECOND>(simd, squared_distance(simd, point, axis), place);
            }
            gap = simd.min_f64s(gap, self.store::<S, SECOND>(simd, b, lanes, cutoff));
        }
        gap
    }

    /// Writes what was found of the rows in vector `b`; returns their gaps.
    #[inline(always)]
    fn store<S: Simd, const SECOND: bool>(
        &mut self,
        simd: S,
        b: usize,
        lanes: Lanes<S>,
        cutoff: &Cutoff,
    ) -> S::f64s {
        let (least, far) = (raised(simd, cutoff, lanes.least), simd.splat_f64s(f64::INFINITY));
        S::as_mut_simd_f64s(&mut self.least).0[b] = least;
        S::as_mut_simd_u64s(&mut self.column).0[b] = lanes.column;
        if !SECOND {
            return far;
        }
        let second = raised(simd, cutoff, lanes.second);
        S::as_mut_simd_f64s(&mut self.second).0[b] = second;
        let is_near = simd.less_than_f64s(least, simd.splat_f64s(cutoff.most()));
        simd.select_f64s(is_near, simd.sub_f64s(second, least), far)
    }
}

/// What is found of the rows in the lanes of a vector.
struct Lanes<S: Simd> {
    /// The least square below the cutoff's.
    least: S::f64s,
    /// The first place of it.
    column: S::u64s,
    second: S::f64s,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S, cutoff: &Cutoff) -> Self {
        let bound = simd.splat_f64s(cutoff.square());
        Self { least: bound, column: simd.splat_u64s(0), second: bound }
    }

    /// Looks at the squares of the column at this place.
    #[inline(always)]
    fn take<const SECOND: bool>(&mut self, simd: S, square: S::f64s, place: u64) {
        let is_less = simd.less_than_f64s(square, self.least);
        if SECOND {
            let other = simd.select_f64s(is_less, self.least, square);
            self.second = simd.min_f64s(other, self.second);
        }
        self.column = simd.select_u64s(is_less, simd.splat_u64s(place), self.column);
        // Not a selection by `is_less`: from one column to the next only this one is waited for.
        self.least = simd.min_f64s(square, self.least);
    }
}

/// The sum of the squares of the differences, in the order of the axes.
#[inline(always)]
fn squared_distance<S: Simd>(simd: S, point: &[f64], axis: impl Fn(usize) -> S::f64s) -> S::f64s {
    let mut sum = simd.splat_f64s(0.0);
    for (k, x) in point.iter().enumerate() {
        let difference = simd.sub_f64s(axis(k), simd.splat_f64s(*x));
        let square = simd.mul_f64s(difference, difference);
        sum = if k == 0 { square } else { simd.add_f64s(sum, square) };
    }
    sum
}

/// Writes the costs of the pairs of one point with all points of `columns`.
#[inline(always)]
pub(super) fn write_costs<S: Simd>(
    simd: S,
    point: &[f64],
    columns: &Axes,
    cutoff: &Cutoff,
    row: &mut [f64],
) {
    match point.len() {
        1 => write_axes::<S, 1>(simd, point, columns, cutoff, row),
        2 => write_axes::<S, 2>(simd, point, columns, cutoff, row),
        3 => write_axes::<S, 3>(simd, point, columns, cutoff, row),
        4 => write_axes::<S, 4>(simd, point, columns, cutoff, row),
        _ => {
            for (b, cost) in S::as_mut_simd_f64s(row).0.iter_mut().enumerate() {
                let axis = |k| S::as_simd_f64s(columns.axis(k)).0[b];
                *cost = raised(simd, cutoff, squared_distance(simd, point, axis));
            }
        }
    }
}

#[inline(always)]
fn write_axes<S: Simd, const D: usize>(
    simd: S,
    point: &[f64],
    columns: &Axes,
    cutoff: &Cutoff,
    row: &mut [f64],
) {
    let axes = columns.vectors::<S, D>();
    for (b, cost) in S::as_mut_simd_f64s(row).0.iter_mut().enumerate() {
        *cost = raised(simd, cutoff, squared_distance(simd, &point[..D], |k| axes[k][b]));
    }
}

/// The costs of pairs at these squared distances.
#[inline(always)]
fn raised<S: Simd>(simd: S, cutoff: &Cutoff, squares: S::f64s) -> S::f64s {
    let power = cutoff.power();
    if !matches!(power, Power::One | Power::Two) {
        let lanes = &mut [0.0; MAX_LANES][..S::F64_LANES];
        simd.partial_store_f64s(lanes, squares);
        lanes.iter_mut().for_each(|square| *square = cutoff.cost_of_square(*square));
        return simd.partial_load_f64s(lanes);
    }
    let costs = if power == Power::One { simd.sqrt_f64s(squares) } else { squares };
    let is_near = simd.less_than_f64s(squares, simd.splat_f64s(cutoff.square()));
    simd.select_f64s(is_near, costs, simd.splat_f64s(cutoff.most()))
}
