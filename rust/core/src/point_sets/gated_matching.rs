//! The least-cost matching of rows with columns in which a row may stay alone at a price.
//!
//! Given costs `C` (rows x columns) and the price `K`, find a matching with the least sum of the
//! costs of its pairs and of `K` for each row without a column. A row whose least cost reaches `K`
//! is finished when it is seen; one whose cheapest column is free takes it; only the others,
//! few in a tracked scene, need a shortest augmenting path, and only the rows on its way all their
//! costs (Jonker and Volgenant, "A shortest
//! augmenting path algorithm for dense and sparse linear assignment problems", Computing 38, 1987,
//! doi:10.1007/BF02278710), in which staying alone is one more column that is never full.
//!
//! Ties: the first row, then the lowest column; staying alone before either. The same choices on
//! every width of vector unit.
//!
//! Cost: O(rows x columns) and as much again for each conflict and each row on its path.

use super::cost_source::Sets;
use super::cutoff::Cutoff;
use super::results::Pair;
use super::rows::{Axes, Nearest};
use crate::assignment::alternating_cycle::Graph;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::simd::MAX_LANES;
use crate::simd::argmin::Lowest;
use crate::simd::{lower, raise};
use pulp::Simd;
use std::cmp::Ordering;

/// No partner yet.
const NONE: u32 = u32::MAX;
/// A row that stays alone.
pub(super) const ALONE: u32 = u32::MAX - 1;

/// What one matching needs and the next can use again.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub(super) nearest: Nearest,
    /// What the sets keep of their columns from one written row to the next.
    columns: Axes,
    /// The costs, row by row, each row padded to `stride` with the price of staying alone.
    pub(super) costs: Vec<f64>,
    /// The rows whose costs are written: those that a search has passed, and whether a row is one.
    pub(super) written: Vec<u32>,
    is_written: Vec<bool>,
    pub(super) rows: usize,
    pub(super) stride: usize,
    pub(super) row_dual: Vec<f64>,
    pub(super) column_dual: Vec<f64>,
    /// Length of the shortest path to each column.
    distance: Vec<f64>,
    /// How many columns were reached when that path was found: it leads through the last of them.
    via: Vec<f64>,
    pub(super) column_of_row: Vec<u32>,
    /// What each row costs.
    cost_of_row: Vec<f64>,
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

/// A column on the way of the search, and its row.
#[derive(Debug, Clone, Copy)]
struct Reached {
    column: u32,
    row: u32,
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
    /// Reserves memory for a problem of this size.
    #[inline(always)]
    pub(super) fn start(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.stride = columns.next_multiple_of(MAX_LANES);
        if self.costs.len() < rows * self.stride {
            self.costs.resize(rows * self.stride, 0.0);
        }
        if self.row_dual.len() < rows {
            self.row_dual.resize(rows, 0.0);
            self.cost_of_row.resize(rows, 0.0);
            self.column_of_row.resize(rows, NONE);
            self.conflicts.resize(rows, NONE);
            self.is_written.resize(rows, false);
        }
        if self.row_of_column.len() <= self.stride {
            self.row_of_column.resize(self.stride + 1, NONE);
        }
        self.row_of_column[..=self.stride].fill(NONE);
        self.is_written[..rows].fill(false);
        self.written.clear();
        self.columns.clear();
    }

    /// Writes the costs of a row, where they are not yet written.
    #[inline(always)]
    pub(super) fn write<S: Simd>(&mut self, simd: S, sets: impl Sets, row: usize, cutoff: &Cutoff) {
        if !std::mem::replace(&mut self.is_written[row], true) {
            self.written.push(row as u32);
            let costs = &mut self.costs[row * self.stride..(row + 1) * self.stride];
            sets.write_row(simd, row, cutoff, &mut self.columns, costs);
        }
    }

    /// Gives every row in turn its cheapest column, where that is free.
    ///
    /// No branch: which rows are finished is as good as random, and a branch guessed wrong costs
    /// more than all of this. A row that stays alone takes the place after the last column, which
    /// is free again at once.
    #[inline(never)]
    fn settle(&mut self, alone: f64) {
        let (last, rows) = (self.stride, self.rows);
        let (owners, conflicts) = (&mut self.row_of_column[..=last], &mut self.conflicts[..rows]);
        let found = self.nearest.least[..rows].iter().zip(&self.nearest.column[..rows]);
        let outputs = self.column_of_row[..rows].iter_mut().zip(&mut self.cost_of_row[..rows]);
        let mut conflicting = 0;
        for (row, ((&least, &nearest), (partner, cost))) in found.zip(outputs).enumerate() {
            let is_alone = least >= alone;
            let column = if is_alone { last } else { (nearest as usize).min(last) };
            let owner = owners[column];
            let is_free = owner == NONE;
            owners[column] = if is_free { row as u32 } else { owner };
            owners[last] = NONE;
            *partner = if is_alone { ALONE } else { nearest as u32 };
            *cost = if is_alone { alone } else { least };
            conflicts[conflicting] = row as u32;
            conflicting += usize::from(!is_free);
        }
        self.conflicting = conflicting;
    }

    /// Matches the rows of `sets`, not more than there are columns; `SECOND` where
    /// [`is_unique`](Self::is_unique) is asked next.
    #[inline(always)]
    pub(super) fn solve<S: Simd, const SECOND: bool>(
        &mut self,
        simd: S,
        sets: impl Sets,
        cutoff: &Cutoff,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        let (rows, columns) = sets.sizes();
        self.start(rows, columns);
        sets.find_nearest::<S, SECOND>(simd, cutoff, &mut self.nearest);
        self.settle(cutoff.most());
        if self.conflicting > 0 {
            self.resolve(simd, sets, cutoff, interrupt)?;
        }
        Ok(())
    }

    /// The sum of what the rows cost, once solved.
    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        self.cost_of_row[..self.rows].iter().sum()
    }

    /// Lists the rows that are matched at less than the price of staying alone, with their columns,
    /// once solved; in the order of the columns, and these first, where the sets were flipped. Returns
    /// the sum of their costs.
    #[inline(never)]
    pub(super) fn list(&self, alone: f64, is_flipped: bool, pairs: &mut Vec<Pair>) -> f64 {
        let costs = &self.cost_of_row[..self.rows];
        if is_flipped {
            let owners = self.row_of_column[..self.stride].iter().map(|row| *row as usize);
            let is_near = |row: usize| costs.get(row).is_some_and(|cost| *cost < alone);
            keep(owners.enumerate().map(|(j, i)| ((j, i), is_near(i))), pairs);
        } else {
            let rows = costs.iter().zip(&self.column_of_row).enumerate();
            keep(rows.map(|(i, (&cost, &j))| ((i, j as usize), cost < alone)), pairs);
        }
        costs.iter().map(|&cost| if cost < alone { cost } else { 0.0 }).sum()
    }

    #[inline(always)]
    fn resolve<S: Simd>(
        &mut self,
        simd: S,
        sets: impl Sets,
        cutoff: &Cutoff,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        self.start_duals();
        self.distance.resize(self.stride, 0.0);
        self.via.resize(self.stride, 0.0);
        for k in 0..self.conflicting {
            if self.stride >= WORTH_CHECKING {
                interrupt.check()?;
            }
            let row = self.conflicts[k] as usize;
            let (end, length) = self.search(simd, sets, row, cutoff);
            self.update_duals(simd, row, length);
            self.augment(row, end);
        }
        for &row in &self.written {
            let row = row as usize;
            self.cost_of_row[row] = match self.column_of_row[row] {
                ALONE => cutoff.most(),
                column => self.costs[row * self.stride + column as usize],
            };
        }
        Ok(())
    }

    /// The duals of the rows where they were settled.
    #[inline(always)]
    pub(super) fn start_duals(&mut self) {
        self.row_dual[..self.rows].copy_from_slice(&self.cost_of_row[..self.rows]);
        self.column_dual.clear();
        self.column_dual.resize(self.stride, 0.0);
    }

    /// The cheapest way to find space for `row`, and its length.
    #[inline(always)]
    fn search<S: Simd>(
        &mut self,
        simd: S,
        sets: impl Sets,
        row: usize,
        cutoff: &Cutoff,
    ) -> (End, f64) {
        self.reached.clear();
        self.write(simd, sets, row, cutoff);
        let alone = cutoff.most();
        let (mut shortest, mut leaver) = (alone - self.row_dual[row], row);
        let mut lowest = self.relax::<S, true>(simd, row, -self.row_dual[row]);
        loop {
            let distance = lowest.least(simd);
            // Written so that a NaN ends the search: costs that overflow are found by the caller.
            if !matches!(distance.partial_cmp(&shortest), Some(Ordering::Less)) {
                return (End::Alone(leaver), shortest);
            }
            let j = lowest.place(simd, distance);
            let i = self.row_of_column[j];
            if i == NONE {
                return (End::Free(j), distance);
            }
            let dual = self.column_dual[j];
            self.reached.push(Reached { column: j as u32, row: i, distance, dual });
            // Out of the search: no path to it is shorter, and it is never the nearest.
            lower(simd, S::as_mut_simd_f64s(&mut self.column_dual).0, j, f64::NEG_INFINITY);
            raise(simd, S::as_mut_simd_f64s(&mut self.distance).0, j, f64::INFINITY);
            let i = i as usize;
            self.write(simd, sets, i, cutoff);
            let offset = distance - self.row_dual[i];
            // Rounded as in `relax`, so that no column beyond the cutoff seems nearer than this.
            let leave = alone + offset;
            if leave < shortest {
                (shortest, leaver) = (leave, i);
            }
            lowest = self.relax::<S, false>(simd, i, offset);
        }
    }

    /// Shortens the paths that lead through row `i`, the `FIRST` of the search or the row of the last
    /// column reached, and looks for the nearest column.
    #[inline(always)]
    fn relax<S: Simd, const FIRST: bool>(&mut self, simd: S, i: usize, offset: f64) -> Lowest<S> {
        let costs = S::as_simd_f64s(&self.costs[i * self.stride..(i + 1) * self.stride]).0;
        let duals = S::as_simd_f64s(&self.column_dual[..self.stride]).0;
        let distances = S::as_mut_simd_f64s(&mut self.distance[..self.stride]).0;
        let via = S::as_mut_simd_f64s(&mut self.via[..self.stride]).0;
        let (offset, none) = (simd.splat_f64s(offset), simd.splat_f64s(0.0));
        let reached = simd.splat_f64s(self.reached.len() as f64);
        let mut lowest = Lowest::new(simd, f64::INFINITY);
        for (((cost, dual), distance), via) in costs.iter().zip(duals).zip(distances).zip(via) {
            let through = simd.add_f64s(simd.sub_f64s(*cost, *dual), offset);
            let (shortest, last) = if FIRST {
                (through, none)
            } else {
                let shorter = simd.less_than_f64s(through, *distance);
                // The minimum and the maximum write whole vectors. A compiler turns a selection into
                // a store of some lanes, for which the next load has to wait.
                let last = simd.max_f64s(simd.select_f64s(shorter, reached, none), *via);
                (simd.min_f64s(through, *distance), last)
            };
            (*distance, *via) = (shortest, last);
            lowest.take(simd, shortest);
        }
        lowest
    }

    #[inline(always)]
    fn update_duals<S: Simd>(&mut self, simd: S, row: usize, length: f64) {
        self.row_dual[row] += length;
        for reached in &self.reached {
            let gain = length - reached.distance;
            let duals = S::as_mut_simd_f64s(&mut self.column_dual).0;
            raise(simd, duals, reached.column as usize, reached.dual - gain);
            self.row_dual[reached.row as usize] += gain;
        }
    }

    /// Turns the path from `row` to its end into matched pairs.
    #[inline(always)]
    fn augment(&mut self, row: usize, end: End) {
        let (mut i, mut j) = match end {
            End::Alone(i) => (i, ALONE),
            End::Free(j) => self.take_column(row, j as u32),
        };
        loop {
            std::mem::swap(&mut self.column_of_row[i], &mut j);
            if i == row {
                break;
            }
            (i, j) = self.take_column(row, j);
        }
    }

    /// Gives column `j` to the row before it on the path from `row`.
    #[inline(always)]
    fn take_column(&mut self, row: usize, j: u32) -> (usize, u32) {
        let before = (self.via[j as usize] as usize).checked_sub(1).map(|k| self.reached[k].row);
        let i = before.map_or(row, |before| before as usize);
        self.row_of_column[j as usize] = i as u32;
        (i, j)
    }
}

/// Lists the pairs that are marked. No branch here either.
fn keep(marked: impl ExactSizeIterator<Item = (Pair, bool)>, pairs: &mut Vec<Pair>) {
    pairs.resize(marked.len(), (0, 0));
    let mut count = 0;
    for (pair, is_kept) in marked {
        pairs[count] = pair;
        count += usize::from(is_kept);
    }
    pairs.truncate(count);
}
