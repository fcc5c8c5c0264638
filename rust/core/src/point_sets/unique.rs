//! Whether the matching that was found is the only one of least cost: see
//! [`exchange`](crate::assignment::exchange).
//!
//! Pairs at the cutoff or beyond do not count: they cost what staying alone costs, and are not
//! pairs.

use super::matching::{ALONE, NONE, Workspace};
use crate::assignment::exchange::{Graph, TOLERANCE};
use pulp::Simd;

impl Workspace {
    /// Whether no other matching costs as little, `alone` being finite.
    #[inline(always)]
    pub(super) fn is_unique<S: Simd>(&mut self, simd: S, alone: f64) -> bool {
        let (has_duals, mut graph) = (self.conflicting > 0, std::mem::take(&mut self.graph));
        graph.rows.clear();
        for row in 0..self.rows {
            if self.is_doubtful(simd, row, alone, has_duals) {
                graph.rows.push(row as u32);
            }
        }
        let is_unique = graph.rows.is_empty() || self.has_no_other(alone, &mut graph);
        self.graph = graph;
        is_unique
    }

    /// Whether a row could do as well with a column that it does not have, or alone.
    #[inline(always)]
    fn is_doubtful<S: Simd>(&self, simd: S, row: usize, alone: f64, has_duals: bool) -> bool {
        let reach = self.row_dual[row] + TOLERANCE * alone;
        let is_alone = self.column_of_row[row] == ALONE;
        if !is_alone && reach >= alone {
            return true;
        }
        let costs = S::as_simd_f64s(&self.costs[row * self.stride..(row + 1) * self.stride]).0;
        let (limit, reach) = (simd.splat_f64s(alone), simd.splat_f64s(reach));
        let (none, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let mut tight = none;
        if has_duals {
            let duals = S::as_simd_f64s(&self.column_dual[..self.stride]).0;
            for (&cost, &dual) in costs.iter().zip(duals) {
                let is_near = simd.less_than_f64s(cost, limit);
                let reduced = simd.sub_f64s(cost, dual);
                let is_tight = simd.less_than_or_equal_f64s(reduced, reach);
                let count = simd.select_f64s(is_tight, one, none);
                tight = simd.add_f64s(tight, simd.select_f64s(is_near, count, none));
            }
        } else if !is_alone {
            // What is within reach is nearer than the cutoff.
            for &cost in costs {
                let is_tight = simd.less_than_or_equal_f64s(cost, reach);
                tight = simd.add_f64s(tight, simd.select_f64s(is_tight, one, none));
            }
        } else {
            return false;
        }
        simd.reduce_sum_f64s(tight) != f64::from(u8::from(!is_alone))
    }

    fn has_no_other(&mut self, alone: f64, graph: &mut Graph) -> bool {
        if self.conflicting == 0 {
            self.column_dual.clear();
            self.column_dual.resize(self.stride, 0.0);
        }
        graph.edges.clear();
        for k in 0..graph.rows.len() {
            self.add_edges(graph.rows[k] as usize, alone, graph);
        }
        graph.has_no_cycle(self.rows + 1)
    }

    fn add_edges(&self, row: usize, alone: f64, graph: &mut Graph) {
        let (own, outside) = (self.column_of_row[row], self.rows as u32);
        let reach = self.row_dual[row] + TOLERANCE * alone;
        if own != ALONE && reach >= alone {
            graph.edges.push([row as u32, outside]);
        }
        if own == ALONE || self.column_dual[own as usize] >= -TOLERANCE * alone {
            graph.edges.push([outside, row as u32]);
        }
        let costs = &self.costs[row * self.stride..(row + 1) * self.stride];
        for (j, (&cost, &dual)) in costs.iter().zip(&self.column_dual).enumerate() {
            if j as u32 != own && cost < alone && cost - dual <= reach {
                let owner = self.row_of_column[j];
                graph.edges.push([row as u32, if owner == NONE { outside } else { owner }]);
            }
        }
    }
}
