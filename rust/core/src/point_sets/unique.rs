//! Whether the matching that was found is the only one of least cost: see
//! [`exchange`](crate::assignment::exchange).
//!
//! Pairs at the cutoff or beyond do not count: they cost what staying alone costs, and are not
//! pairs.

use super::cutoff::Cutoff;
use super::matching::{ALONE, NONE, Workspace};
use super::sets::Sets;
use crate::assignment::exchange::TOLERANCE;
use pulp::Simd;

impl Workspace {
    /// Whether no other matching costs as little, once solved with the second least costs.
    #[inline(always)]
    pub(super) fn is_unique<S: Simd>(&mut self, simd: S, sets: impl Sets, cutoff: &Cutoff) -> bool {
        let alone = cutoff.most();
        if self.conflicting == 0 {
            self.start_duals();
        }
        if self.least_gap(simd, alone) <= TOLERANCE * alone {
            self.write_close(simd, sets, cutoff);
        }
        if self.written.is_empty() {
            return true;
        }
        let mut graph = std::mem::take(&mut self.graph);
        self.add_edges(simd, alone, &mut graph.edges);
        graph.rows.clear();
        graph.rows.extend_from_slice(&self.written);
        let is_unique = graph.edges.is_empty() || graph.has_no_cycle(self.rows + 1);
        self.graph = graph;
        is_unique
    }

    /// The least by which the second best of a row is dearer than its best.
    ///
    /// It says enough of a row that no search has passed: its dual is its least cost, and no dual of a
    /// column is positive.
    #[inline(always)]
    fn least_gap<S: Simd>(&self, simd: S, alone: f64) -> f64 {
        let (limit, far) = (simd.splat_f64s(alone), simd.splat_f64s(f64::INFINITY));
        let least = S::as_simd_f64s(&self.nearest.least).0;
        let second = S::as_simd_f64s(&self.nearest.second).0;
        let mut lowest = far;
        for (&least, &second) in least.iter().zip(second) {
            let gap = simd.sub_f64s(simd.min_f64s(second, limit), least);
            let is_near = simd.less_than_f64s(least, limit);
            lowest = simd.min_f64s(lowest, simd.select_f64s(is_near, gap, far));
        }
        simd.reduce_min_f64s(lowest)
    }

    /// Writes the rows whose second best is as good as their best.
    #[cold]
    fn write_close<S: Simd>(&mut self, simd: S, sets: impl Sets, cutoff: &Cutoff) {
        let alone = cutoff.most();
        for row in 0..self.rows {
            let (least, second) = (self.nearest.least[row], self.nearest.second[row].min(alone));
            if least < alone && second - least <= TOLERANCE * alone {
                self.write(simd, sets, row, cutoff);
            }
        }
    }

    /// Lists what the written rows could have for nothing: of all others it is known that they could
    /// have nothing else. Nothing leads to a row that stays alone but from the outside.
    #[inline(always)]
    fn add_edges<S: Simd>(&self, simd: S, alone: f64, edges: &mut Vec<[u32; 2]>) {
        let (outside, tolerance) = (self.rows as u32, TOLERANCE * alone);
        let own = |row: u32| self.column_of_row[row as usize];
        edges.clear();
        for &row in self.written.iter().filter(|row| own(**row) != ALONE) {
            if self.row_dual[row as usize] + tolerance >= alone {
                edges.push([row, outside]);
            }
            if self.near_and_tight(simd, row as usize, alone) != 1.0 {
                self.add_columns(row, alone, edges);
            }
        }
        if edges.iter().any(|edge| edge[1] == outside) {
            for &row in &self.written {
                if own(row) == ALONE {
                    self.add_columns(row, alone, edges);
                    edges.push([outside, row]);
                } else if self.column_dual[own(row) as usize] >= -tolerance {
                    edges.push([outside, row]);
                }
            }
        }
    }

    /// How many columns a row could have for nothing, its own among them.
    #[inline(always)]
    fn near_and_tight<S: Simd>(&self, simd: S, row: usize, alone: f64) -> f64 {
        let costs = S::as_simd_f64s(&self.costs[row * self.stride..(row + 1) * self.stride]).0;
        let duals = S::as_simd_f64s(&self.column_dual[..self.stride]).0;
        let limit = simd.splat_f64s(alone);
        let reach = simd.splat_f64s(self.row_dual[row] + TOLERANCE * alone);
        let (none, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let mut count = none;
        for (&cost, &dual) in costs.iter().zip(duals) {
            let is_tight = simd.less_than_or_equal_f64s(simd.sub_f64s(cost, dual), reach);
            let both = simd.and_m64s(is_tight, simd.less_than_f64s(cost, limit));
            count = simd.add_f64s(count, simd.select_f64s(both, one, none));
        }
        simd.reduce_sum_f64s(count)
    }

    fn add_columns(&self, row: u32, alone: f64, edges: &mut Vec<[u32; 2]>) {
        let (first, own) = (row as usize * self.stride, self.column_of_row[row as usize]);
        let reach = self.row_dual[row as usize] + TOLERANCE * alone;
        let costs = self.costs[first..first + self.stride].iter().zip(&self.column_dual);
        for (j, (&cost, &dual)) in costs.enumerate() {
            if j as u32 != own && cost < alone && cost - dual <= reach {
                let owner = self.row_of_column[j];
                edges.push([row, if owner == NONE { self.rows as u32 } else { owner }]);
            }
        }
    }
}
