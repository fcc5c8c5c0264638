//! Whether another matching costs as little: a cycle of pairs that can be exchanged for nothing.
//!
//! With duals `u` of rows and `v` of columns, a pair that is not matched can replace others only
//! where its reduced cost `C - u - v` vanishes. Such pairs, within a tolerance, are the edges of a
//! graph: from row i to the row that has the column, or to the outside where the column is free or
//! where i could as well stay alone; and from the outside to every row that could give up its
//! column, or its being alone, for nothing. Another matching of the same cost is a cycle in this
//! graph, so that without one there is no other.

/// Relative to the largest cost: what rounding can hide.
pub(crate) const TOLERANCE: f64 = 1e-12;

/// So few edges are compared with one another sooner than they are sorted.
const FEW: usize = 12;

/// The edges of the graph, and how many of them lead to each row and to the outside.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    /// The rows that have an edge: without one there is no way round.
    pub(crate) rows: Vec<u32>,
    pub(crate) edges: Vec<[u32; 2]>,
    into: Vec<u32>,
    /// What has no edge into it any more.
    loose: Vec<u32>,
}

impl Graph {
    /// Takes away what leads to where no edge begins.
    fn few_have_no_cycle(&mut self) -> bool {
        let edges = &mut self.edges;
        loop {
            let before = edges.len();
            for k in (0..before).rev() {
                if !edges.iter().any(|edge| edge[0] == edges[k][1]) {
                    edges.swap_remove(k);
                }
            }
            if edges.is_empty() || edges.len() == before {
                return edges.is_empty();
            }
        }
    }

    /// Takes away what no edge leads to, with its edges, until none is left or a cycle.
    pub(crate) fn has_no_cycle(&mut self, nodes: usize) -> bool {
        if self.edges.len() <= FEW {
            return self.few_have_no_cycle();
        }
        self.edges.sort_unstable();
        self.into.clear();
        self.into.resize(nodes, 0);
        self.edges.iter().for_each(|edge| self.into[edge[1] as usize] += 1);
        self.loose.clear();
        let sources = self.rows.iter().copied().chain([nodes as u32 - 1]);
        self.loose.extend(sources.filter(|&node| self.into[node as usize] == 0));
        let mut gone = 0;
        while let Some(node) = self.loose.pop() {
            let first = self.edges.partition_point(|edge| edge[0] < node);
            for edge in self.edges[first..].iter().take_while(|edge| edge[0] == node) {
                gone += 1;
                self.into[edge[1] as usize] -= 1;
                if self.into[edge[1] as usize] == 0 {
                    self.loose.push(edge[1]);
                }
            }
        }
        gone == self.edges.len()
    }
}
