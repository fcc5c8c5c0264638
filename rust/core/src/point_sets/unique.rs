//! Whether the matching that was found is the only one of least cost.
//!
//! With duals `u` of rows and `v` of columns, a pair that is not matched can replace others only
//! where its reduced cost `C - u - v` vanishes. Such pairs, within a tolerance, are the edges of a
//! graph: from row i to the row that has the column, or to the outside where the column is free or
//! where i could as well stay alone; and from the outside to every row that could give up its
//! column, or its being alone, for nothing. Another matching of the same cost is a cycle in this
//! graph, so that without one there is no other.
//!
//! Pairs at the cutoff or beyond do not count: they cost what staying alone costs, and are not
//! pairs.

use super::matching::{ALONE, NONE, Workspace};

/// Relative to the largest cost: what rounding can hide.
const TOLERANCE: f64 = 1e-12;

/// The edges of the graph, and how many of them lead to each row and to the outside.
#[derive(Debug, Default)]
pub(super) struct Graph {
    edges: Vec<[u32; 2]>,
    into: Vec<u32>,
    /// What has no edge into it any more.
    loose: Vec<u32>,
}

impl Workspace {
    /// Whether no other matching of `columns` columns costs as little, `alone` being finite.
    #[inline(always)]
    pub(super) fn is_unique(&mut self, columns: usize, alone: f64) -> bool {
        let mut graph = std::mem::take(&mut self.graph);
        graph.edges.clear();
        for row in 0..self.rows {
            self.add_edges(row, columns, alone, &mut graph);
        }
        let is_unique = graph.edges.is_empty() || self.has_no_cycle(alone, &mut graph);
        self.graph = graph;
        is_unique
    }

    #[inline(always)]
    fn add_edges(&self, row: usize, columns: usize, alone: f64, graph: &mut Graph) {
        let (own, outside) = (self.column_of_row[row], self.rows as u32);
        let reach = self.row_dual[row] + TOLERANCE * alone;
        if own != ALONE && reach >= alone {
            graph.edges.push([row as u32, outside]);
        }
        let costs = &self.costs[row * self.stride..row * self.stride + columns];
        let duals = &self.column_dual[..columns];
        let is_tight = |cost: f64, dual: f64| (cost < alone) & (cost - dual <= reach);
        let tight = costs.iter().zip(duals).map(|(c, v)| u32::from(is_tight(*c, *v))).sum::<u32>();
        if tight == u32::from(own != ALONE) {
            return;
        }
        for (j, (cost, dual)) in costs.iter().zip(duals).enumerate() {
            if j as u32 != own && is_tight(*cost, *dual) {
                let owner = self.row_of_column[j];
                graph.edges.push([row as u32, if owner == NONE { outside } else { owner }]);
            }
        }
    }

    /// Takes away what no edge leads to, until nothing is left or a cycle.
    fn has_no_cycle(&self, alone: f64, graph: &mut Graph) -> bool {
        let outside = self.rows as u32;
        let free = -TOLERANCE * alone;
        for (row, &column) in self.column_of_row[..self.rows].iter().enumerate() {
            if column == ALONE || self.column_dual[column as usize] >= free {
                graph.edges.push([outside, row as u32]);
            }
        }
        graph.edges.sort_unstable();
        graph.into.clear();
        graph.into.resize(self.rows + 1, 0);
        graph.edges.iter().for_each(|edge| graph.into[edge[1] as usize] += 1);
        graph.loose.clear();
        graph.loose.extend((0..=outside).filter(|&node| graph.into[node as usize] == 0));
        let mut gone = 0;
        while let Some(node) = graph.loose.pop() {
            gone += 1;
            let first = graph.edges.partition_point(|edge| edge[0] < node);
            for edge in graph.edges[first..].iter().take_while(|edge| edge[0] == node) {
                graph.into[edge[1] as usize] -= 1;
                if graph.into[edge[1] as usize] == 0 {
                    graph.loose.push(edge[1]);
                }
            }
        }
        gone == self.rows + 1
    }
}
