//! Euclidean distances between all points of two sets, a row at a time in lanes.
//!
//! The points of the columns stand axis by axis, each axis padded with infinity to whole vectors, so
//! that what is beyond the end is never the nearest. Squares are added in the order of the axes and
//! without fused operations: the same bits on every machine.

use crate::points::Points;
use crate::simd::MAX_LANES;
use pulp::Simd;

/// A matrix of distances, and what the next can use again.
#[derive(Default)]
pub(super) struct Distances {
    axes: Vec<f64>,
    values: Vec<f64>,
    least: Vec<f64>,
    columns: usize,
    stride: usize,
}

impl Distances {
    /// Computes all distances.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(&mut self, simd: S, rows: Points, columns: Points) {
        self.columns = columns.len();
        self.stride = columns.len().next_multiple_of(MAX_LANES);
        self.lay_out(columns);
        self.values.resize(rows.len() * self.stride, 0.0);
        self.least.clear();
        let (axes, blocks) = (S::as_simd_f64s(&self.axes).0, self.stride / S::F64_LANES);
        for (i, row) in self.values.chunks_exact_mut(self.stride).enumerate() {
            let row = S::as_mut_simd_f64s(row).0;
            self.least.push(fill_row(simd, rows.point(i), axes, &mut row[..blocks]));
        }
    }

    /// Writes the points axis by axis.
    #[inline(always)]
    fn lay_out(&mut self, points: Points) {
        let (n, d) = (points.len(), points.dimension());
        self.axes.resize(d * self.stride, 0.0);
        for (k, axis) in self.axes.chunks_exact_mut(self.stride).enumerate() {
            let values = points.coordinates().iter().skip(k).step_by(d);
            axis.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
            axis[n..].fill(f64::INFINITY);
        }
    }

    /// The distances from one point to all columns.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.stride..][..self.columns]
    }

    /// The least distance of every row.
    pub(super) fn least(&self) -> &[f64] {
        &self.least
    }

    /// Writes the matrix without padding.
    pub(super) fn pack(&self, output: &mut Vec<f64>) {
        output.clear();
        (0..self.least.len()).for_each(|i| output.extend_from_slice(self.row(i)));
    }
}

/// Distances from one point to all columns, and the least of them.
#[inline(always)]
fn fill_row<S: Simd>(simd: S, point: &[f64], axes: &[S::f64s], row: &mut [S::f64s]) -> f64 {
    let blocks = row.len();
    let mut least = simd.splat_f64s(f64::INFINITY);
    for (b, to) in row.iter_mut().enumerate() {
        let mut sum = simd.splat_f64s(0.0);
        for (k, coordinate) in point.iter().enumerate() {
            let difference = simd.sub_f64s(simd.splat_f64s(*coordinate), axes[k * blocks + b]);
            sum = simd.add_f64s(sum, simd.mul_f64s(difference, difference));
        }
        *to = simd.sqrt_f64s(sum);
        least = simd.min_f64s(*to, least);
    }
    simd.reduce_min_f64s(least)
}
