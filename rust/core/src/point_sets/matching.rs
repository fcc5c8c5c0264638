//! The least-cost matching of rows with columns in which a row may stay alone at a price.
//!
//! Given costs `C` (rows x columns) and the price `K`, find a matching with the least sum of the
//! costs of its pairs and of `K` for each row without a column. A row whose least cost reaches `K`
//! is finished when it is seen; one whose cheapest column is free takes it; only the others,
//! few in a tracked scene, need a shortest augmenting path (Jonker and Volgenant, "A shortest
//! augmenting path algorithm for dense and sparse linear assignment problems", Computing 38, 1987,
//! doi:10.1007/BF02278710), in which staying alone is one more column that is never full.
//!
//! Ties: the first row, then the lowest column; staying alone before either. The same choices on
//! every width of vector unit.
//!
//! Cost: O(rows x columns) and as much again for each conflict and each row on its path.

use super::rows::{Lowest, PADDING};
use crate::assignment::exchange::Graph;
use crate::error::Result;
use crate::interrupt::Interrupt;
use pulp::Simd;
use std::cmp::Ordering;

/// No partner yet.
pub(super) const NONE: u32 = u32::MAX;
/// A row that stays alone.
pub(super) const ALONE: u32 = u32::MAX - 1;

/// What one matching needs and the next can use again.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    /// The points of the columns, axis by axis.
    pub(super) axes: Vec<f64>,
    /// The costs, row by row, each row padded to `stride` with the price of staying alone.
    pub(super) costs: Vec<f64>,
    pub(super) rows: usize,
    pub(super) stride: usize,
    pub(super) row_dual: Vec<f64>,
    pub(super) column_dual: Vec<f64>,
    /// Length of the shortest path to each column.
    distance: Vec<f64>,
    /// The row before each column on that path.
    previous: Vec<u64>,
    pub(super) column_of_row: Vec<u32>,
    /// With one place more, for rows that stay alone.
    pub(super) row_of_column: Vec<u32>,
    /// The rows whose cheapest column was taken; so many of them.
    conflicts: Vec<u32>,
    pub(super) conflicting: usize,
    reached: Vec<Reached>,
    pub(super) graph: Graph,
}

/// From this many columns on a search is worth the question whether to stop.
const WORTH_CHECKING: usize = 512;

/// A column on the way of the search.
#[derive(Debug, Clone, Copy)]
struct Reached {
    column: u32,
    distance: f64,
    dual: f64,
}

/// Where a search ends.
enum End {
    /// At a free column.
    Free(usize),
    /// At a row that gives up its column and stays alone.
    Alone(usize),
}

impl Workspace {
    /// Makes room for a problem of this size.
    #[inline(always)]
    pub(super) fn start(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.stride = columns.next_multiple_of(PADDING);
        if self.costs.len() < rows * self.stride {
            self.costs.resize(rows * self.stride, 0.0);
        }
        if self.row_dual.len() < rows {
            self.row_dual.resize(rows, 0.0);
            self.column_of_row.resize(rows, NONE);
            self.conflicts.resize(rows, NONE);
        }
        if self.row_of_column.len() <= self.stride {
            self.row_of_column.resize(self.stride + 1, NONE);
        }
        self.row_of_column[..=self.stride].fill(NONE);
    }

    /// Numbers in a row of costs, a multiple of the widest vector.
    #[inline(always)]
    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    /// The place for the costs of a row.
    #[inline(always)]
    pub(super) fn row(&mut self, row: usize) -> &mut [f64] {
        &mut self.costs[row * self.stride..(row + 1) * self.stride]
    }

    /// Says what is the least cost of a row, and in which column.
    #[inline(always)]
    pub(super) fn enter(&mut self, row: usize, (least, column): (f64, usize)) {
        self.row_dual[row] = least;
        self.column_of_row[row] = column as u32;
    }

    /// Gives every row in turn its cheapest column, where that is free.
    ///
    /// No branch: which rows are finished is as good as random, and a branch guessed wrong costs
    /// more than all of this. A row that stays alone takes the place after the last column, which
    /// is free again at once.
    #[inline(always)]
    fn settle(&mut self, alone: f64) {
        let (last, rows) = (self.stride, self.rows);
        let (owners, conflicts) = (&mut self.row_of_column[..=last], &mut self.conflicts[..rows]);
        let mut conflicting = 0;
        for (row, partner) in self.column_of_row[..rows].iter_mut().enumerate() {
            let is_alone = self.row_dual[row] >= alone;
            let column = if is_alone { last } else { (*partner as usize).min(last) };
            let owner = owners[column];
            let is_free = owner == NONE;
            owners[column] = if is_free { row as u32 } else { owner };
            owners[last] = NONE;
            *partner = if is_alone { ALONE } else { *partner };
            conflicts[conflicting] = row as u32;
            conflicting += usize::from(!is_free);
        }
        self.conflicting = conflicting;
    }

    /// The least total, once every row has entered.
    #[inline(always)]
    pub(super) fn solve<S: Simd>(
        &mut self,
        simd: S,
        alone: f64,
        interrupt: &Interrupt<'_>,
    ) -> Result<f64> {
        self.settle(alone);
        if self.conflicting == 0 {
            return Ok(self.row_dual[..self.rows].iter().sum());
        }
        self.resolve(simd, alone, interrupt)?;
        let partners = self.column_of_row[..self.rows].iter().enumerate();
        Ok(partners.map(|(i, &j)| self.cost(i, j, alone)).sum())
    }

    /// The rows that are matched at less than the price of staying alone, with their columns and
    /// costs, once solved.
    #[inline(always)]
    pub(super) fn pairs(&self, alone: f64) -> impl Iterator<Item = (usize, usize, f64)> {
        let rows = self.column_of_row[..self.rows].iter().enumerate();
        rows.map(move |(i, &j)| (i, j as usize, self.cost(i, j, alone)))
            .filter(move |(_, _, cost)| *cost < alone)
    }

    #[inline(always)]
    fn cost(&self, row: usize, column: u32, alone: f64) -> f64 {
        if column == ALONE { alone } else { self.costs[row * self.stride + column as usize] }
    }

    #[inline(always)]
    fn resolve<S: Simd>(&mut self, simd: S, alone: f64, interrupt: &Interrupt<'_>) -> Result<()> {
        self.column_dual.clear();
        self.column_dual.resize(self.stride, 0.0);
        self.distance.resize(self.stride, 0.0);
        self.previous.resize(self.stride, 0);
        for k in 0..self.conflicting {
            if self.stride >= WORTH_CHECKING {
                interrupt.check()?;
            }
            let row = self.conflicts[k] as usize;
            let (end, length) = self.search(simd, row, alone);
            self.update_duals(row, length);
            self.augment(row, end);
        }
        Ok(())
    }

    /// The cheapest way to find room for `row`, and its length.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, row: usize, alone: f64) -> (End, f64) {
        self.reached.clear();
        let (mut shortest, mut leaver) = (alone - self.row_dual[row], row);
        let (mut distance, mut j) = self.relax::<S, true>(simd, row, -self.row_dual[row]);
        loop {
            // Written so that a NaN ends the search: costs that overflow are found by the caller.
            if !matches!(distance.partial_cmp(&shortest), Some(Ordering::Less)) {
                return (End::Alone(leaver), shortest);
            }
            if self.row_of_column[j] == NONE {
                return (End::Free(j), distance);
            }
            let dual = self.column_dual[j];
            self.reached.push(Reached { column: j as u32, distance, dual });
            // Out of the search: no path to it is shorter, and it is never the nearest.
            self.column_dual[j] = f64::NEG_INFINITY;
            self.distance[j] = f64::INFINITY;
            let i = self.row_of_column[j] as usize;
            let leave = distance + (alone - self.row_dual[i]);
            if leave < shortest {
                (shortest, leaver) = (leave, i);
            }
            (distance, j) = self.relax::<S, false>(simd, i, distance - self.row_dual[i]);
        }
    }

    /// Shortens the paths that lead through row `i`, the `FIRST` of the search or a later one, and
    /// finds the nearest column.
    #[inline(always)]
    fn relax<S: Simd, const FIRST: bool>(
        &mut self,
        simd: S,
        i: usize,
        offset: f64,
    ) -> (f64, usize) {
        let costs = S::as_simd_f64s(&self.costs[i * self.stride..(i + 1) * self.stride]).0;
        let duals = S::as_simd_f64s(&self.column_dual).0;
        let distances = S::as_mut_simd_f64s(&mut self.distance).0;
        let previous = S::as_mut_simd_u64s(&mut self.previous).0;
        let (offset, row) = (simd.splat_f64s(offset), simd.splat_u64s(i as u64));
        let mut lowest = Lowest::new(simd, f64::INFINITY);
        for (((cost, dual), distance), previous) in
            costs.iter().zip(duals).zip(distances).zip(previous)
        {
            let through = simd.add_f64s(simd.sub_f64s(*cost, *dual), offset);
            if FIRST {
                (*distance, *previous) = (through, row);
            } else {
                let shorter = simd.less_than_f64s(through, *distance);
                *distance = simd.select_f64s(shorter, through, *distance);
                *previous = simd.select_u64s(shorter, row, *previous);
            }
            lowest.take(simd, *distance);
        }
        lowest.finish(simd)
    }

    #[inline(always)]
    fn update_duals(&mut self, row: usize, length: f64) {
        self.row_dual[row] += length;
        for reached in &self.reached {
            let (j, gain) = (reached.column as usize, length - reached.distance);
            self.column_dual[j] = reached.dual - gain;
            self.row_dual[self.row_of_column[j] as usize] += gain;
        }
    }

    /// Turns the path from `row` to its end into matched pairs.
    #[inline(always)]
    fn augment(&mut self, row: usize, end: End) {
        let (mut i, mut j) = match end {
            End::Alone(i) => (i, ALONE),
            End::Free(j) => self.take_column(j as u32),
        };
        loop {
            std::mem::swap(&mut self.column_of_row[i], &mut j);
            if i == row {
                break;
            }
            (i, j) = self.take_column(j);
        }
    }

    /// Gives column `j` to the row before it on the path.
    #[inline(always)]
    fn take_column(&mut self, j: u32) -> (usize, u32) {
        let i = self.previous[j as usize];
        self.row_of_column[j as usize] = i as u32;
        (i as usize, j)
    }
}
