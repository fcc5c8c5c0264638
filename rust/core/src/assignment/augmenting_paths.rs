//! Shortest augmenting paths over the rows of a dense cost matrix, with SciPy's ties.
//!
//! SciPy keeps the columns not yet reached in a list, filled from the last to the first and emptied
//! by swapping with its end. It takes the first of equal minima, unless free columns are among them:
//! then the last of those. Here all columns stand in their natural order, for the lanes; a rank
//! says where in that list a column would be, and the minima are told apart by it.

use super::column_search::{Columns, Largest, Step, Sum, Vectors};
use super::column_search::{begin, close, lowest_rank, relax, rerank};
use crate::error::{Error, Result};
use crate::simd::small_integer;
use pulp::Simd;

const NONE: usize = usize::MAX;

/// A matching of some rows, and duals that prove it optimal for them.
#[derive(Debug, Default)]
pub(super) struct Matching {
    /// Dual of each row, `u`.
    pub row_dual: Vec<f64>,
    /// Duals of the columns, and what a search keeps of them.
    pub columns: Columns,
    pub column_of_row: Vec<usize>,
    pub row_of_column: Vec<usize>,
    list: List,
    reached: Vec<Reached>,
}

/// SciPy's list: the first `open` entries are the columns not yet reached.
#[derive(Debug, Default)]
struct List {
    remaining: Vec<usize>,
    open: usize,
}

impl List {
    /// Swaps the column at this place with the end of the list.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, place: usize, columns: &mut Vectors<'_, S>) {
        self.open -= 1;
        let moved = self.remaining[self.open];
        self.remaining[place] = moved;
        let is_free = columns.rank(moved) < 0.0;
        rerank(simd, moved, if is_free { free_rank(place) } else { place as f64 }, columns);
    }
}

/// A column to which the shortest path is known.
#[derive(Debug, Clone, Copy)]
struct Reached {
    column: usize,
    /// Its place in the list when it was reached.
    place: usize,
    distance: f64,
    dual: f64,
}

impl Matching {
    /// Starts afresh: nothing is matched, all duals are 0.
    pub fn reset(&mut self, rows: usize, columns: usize) {
        refill(&mut self.row_dual, rows, 0.0);
        refill(&mut self.column_of_row, rows, NONE);
        refill(&mut self.row_of_column, columns, NONE);
        self.columns.reset(columns);
        self.list.remaining.clear();
        self.list.remaining.extend((0..columns).rev());
        self.list.open = columns;
        self.reached.clear();
        for (j, rank) in self.columns.rank.iter_mut().enumerate().take(columns) {
            *rank = free_rank(columns - 1 - j);
        }
    }

    /// Matches `row` with column `j`.
    pub fn set(&mut self, row: usize, j: usize) {
        self.column_of_row[row] = j;
        self.row_of_column[j] = row;
        self.columns.rank[j] = (self.row_of_column.len() - 1 - j) as f64;
    }

    /// Adds the free `row` to the matching, along the shortest path to a free column.
    ///
    /// # Errors
    /// [`Error::Infeasible`] where there is none; the matching is of no use then.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, costs: &[f64], row: usize) -> Result<()> {
        let (sink, length) = self.shortest_path::<S, Sum>(simd, costs, row, 0.0)?;
        self.update_duals(row, sink, length);
        self.augment(simd, row, sink);
        Ok(())
    }

    /// Adds the free `row` to the matching, along the path to a free column whose largest cost is
    /// the smallest, but counted as at least `bound`. Returns that cost.
    ///
    /// # Errors
    /// [`Error::Infeasible`] where there is none; the matching is of no use then.
    #[inline(always)]
    pub fn add_below<S: Simd>(
        &mut self,
        simd: S,
        costs: &[f64],
        row: usize,
        bound: f64,
    ) -> Result<f64> {
        let (sink, height) = self.shortest_path::<S, Largest>(simd, costs, row, bound)?;
        for reached in &self.reached {
            self.columns.dual[reached.column] = 0.0;
        }
        self.augment(simd, row, sink);
        Ok(height)
    }

    /// The free column to which the path is the shortest, and the length of that path; a path without
    /// edges has this length already.
    #[inline(always)]
    fn shortest_path<S: Simd, T: Step>(
        &mut self,
        simd: S,
        costs: &[f64],
        row: usize,
        length: f64,
    ) -> Result<(usize, f64)> {
        let count = self.row_of_column.len();
        let row_of_costs = |i: usize| &costs[i * count..(i + 1) * count];
        let Self { columns, row_of_column, row_dual, list, reached, .. } = self;
        let columns = &mut columns.vectors::<S>();
        let step = T::new(length, row_dual[row]);
        let mut lowest = begin(simd, row_of_costs(row), step, columns);
        loop {
            if lowest == f64::INFINITY {
                return Err(Error::Infeasible);
            }
            let place = place(lowest_rank(simd, lowest, columns));
            let column = list.remaining[place];
            let i = row_of_column[column];
            if i == NONE {
                return Ok((column, lowest));
            }
            let dual = columns.dual(column);
            reached.push(Reached { column, place, distance: lowest, dual });
            close(simd, column, columns);
            list.take(simd, place, columns);
            let step = T::new(lowest, row_dual[i]);
            lowest = relax(simd, row_of_costs(i), step, reached.len(), columns);
        }
    }

    fn update_duals(&mut self, row: usize, sink: usize, length: f64) {
        self.row_dual[row] += length;
        for reached in &self.reached {
            let shift = length - reached.distance;
            self.columns.dual[reached.column] = reached.dual - shift;
            self.row_dual[self.row_of_column[reached.column]] += shift;
        }
        // The last column's dual changes by 0, but by NaN where sums have overflown, as in SciPy.
        if length == f64::NEG_INFINITY {
            self.columns.dual[sink] = f64::NAN;
        }
    }

    /// Turns the path from `row` to `sink` into matched pairs, and forgets the search.
    #[inline(always)]
    fn augment<S: Simd>(&mut self, simd: S, row: usize, sink: usize) {
        self.restore();
        let rank = (self.row_of_column.len() - 1 - sink) as f64;
        rerank(simd, sink, rank, &mut self.columns.vectors());
        let mut j = sink;
        loop {
            let before =
                (self.columns.via[j] as usize).checked_sub(1).map(|k| self.reached[k].column);
            let i = before.map_or(row, |before| self.row_of_column[before]);
            self.row_of_column[j] = i;
            self.column_of_row[i] = j;
            match before {
                Some(before) => j = before,
                None => break,
            }
        }
        self.reached.clear();
    }

    /// Puts the list back into its first order.
    fn restore(&mut self) {
        let last = self.row_of_column.len() - 1;
        let rank = &mut self.columns.rank;
        let mut home = |j: usize| {
            rank[j] = if rank[j] < 0.0 { free_rank(last - j) } else { (last - j) as f64 };
        };
        for reached in &self.reached {
            home(reached.column);
            home(self.list.remaining[reached.place]);
        }
        for reached in &self.reached {
            self.list.remaining[reached.place] = last - reached.place;
        }
        self.list.open = last + 1;
    }
}

/// The rank of a free column: before every taken one, and the later in the list the lower.
#[inline]
fn free_rank(place: usize) -> f64 {
    -1.0 - place as f64
}

/// Where in the list the column of this rank stands.
#[inline]
fn place(rank: f64) -> usize {
    small_integer(if rank < 0.0 { -1.0 - rank } else { rank })
}

pub(super) fn refill<T: Clone>(values: &mut Vec<T>, length: usize, value: T) {
    values.clear();
    values.resize(length, value);
}
