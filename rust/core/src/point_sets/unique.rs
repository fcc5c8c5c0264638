//! Whether the matching that was found is the only one of least cost: see
//! [`exchange`](crate::assignment::alternating_cycle).
//!
//! Pairs at the cutoff or beyond do not count: they cost what staying alone costs, and are not
//! pairs.

use super::cost_source::Sets;
use super::cutoff::Cutoff;
use super::gated_matching::{ALONE, Workspace};
use crate::assignment::alternating_cycle::TOLERANCE;
use crate::simd::{LANE, small_integer};
use pulp::Simd;

impl Workspace {
    /// Whether no other matching costs as little, once solved with the second least costs.
    #[inline(always)]
    pub(super) fn is_unique<S: Simd>(&mut self, simd: S, sets: impl Sets, cutoff: &Cutoff) -> bool {
        let alone = cutoff.most();
        if self.conflicting == 0 {
            self.start_duals();
        }
        // It says enough of a row that no search has passed: its dual is its least cost, and no dual
        // of a column is positive.
        if self.nearest.gap <= TOLERANCE * alone {
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

    /// Writes the rows whose second best is as good as their best.
    #[cold]
    fn write_close<S: Simd>(&mut self, simd: S, sets: impl Sets, cutoff: &Cutoff) {
        let alone = cutoff.most();
        for row in 0..self.rows {
            let (least, second) = (self.nearest.least[row], self.nearest.second[row]);
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
            if self.reach(row, alone) >= alone {
                edges.push([row, outside]);
            }
            let (count, sum) = self.count_columns(simd, row, alone);
            // The other of two is known by the sum of their places.
            let other = self.row_of_column.get(small_integer(sum - f64::from(own(row))));
            match other {
                _ if count == 1.0 => {}
                Some(&owner) if count == 2.0 => edges.push([row, owner.min(outside)]),
                _ => self.add_columns(simd, row, alone, edges),
            }
        }
        if edges.iter().any(|edge| edge[1] == outside) {
            for &row in &self.written {
                if own(row) == ALONE {
                    self.add_columns(simd, row, alone, edges);
                    edges.push([outside, row]);
                } else if self.column_dual[own(row) as usize] >= -tolerance {
                    edges.push([outside, row]);
                }
            }
        }
    }

    /// How many columns a row could have for nothing, its own among them, and the sum of their places.
    #[inline(always)]
    fn count_columns<S: Simd>(&self, simd: S, row: u32, alone: f64) -> (f64, f64) {
        let (none, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (mut count, mut sum, mut place) = (none, none, S::as_simd_f64s(&LANE).0[0]);
        for is_edge in self.columns_for_nothing(simd, row, alone) {
            count = simd.add_f64s(count, simd.select_f64s(is_edge, one, none));
            sum = simd.add_f64s(sum, simd.select_f64s(is_edge, place, none));
            place = simd.add_f64s(place, simd.splat_f64s(S::F64_LANES as f64));
        }
        (simd.reduce_sum_f64s(count), simd.reduce_sum_f64s(sum))
    }

    #[inline(always)]
    fn add_columns<S: Simd>(&self, simd: S, row: u32, alone: f64, edges: &mut Vec<[u32; 2]>) {
        let costs = &self.costs[row as usize * self.stride..][..self.stride];
        let (own, reach) = (self.column_of_row[row as usize], self.reach(row, alone));
        for (k, is_edge) in self.columns_for_nothing(simd, row, alone).enumerate() {
            if simd.first_true_m64s(is_edge) == S::F64_LANES {
                continue;
            }
            let mut count = edges.len();
            edges.resize(count + S::F64_LANES, [row, 0]);
            let lanes = k * S::F64_LANES..(k + 1) * S::F64_LANES;
            let costs = costs[lanes.clone()].iter().zip(&self.column_dual[lanes.clone()]);
            let columns = lanes.clone().zip(&self.row_of_column[lanes]);
            // No branch: which columns these are is as good as random.
            for ((j, &owner), (&cost, &dual)) in columns.zip(costs) {
                edges[count][1] = owner.min(self.rows as u32);
                let is_tight = (cost < alone) & (cost - dual <= reach);
                count += usize::from(is_tight & (j as u32 != own));
            }
            edges.truncate(count);
        }
    }

    /// Whether a row could have each column for nothing, vector by vector.
    #[inline(always)]
    fn columns_for_nothing<S: Simd>(
        &self,
        simd: S,
        row: u32,
        alone: f64,
    ) -> impl Iterator<Item = S::m64s> {
        let costs = &self.costs[row as usize * self.stride..][..self.stride];
        let costs = S::as_simd_f64s(costs).0.iter();
        let duals = S::as_simd_f64s(&self.column_dual[..self.stride]).0;
        let limit = simd.splat_f64s(alone);
        let reach = simd.splat_f64s(self.reach(row, alone));
        costs.zip(duals).map(
            #[inline(always)]
            move |(&cost, &dual)| {
                let is_tight = simd.less_than_or_equal_f64s(simd.sub_f64s(cost, dual), reach);
                simd.and_m64s(is_tight, simd.less_than_f64s(cost, limit))
            },
        )
    }

    /// What a row may cost to count as costing no more than it does, as its dual says.
    #[inline(always)]
    fn reach(&self, row: u32, alone: f64) -> f64 {
        self.row_dual[row as usize] + TOLERANCE * alone
    }
}
