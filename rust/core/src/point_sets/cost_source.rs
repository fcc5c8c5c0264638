//! Two sets of which only distances count: points, or a ready matrix.

use super::cell_grid::{LARGEST_DIMENSION, Near};
use super::cutoff::Cutoff;
use super::distances::check_dimensions;
use super::rows::{Axes, Nearest, write_costs};
use super::tiny;
use crate::error::{Error, Result};
use crate::points::Points;
use pulp::Simd;

/// Two sets, the rows and the columns of a matrix of distances.
pub(crate) trait Sets: Copy {
    /// How many rows and columns.
    fn sizes(&self) -> (usize, usize);

    /// The same with rows and columns exchanged.
    fn flipped(self) -> Self;

    /// The cost of a pair, with the same bits as in `write_row`.
    fn cost(&self, i: usize, j: usize, cutoff: &Cutoff) -> f64;

    /// The distance of a pair, at any scale.
    fn distance(&self, i: usize, j: usize) -> f64;

    /// Finds the least cost of every row, and if `SECOND` the second least.
    fn find_nearest<S: Simd, const SECOND: bool>(
        self,
        simd: S,
        cutoff: &Cutoff,
        nearest: &mut Nearest,
    );

    /// Writes the costs of row `i`, padded with the cutoff's; `columns` is empty at the first row, and
    /// then whatever the implementation keeps there.
    fn write_row<S: Simd>(
        self,
        simd: S,
        i: usize,
        cutoff: &Cutoff,
        columns: &mut Axes,
        row: &mut [f64],
    );

    /// Coordinates of a point; 0 where there are none.
    fn dimension(&self) -> usize {
        0
    }

    /// The sets sorted into cells, where that can be done.
    fn near(&self, _cutoff: &Cutoff) -> Option<Near> {
        None
    }

    /// The least total for at most three columns and as many rows or fewer, at least one.
    fn tiny_total(&self, cutoff: &Cutoff) -> f64 {
        let (m, n) = self.sizes();
        tiny::over_assignments(m, n, |i, j| self.cost(i, j, cutoff))
    }

    /// Whether a cost of zero is due to equal points, and not to distances so small that their
    /// powers vanish.
    fn zero_is_exact(&self, cutoff: &Cutoff) -> bool {
        let (m, n) = self.sizes();
        let is_exact = |d: f64| d == 0.0 || (d > 1e-100 && cutoff.cost(d) > 1e-250);
        (0..m).all(|i| (0..n).all(|j| is_exact(self.distance(i, j))))
    }
}

/// Points with their Euclidean distances.
#[derive(Clone, Copy)]
pub(crate) struct Euclidean<'a> {
    pub(crate) x: Points<'a>,
    pub(crate) y: Points<'a>,
}

impl<'a> Euclidean<'a> {
    /// # Errors
    /// [`Error::Dimension`] for points of different dimensions.
    pub(super) fn new(x: Points<'a>, y: Points<'a>) -> Result<Self> {
        check_dimensions(x, y)?;
        Ok(Self { x, y })
    }
}

impl Sets for Euclidean<'_> {
    #[inline(always)]
    fn sizes(&self) -> (usize, usize) {
        (self.x.len(), self.y.len())
    }

    #[inline(always)]
    fn flipped(self) -> Self {
        Self { x: self.y, y: self.x }
    }

    fn cost(&self, i: usize, j: usize, cutoff: &Cutoff) -> f64 {
        let pairs = self.x.point(i).iter().zip(self.y.point(j));
        cutoff.cost_of_square(pairs.map(|(a, b)| (a - b) * (a - b)).sum())
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (self.x.point(i), self.y.point(j));
        let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        if (1e-280..1e280).contains(&square) {
            return square.sqrt();
        }
        // In units of the largest component: no square leaves the range of floats.
        let differences = || a.iter().zip(b).map(|(a, b)| (a - b).abs());
        let largest = differences().fold(0.0, f64::max);
        if largest == 0.0 || largest == f64::INFINITY {
            return largest;
        }
        largest * differences().map(|d| (d / largest) * (d / largest)).sum::<f64>().sqrt()
    }

    #[inline(always)]
    fn find_nearest<S: Simd, const SECOND: bool>(
        self,
        simd: S,
        cutoff: &Cutoff,
        nearest: &mut Nearest,
    ) {
        nearest.find::<S, SECOND>(simd, self.x, self.y, cutoff);
    }

    #[inline(always)]
    fn write_row<S: Simd>(
        self,
        simd: S,
        i: usize,
        cutoff: &Cutoff,
        columns: &mut Axes,
        row: &mut [f64],
    ) {
        if columns.is_empty() {
            columns.lay_out(self.y);
        }
        write_costs(simd, self.x.point(i), columns, cutoff, row);
    }

    fn dimension(&self) -> usize {
        self.x.dimension()
    }

    fn near(&self, cutoff: &Cutoff) -> Option<Near> {
        let is_sorted = (1..=LARGEST_DIMENSION).contains(&self.x.dimension());
        let has_cells = cutoff.c() < f64::INFINITY && cutoff.has_square();
        let fits = self.x.len().max(self.y.len()) < u32::MAX as usize;
        (is_sorted && has_cells && fits && cutoff.p() < f64::INFINITY)
            .then(|| Near::new(self.x, self.y, cutoff))
    }

    #[inline(always)]
    fn tiny_total(&self, cutoff: &Cutoff) -> f64 {
        tiny::least_total(self.x, self.y, cutoff)
    }
}

/// A matrix of distances, C-ordered.
#[derive(Clone, Copy)]
pub struct Distances<'a> {
    values: &'a [f64],
    rows: usize,
    columns: usize,
    is_flipped: bool,
}

impl<'a> Distances<'a> {
    /// The distances between `rows` and `columns` points; infinite where two can never be a pair.
    ///
    /// # Errors
    /// [`Error::Element`] names the first element that is NaN or negative.
    pub fn new(
        argument: &'static str,
        values: &'a [f64],
        rows: usize,
        columns: usize,
    ) -> Result<Self> {
        debug_assert_eq!(values.len(), rows * columns);
        match values.iter().position(|d| d.is_nan() || *d < 0.0) {
            None => Ok(Self { values, rows, columns, is_flipped: false }),
            Some(at) => Err(Error::Element {
                argument,
                index: vec![at / columns, at % columns],
                requirement: "at least 0",
                value: values[at],
            }),
        }
    }
}

impl Sets for Distances<'_> {
    fn sizes(&self) -> (usize, usize) {
        if self.is_flipped { (self.columns, self.rows) } else { (self.rows, self.columns) }
    }

    fn flipped(self) -> Self {
        Self { is_flipped: !self.is_flipped, ..self }
    }

    fn cost(&self, i: usize, j: usize, cutoff: &Cutoff) -> f64 {
        cutoff.cost(self.distance(i, j))
    }

    #[inline(always)]
    fn distance(&self, i: usize, j: usize) -> f64 {
        let (row, column) = if self.is_flipped { (j, i) } else { (i, j) };
        self.values[row * self.columns + column]
    }

    fn find_nearest<S: Simd, const SECOND: bool>(
        self,
        _simd: S,
        cutoff: &Cutoff,
        nearest: &mut Nearest,
    ) {
        let (m, n) = self.sizes();
        nearest.start(m);
        nearest.gap = f64::INFINITY;
        for i in 0..m {
            let (mut least, mut column, mut second) = (cutoff.c(), 0, cutoff.c());
            for (j, distance) in (0..n).map(|j| (j, self.distance(i, j))) {
                if distance < least {
                    (least, column, second) = (distance, j, least);
                } else {
                    second = second.min(distance);
                }
            }
            let (least, second) = (cutoff.cost(least), cutoff.cost(second));
            (nearest.least[i], nearest.column[i], nearest.second[i]) =
                (least, column as u64, second);
            if least < cutoff.most() {
                nearest.gap = nearest.gap.min(second - least);
            }
        }
    }

    fn write_row<S: Simd>(
        self,
        _simd: S,
        i: usize,
        cutoff: &Cutoff,
        _columns: &mut Axes,
        row: &mut [f64],
    ) {
        let (costs, padding) = row.split_at_mut(self.sizes().1);
        costs.iter_mut().enumerate().for_each(|(j, cost)| *cost = self.cost(i, j, cutoff));
        padding.fill(cutoff.most());
    }
}
