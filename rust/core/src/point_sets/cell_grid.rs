//! All pairs of points closer than the cutoff, by sorting into cells.
//!
//! Both sets are sorted by the cells of a grid a little wider than the cutoff, row of cells after
//! row of cells. Along one row of cells, and over the rows beside it, the candidates of a point are
//! a few consecutive ranges of the other set, whose ends only ever move forward while the points are
//! walked in order: no table of cells is needed, however far apart the points lie.
//!
//! Cost: O(3^(d-1) (m + n) + candidates), and the sorting.

use super::cutoff::Cutoff;
use crate::assignment::sparse::Pairs;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::points::Points;
use std::ops::Range;

/// Points of more coordinates are not sorted into cells.
pub(super) const LARGEST_DIMENSION: usize = 4;

/// Bytes of a listed pair.
const PAIR: usize = size_of::<u32>() + size_of::<f64>();

/// The most that one computation may allocate.
pub(super) const MEMORY: usize = 4 << 30;

/// # Errors
/// [`Error::Memory`] where a matrix of all pairs does not fit.
pub(super) fn check_memory(m: usize, n: usize) -> Result<()> {
    let pairs = m.saturating_mul(n);
    let bytes = pairs.saturating_mul(size_of::<f64>());
    if bytes > MEMORY { Err(Error::Memory { pairs, bytes }) } else { Ok(()) }
}

/// Two sets in the order of the cells.
pub(crate) struct Near {
    x: Sorted,
    y: Sorted,
    /// What to add to a cell to be in the middle of each row of cells beside it, and in its own.
    beside: Vec<i64>,
    /// How many pairs have neighbouring cells.
    candidates: usize,
}

/// The points of a set in the order of their cells.
struct Sorted {
    cells: Vec<i64>,
    /// Where each point stands in the set as it was given.
    places: Vec<u32>,
    coordinates: Vec<f64>,
}

/// The grid: where it begins, the width of a cell, and the lowest bit of each coordinate in the
/// number of a cell; the last entry is how many bits there are.
struct Grid {
    origin: [f64; LARGEST_DIMENSION],
    width: f64,
    bits: [u32; LARGEST_DIMENSION + 1],
}

impl Grid {
    /// Cells are wider than the cutoff by more than a coordinate in cells can be off by rounding.
    fn new(x: Points, y: Points, c: f64) -> Self {
        let d = x.dimension();
        let most = f64::from((1u32 << (60 / d as u32).min(30)) - 4);
        let (mut origin, mut extent) = ([0.0; LARGEST_DIMENSION], [0.0; LARGEST_DIMENSION]);
        for k in 0..d {
            let ((low, high), (other_low, other_high)) = (range(x, k), range(y, k));
            origin[k] = low.min(other_low);
            extent[k] = high.max(other_high) - origin[k];
        }
        let widest = extent.iter().fold(0.0, |a: f64, &b| a.max(b));
        let width = (c * (1.0 + 1.0 / 1_048_576.0)).max(widest / most);
        let mut bits = [0; LARGEST_DIMENSION + 1];
        for k in 0..LARGEST_DIMENSION {
            let cells = (extent[k] / width) as i64 + 4;
            bits[k + 1] = bits[k] + if k < d { i64::BITS - cells.leading_zeros() } else { 0 };
        }
        Self { origin, width, bits }
    }

    /// The cell of a point: its coordinates in cells, counted from 1, the first one fastest.
    fn cell(&self, point: &[f64]) -> i64 {
        let along = |k: usize| ((point[k] - self.origin[k]) / self.width) as i64 + 1;
        (0..point.len()).fold(0, |cell, k| cell | (along(k) << self.bits[k]))
    }

    /// The steps to the rows of cells beside one, in rising order.
    fn beside(&self, d: usize) -> Vec<i64> {
        (1..d).fold(vec![0], |steps, k| {
            let step = 1i64 << self.bits[k];
            let mut steps: Vec<i64> =
                [-step, 0, step].iter().flat_map(|s| steps.iter().map(move |t| s + t)).collect();
            steps.sort_unstable();
            steps
        })
    }
}

impl Sorted {
    fn new(points: Points, grid: &Grid) -> Self {
        let d = points.dimension();
        let cells = points.coordinates().chunks_exact(d).map(|point| grid.cell(point));
        let bits = grid.bits[LARGEST_DIMENSION];
        let (cells, places): (Vec<i64>, Vec<u32>) = if bits <= u32::BITS {
            // Half the memory: large sets are sorted at the speed of the memory.
            let order = cells.zip(0..).map(|(cell, place)| (cell as u32, place)).collect();
            sorted(order, bits).into_iter().map(|(cell, place)| (i64::from(cell), place)).unzip()
        } else {
            sorted(cells.zip(0..).collect(), bits).into_iter().unzip()
        };
        let mut coordinates = Vec::with_capacity(places.len() * d);
        for &place in &places {
            coordinates.extend_from_slice(points.point(place as usize));
        }
        Self { cells, places, coordinates }
    }
}

/// The least and the greatest coordinate along one axis.
fn range(points: Points, axis: usize) -> (f64, f64) {
    let values = points.coordinates().iter().skip(axis).step_by(points.dimension());
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    })
}

/// Sorts by cell, whose numbers have so many bits, one byte after the other: linear in the number
/// of points.
fn sorted<C: Copy + Default + Into<i64>>(mut order: Vec<(C, u32)>, bits: u32) -> Vec<(C, u32)> {
    let mut next = vec![(C::default(), 0); order.len()];
    for shift in (0..bits).step_by(8) {
        let digit = |cell: C| (cell.into() >> shift) as usize & 0xff;
        let mut ends = [0; 256];
        order.iter().for_each(|(cell, _)| ends[digit(*cell)] += 1);
        let mut end = 0;
        for count in &mut ends {
            end += std::mem::replace(count, end);
        }
        for &item in &order {
            let place = &mut ends[digit(item.0)];
            next[*place] = item;
            *place += 1;
        }
        std::mem::swap(&mut order, &mut next);
    }
    order
}

impl Near {
    /// Sorts both sets, which have points of one dimension, at most [`LARGEST_DIMENSION`].
    pub(super) fn new(x: Points, y: Points, cutoff: &Cutoff) -> Self {
        let grid = Grid::new(x, y, cutoff.c());
        let beside = grid.beside(x.dimension());
        let (x, y) = (Sorted::new(x, &grid), Sorted::new(y, &grid));
        let mut near = Self { x, y, beside, candidates: 0 };
        let mut candidates = 0;
        near.walk(|_, range| candidates += range.len());
        near.candidates = candidates;
        near
    }

    /// About how many pairs are closer than the cutoff: the share of the ball in the cells around
    /// its centre.
    pub(super) fn expected(&self, dimension: usize) -> f64 {
        let share = [2.0 / 3.0, 0.349, 0.155, 0.061];
        self.candidates as f64 * share[(dimension - 1).min(LARGEST_DIMENSION - 1)]
    }

    /// Hands over, for each point of `x` in order, the ranges of `y` in the cells around it.
    #[inline(always)]
    fn walk(&self, mut visit: impl FnMut(usize, Range<usize>)) {
        let cells = &self.y.cells;
        let mut ranges = vec![0..0; self.beside.len()];
        for (i, &cell) in self.x.cells.iter().enumerate() {
            for (step, range) in self.beside.iter().zip(&mut ranges) {
                let (first, last) = (cell + step - 1, cell + step + 1);
                while range.start < cells.len() && cells[range.start] < first {
                    range.start += 1;
                }
                range.end = range.end.max(range.start);
                while range.end < cells.len() && cells[range.end] <= last {
                    range.end += 1;
                }
                visit(i, range.clone());
            }
        }
    }

    /// The pairs closer than the cutoff with their costs, rows and columns in the order of cells.
    ///
    /// # Errors
    /// [`Error::Memory`] before more is allocated than [`MEMORY`].
    pub(super) fn pairs(&self, cutoff: &Cutoff, interrupt: &Interrupt<'_>) -> Result<Pairs> {
        let mut space = self.candidates;
        if space > MEMORY / PAIR {
            space = self.count(cutoff, interrupt)?;
        }
        if space > MEMORY / PAIR {
            return Err(Error::Memory { pairs: space, bytes: space.saturating_mul(PAIR) });
        }
        match self.x.coordinates.len() / self.x.cells.len().max(1) {
            1 => self.list::<1>(cutoff, interrupt),
            2 => self.list::<2>(cutoff, interrupt),
            3 => self.list::<3>(cutoff, interrupt),
            _ => self.list::<4>(cutoff, interrupt),
        }
    }

    fn list<const D: usize>(&self, cutoff: &Cutoff, interrupt: &Interrupt<'_>) -> Result<Pairs> {
        let space = (1.2 * self.expected(D)) as usize;
        let mut pairs = Pairs {
            starts: vec![0; self.x.cells.len() + 1],
            columns: Vec::with_capacity(space.min(MEMORY / PAIR)),
            costs: Vec::with_capacity(space.min(MEMORY / PAIR)),
        };
        let mut stop = Ok(());
        self.each_near::<D>(cutoff, |i, j, square| {
            if let Some(j) = j {
                pairs.columns.push(j as u32);
                pairs.costs.push(cutoff.cost_of_square(square));
            } else if stop.is_ok() && i.is_multiple_of(1024) {
                stop = interrupt.check();
            }
            pairs.starts[i + 1] = pairs.columns.len();
            stop.is_ok()
        });
        stop.map(|()| pairs)
    }

    fn count(&self, cutoff: &Cutoff, interrupt: &Interrupt<'_>) -> Result<usize> {
        let (mut count, mut stop) = (0, Ok(()));
        let visit = |i: usize, j: Option<usize>, _| {
            count += usize::from(j.is_some());
            if j.is_none() && i.is_multiple_of(64) {
                stop = interrupt.check();
            }
            stop.is_ok()
        };
        match self.x.coordinates.len() / self.x.cells.len().max(1) {
            1 => self.each_near::<1>(cutoff, visit),
            2 => self.each_near::<2>(cutoff, visit),
            3 => self.each_near::<3>(cutoff, visit),
            _ => self.each_near::<4>(cutoff, visit),
        }
        stop.map(|()| count)
    }

    /// Hands over each pair closer than the cutoff with its squared distance, and after each range
    /// of candidates no pair, until `visit` says to stop.
    #[inline(always)]
    fn each_near<const D: usize>(
        &self,
        cutoff: &Cutoff,
        mut visit: impl FnMut(usize, Option<usize>, f64) -> bool,
    ) {
        let (x, y) = (self.x.coordinates.as_chunks::<D>().0, self.y.coordinates.as_chunks::<D>().0);
        let mut goes_on = true;
        self.walk(|i, range| {
            if !goes_on {
                return;
            }
            let point = x[i];
            for (j, other) in range.clone().zip(&y[range]) {
                let differences: [f64; D] = std::array::from_fn(|k| point[k] - other[k]);
                let square = differences.iter().map(|d| d * d).sum();
                if square < cutoff.square() {
                    visit(i, Some(j), square);
                }
            }
            goes_on = visit(i, None, 0.0);
        });
    }

    /// The row as it was given, for one in the order of cells.
    pub(super) fn row(&self, i: usize) -> usize {
        self.x.places[i] as usize
    }

    /// The column as it was given, for one in the order of cells.
    pub(super) fn column(&self, j: usize) -> usize {
        self.y.places[j] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_near_pair_is_found_once() {
        let mut state = 7u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 40) % 40) as f64
        };
        // Cells far apart have numbers of more than 32 bits, which are sorted otherwise.
        for (d, is_far) in (1..=4).flat_map(|d| [(d, false), (d, true)]) {
            let outlier = |values: &mut Vec<f64>, at: f64| values.extend(vec![at; d]);
            let mut x: Vec<f64> = (0..60 * d).map(|_| next()).collect();
            let mut y: Vec<f64> = (0..80 * d).map(|_| next()).collect();
            if is_far {
                outlier(&mut x, 1e13);
                outlier(&mut y, -1e13);
            }
            let (x, y) = (Points::new("X", &x, d).unwrap(), Points::new("Y", &y, d).unwrap());
            for c in [1.0, 5.0, 12.0, 100.0] {
                let cutoff = Cutoff::new(c, 2.0).unwrap();
                let near = Near::new(x, y, &cutoff);
                let pairs = near.pairs(&cutoff, &Interrupt::never()).unwrap();
                let mut found = Vec::new();
                for i in 0..x.len() {
                    for k in pairs.starts[i]..pairs.starts[i + 1] {
                        found.push((near.row(i), near.column(pairs.columns[k] as usize)));
                    }
                }
                found.sort_unstable();
                let square = |i, j| -> f64 {
                    let both = x.point(i).iter().zip(y.point(j));
                    both.map(|(a, b): (&f64, &f64)| (a - b) * (a - b)).sum()
                };
                let all = (0..x.len()).flat_map(|i| (0..y.len()).map(move |j| (i, j)));
                let expected: Vec<_> = all.filter(|&(i, j)| square(i, j) < c * c).collect();
                assert_eq!(found, expected, "{d} {c}");
            }
        }
    }
}
