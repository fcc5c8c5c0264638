//! Two sets of which only distances count: points, or a ready matrix.

use super::cutoff::Cutoff;
use super::matching::Workspace;
use super::{rows, tiny};
use crate::error::{Error, Result};
use crate::points::Points;
use pulp::Simd;

/// Two sets, the rows and the columns of a matrix of distances.
pub(crate) trait Sets: Copy {
    /// How many rows and columns.
    fn sizes(&self) -> (usize, usize);

    /// The same with rows and columns exchanged.
    fn flipped(self) -> Self;

    /// The cost of a pair, with the same bits as in `enter`.
    fn cost(&self, i: usize, j: usize, cutoff: &Cutoff) -> f64;

    /// The distance of a pair, at any scale.
    fn distance(&self, i: usize, j: usize) -> f64;

    /// Enters every row into `work`.
    fn enter<S: Simd>(self, simd: S, cutoff: &Cutoff, work: &mut Workspace);

    /// The least total for at most three columns and as many rows or fewer, at least one.
    fn tiny_total(&self, cutoff: &Cutoff) -> f64 {
        let (m, n) = self.sizes();
        tiny::over_assignments(m, n, |i, j| self.cost(i, j, cutoff))
    }

    /// Whether a cost of zero is owed to equal points, and not to distances so small that their
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
    fn enter<S: Simd>(self, simd: S, cutoff: &Cutoff, work: &mut Workspace) {
        let mut axes = std::mem::take(&mut work.axes);
        rows::lay_out(self.y, &mut axes);
        rows::enter_points(simd, self.x, &axes, cutoff, work);
        work.axes = axes;
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

    fn enter<S: Simd>(self, simd: S, cutoff: &Cutoff, work: &mut Workspace) {
        rows::enter_costs(simd, self, cutoff, work);
    }
}
