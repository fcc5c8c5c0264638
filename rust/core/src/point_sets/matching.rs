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
use pulp::Simd;

/// No partner yet.
const NONE: u32 = u32::MAX;
/// A row that stays alone.
const ALONE: u32 = u32::MAX - 1;

/// What one matching needs and the next can use again.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    /// The costs, row by row, each row padded to `stride` with the price of staying alone.
    pub(super) costs: Vec<f64>,
    pub(super) stride: usize,
    row_dual: Vec<f64>,
    column_dual: Vec<f64>,
    /// Length of the shortest path to each column.
    distance: Vec<f64>,
    /// The row before each column on that path.
    previous: Vec<u64>,
    column_of_row: Vec<u32>,
    row_of_column: Vec<u32>,
    conflicts: Vec<u32>,
    reached: Vec<Reached>,
}

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
        self.stride = columns.next_multiple_of(PADDING);
        if self.costs.len() < rows * self.stride {
            self.costs.resize(rows * self.stride, 0.0);
        }
        self.row_dual.clear();
        self.column_of_row.clear();
        self.row_of_column.clear();
        self.row_of_column.resize(self.stride, NONE);
        self.conflicts.clear();
    }

    /// The place for the costs of a row.
    #[inline(always)]
    pub(super) fn row(&mut self, row: usize) -> &mut [f64] {
        &mut self.costs[row * self.stride..(row + 1) * self.stride]
    }

    /// Says what is the least cost of the next row, and in which column: `None` where no cost is
    /// below the price of staying alone.
    #[inline(always)]
    pub(super) fn enter(&mut self, lowest: Option<(f64, usize)>, alone: f64) {
        let row = self.row_dual.len() as u32;
        let Some((cost, column)) = lowest else {
            self.row_dual.push(alone);
            self.column_of_row.push(ALONE);
            return;
        };
        self.row_dual.push(cost);
        if self.row_of_column[column] == NONE {
            self.row_of_column[column] = row;
            self.column_of_row.push(column as u32);
        } else {
            self.conflicts.push(row);
            self.column_of_row.push(NONE);
        }
    }

    /// The least total, once every row has entered.
    #[inline(always)]
    pub(super) fn solve<S: Simd>(&mut self, simd: S, alone: f64) -> f64 {
        if self.conflicts.is_empty() {
            return self.row_dual.iter().sum();
        }
        self.resolve(simd, alone);
        self.column_of_row.iter().enumerate().map(|(i, &j)| self.cost(i, j, alone)).sum()
    }

    #[inline(always)]
    fn cost(&self, row: usize, column: u32, alone: f64) -> f64 {
        if column == ALONE { alone } else { self.costs[row * self.stride + column as usize] }
    }

    #[inline(always)]
    fn resolve<S: Simd>(&mut self, simd: S, alone: f64) {
        self.column_dual.clear();
        self.column_dual.resize(self.stride, 0.0);
        self.distance.resize(self.stride, 0.0);
        self.previous.resize(self.stride, 0);
        for k in 0..self.conflicts.len() {
            let row = self.conflicts[k] as usize;
            let (end, length) = self.search(simd, row, alone);
            self.update_duals(row, length);
            self.augment(row, end);
        }
    }

    /// The cheapest way to find room for `row`, and its length.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, row: usize, alone: f64) -> (End, f64) {
        self.reached.clear();
        self.distance.fill(f64::INFINITY);
        let (mut i, mut length) = (row, 0.0);
        let (mut shortest, mut leaver) = (f64::INFINITY, row);
        loop {
            let leave = length + (alone - self.row_dual[i]);
            if leave < shortest {
                (shortest, leaver) = (leave, i);
            }
            let nearest = self.relax(simd, i, length - self.row_dual[i]);
            let Some((distance, j)) = nearest.filter(|(distance, _)| *distance < shortest) else {
                return (End::Alone(leaver), shortest);
            };
            if self.row_of_column[j] == NONE {
                return (End::Free(j), distance);
            }
            let dual = self.column_dual[j];
            self.reached.push(Reached { column: j as u32, distance, dual });
            // Out of the search: no path to it is shorter, and it is never the nearest.
            self.column_dual[j] = f64::NEG_INFINITY;
            self.distance[j] = f64::INFINITY;
            (i, length) = (self.row_of_column[j] as usize, distance);
        }
    }

    /// Shortens the paths that lead through row `i`, and finds the nearest column.
    #[inline(always)]
    fn relax<S: Simd>(&mut self, simd: S, i: usize, offset: f64) -> Option<(f64, usize)> {
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
            let shorter = simd.less_than_f64s(through, *distance);
            *distance = simd.select_f64s(shorter, through, *distance);
            *previous = simd.select_u64s(shorter, row, *previous);
            lowest.take(simd, *distance);
        }
        lowest.finish(simd, f64::INFINITY)
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
