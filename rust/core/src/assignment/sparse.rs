//! The least-cost matching of a sparse matrix in which a row may stay alone at a price.
//!
//! Given the costs of some pairs and the price `K` of a row without a column, find a matching with
//! the least sum of the costs of its pairs and of `K` for each row without one. Pairs that cost `K`
//! or more need not be listed: they never beat staying alone.
//!
//! Shortest augmenting paths (Jonker and Volgenant, "A shortest augmenting path algorithm for dense
//! and sparse linear assignment problems", Computing 38, 1987, doi:10.1007/BF02278710) with a heap,
//! in which staying alone is one more column that is never full. A search ends where the nearest
//! column is as far as staying alone, so that it stays among few rows: no components are needed,
//! and there is one giant component where a row has more than about three columns.
//!
//! Ties: the first row, then the column listed first; staying alone before either. Sums of whole
//! numbers below 2^53 are exact, so that totals of such costs do not depend on the order.
//!
//! Cost: about linear in the number of pairs while rows have a few each.

use crate::assignment::alternating_cycle::{Graph, TOLERANCE};
use crate::error::Result;
use crate::interrupt::Interrupt;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A row that stays alone, and a column without a row.
pub const NONE: u32 = u32::MAX;

/// How many rows are handled between two questions whether to stop.
const ROWS_BETWEEN_CHECKS: usize = 256;

/// The listed pairs, row by row.
#[derive(Debug, Default)]
pub struct Pairs {
    /// Where each row's pairs begin; one more than there are rows.
    pub starts: Vec<usize>,
    /// The column of each pair.
    pub columns: Vec<u32>,
    /// The cost of each pair.
    pub costs: Vec<f64>,
}

impl Pairs {
    fn of(&self, row: usize) -> impl Iterator<Item = (u32, f64)> {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().copied().zip(self.costs[range].iter().copied())
    }

    fn rows(&self) -> usize {
        self.starts.len() - 1
    }
}

/// A matching of least cost.
pub struct Matching<'a>(Search<'a>);

impl Matching<'_> {
    /// The column of each row, [`NONE`] for one that stays alone.
    pub fn column_of_row(&self) -> &[u32] {
        &self.0.column_of_row
    }

    /// The cost of each row's pair, or the price of staying alone.
    pub fn cost_of_row(&self) -> &[f64] {
        &self.0.cost_of_row
    }

    /// Whether no other matching costs as little, within rounding.
    pub fn is_unique(&self) -> bool {
        self.0.is_unique()
    }
}

/// Matches rows with `columns` columns, or leaves them alone at a price.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn solve<'a>(
    pairs: &'a Pairs,
    columns: usize,
    alone: f64,
    interrupt: &Interrupt<'_>,
) -> Result<Matching<'a>> {
    let mut search = Search::new(pairs, columns, alone);
    let conflicts: Vec<usize> = (0..pairs.rows()).filter(|&row| !search.enter(row)).collect();
    for (count, row) in conflicts.into_iter().enumerate() {
        if count.is_multiple_of(ROWS_BETWEEN_CHECKS) {
            interrupt.check()?;
        }
        let (end, length) = search.shortest_path(row, interrupt)?;
        search.update_duals(row, length);
        search.augment(row, end);
    }
    Ok(Matching(search))
}

struct Search<'a> {
    pairs: &'a Pairs,
    alone: f64,
    row_dual: Vec<f64>,
    column_of_row: Vec<u32>,
    cost_of_row: Vec<f64>,
    columns: Vec<Column>,
    heap: BinaryHeap<Candidate>,
    reached: Vec<u32>,
    /// The number of the search; what a column remembers of an earlier one is void.
    epoch: u32,
}

/// What is known of a column; kept together, since it is looked up together.
#[derive(Clone, Copy)]
struct Column {
    dual: f64,
    /// Length of the shortest path found in the search `seen`.
    distance: f64,
    row: u32,
    /// The row before it on that path, and the cost of that pair.
    previous: u32,
    cost: f64,
    seen: u32,
    is_reached: bool,
}

/// A column on the heap, the nearest first.
#[derive(PartialEq)]
struct Candidate {
    distance: f64,
    column: u32,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let distance = other.distance.total_cmp(&self.distance);
        distance.then_with(|| other.column.cmp(&self.column))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Where a search ends.
enum End {
    /// At a free column.
    Free(u32),
    /// At a row that gives up its column and stays alone.
    Alone(usize),
}

impl<'a> Search<'a> {
    fn new(pairs: &'a Pairs, columns: usize, alone: f64) -> Self {
        let rows = pairs.rows();
        let column = Column {
            dual: 0.0,
            distance: 0.0,
            row: NONE,
            previous: NONE,
            cost: 0.0,
            seen: 0,
            is_reached: false,
        };
        Self {
            pairs,
            alone,
            row_dual: vec![alone; rows],
            column_of_row: vec![NONE; rows],
            cost_of_row: vec![alone; rows],
            columns: vec![column; columns],
            heap: BinaryHeap::new(),
            reached: Vec::new(),
            epoch: 0,
        }
    }

    /// Gives a row its cheapest column where that is free, or leaves it alone where it has none;
    /// whether either was possible.
    fn enter(&mut self, row: usize) -> bool {
        let (mut least, mut cheapest) = (self.alone, NONE);
        for (column, cost) in self.pairs.of(row) {
            if cost < least {
                (least, cheapest) = (cost, column);
            }
        }
        self.row_dual[row] = least;
        if cheapest == NONE {
            return true;
        }
        let owner = &mut self.columns[cheapest as usize].row;
        if *owner != NONE {
            return false;
        }
        *owner = row as u32;
        (self.column_of_row[row], self.cost_of_row[row]) = (cheapest, least);
        true
    }

    /// Whether no cycle of pairs can be exchanged for nothing.
    fn is_unique(&self) -> bool {
        let mut graph = Graph::default();
        let outside = self.row_dual.len() as u32;
        for row in 0..outside {
            let before = graph.edges.len();
            self.add_edges(row, outside, &mut graph);
            if graph.edges.len() > before {
                graph.rows.push(row);
                let own = self.column_of_row[row as usize];
                if own == NONE || self.columns[own as usize].dual >= -TOLERANCE * self.alone {
                    graph.edges.push([outside, row]);
                }
            }
        }
        graph.edges.is_empty() || graph.has_no_cycle(outside as usize + 1)
    }

    /// The exchanges that a row could begin.
    fn add_edges(&self, row: u32, outside: u32, graph: &mut Graph) {
        let own = self.column_of_row[row as usize];
        let reach = self.row_dual[row as usize] + TOLERANCE * self.alone;
        if own != NONE && reach >= self.alone {
            graph.edges.push([row, outside]);
        }
        for (j, cost) in self.pairs.of(row as usize) {
            let column = &self.columns[j as usize];
            if j != own && cost - column.dual <= reach {
                let owner = column.row;
                graph.edges.push([row, if owner == NONE { outside } else { owner }]);
            }
        }
    }

    /// The cheapest way to find space for `row`, and its length.
    fn shortest_path(&mut self, row: usize, interrupt: &Interrupt<'_>) -> Result<(End, f64)> {
        self.epoch += 1;
        self.heap.clear();
        self.reached.clear();
        let (mut i, mut length) = (row, 0.0);
        let (mut shortest, mut leaver) = (f64::INFINITY, row);
        loop {
            let leave = length + (self.alone - self.row_dual[i]);
            if leave < shortest {
                (shortest, leaver) = (leave, i);
            }
            self.relax(i, length - self.row_dual[i], shortest);
            let Some(Candidate { distance, column }) = self.nearest(shortest) else {
                return Ok((End::Alone(leaver), shortest));
            };
            let next = &mut self.columns[column as usize];
            if next.row == NONE {
                return Ok((End::Free(column), distance));
            }
            next.is_reached = true;
            (i, length) = (next.row as usize, distance);
            self.reached.push(column);
            if self.reached.len().is_multiple_of(ROWS_BETWEEN_CHECKS) {
                interrupt.check()?;
            }
        }
    }

    /// Shortens the paths that lead through row `i`, as far as they are shorter than `bound`.
    fn relax(&mut self, i: usize, offset: f64, bound: f64) {
        for (j, cost) in self.pairs.of(i) {
            let column = &mut self.columns[j as usize];
            let through = cost - column.dual + offset;
            let is_new = column.seen != self.epoch;
            if through < bound && (is_new || (!column.is_reached && through < column.distance)) {
                column.distance = through;
                (column.previous, column.cost) = (i as u32, cost);
                (column.seen, column.is_reached) = (self.epoch, false);
                self.heap.push(Candidate { distance: through, column: j });
            }
        }
    }

    /// The nearest column not yet reached, if it is nearer than `bound`.
    fn nearest(&mut self, bound: f64) -> Option<Candidate> {
        while let Some(candidate) = self.heap.pop() {
            if candidate.distance >= bound {
                return None;
            }
            let column = &self.columns[candidate.column as usize];
            if !column.is_reached && candidate.distance == column.distance {
                return Some(candidate);
            }
        }
        None
    }

    fn update_duals(&mut self, row: usize, length: f64) {
        self.row_dual[row] += length;
        for &j in &self.reached {
            let column = &mut self.columns[j as usize];
            let gain = length - column.distance;
            column.dual -= gain;
            self.row_dual[column.row as usize] += gain;
        }
    }

    /// Turns the path from `row` to its end into matched pairs.
    fn augment(&mut self, row: usize, end: End) {
        let mut next = match end {
            End::Alone(i) => {
                let freed = std::mem::replace(&mut self.column_of_row[i], NONE);
                self.cost_of_row[i] = self.alone;
                if i == row {
                    return;
                }
                freed
            }
            End::Free(j) => j,
        };
        loop {
            let column = &mut self.columns[next as usize];
            let i = column.previous as usize;
            column.row = i as u32;
            self.cost_of_row[i] = column.cost;
            next = std::mem::replace(&mut self.column_of_row[i], next);
            if i == row {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assignment::dense;

    /// Whole costs below 20; pairs of 12 and more are not listed.
    fn random(rows: usize, columns: usize, seed: u64) -> (Pairs, Vec<f64>) {
        let mut state = seed;
        let mut pairs = Pairs { starts: vec![0], ..Pairs::default() };
        let mut truncated = Vec::new();
        for _ in 0..rows {
            for j in 0..columns {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let cost = ((state >> 33) % 20) as f64;
                truncated.push(cost.min(12.0));
                if cost < 12.0 {
                    pairs.columns.push(j as u32);
                    pairs.costs.push(cost);
                }
            }
            pairs.starts.push(pairs.columns.len());
        }
        (pairs, truncated)
    }

    #[test]
    fn totals_are_those_of_the_dense_solver() {
        for seed in 0..400 {
            let (rows, columns) = (1 + seed as usize % 9, 9 + seed as usize % 5);
            let (pairs, dense) = random(rows, columns, seed);
            let found = solve(&pairs, columns, 12.0, &Interrupt::never()).unwrap();
            let mut work = dense::Workspace::default();
            let expected = dense::solve(&dense, rows, columns, &mut work).unwrap();
            let total: f64 = expected.iter().enumerate().map(|(i, j)| dense[i * columns + j]).sum();
            assert_eq!(found.cost_of_row().iter().sum::<f64>(), total, "{seed}");
            let mut used = found.column_of_row().to_vec();
            used.retain(|&j| j != NONE);
            used.sort_unstable();
            assert!(used.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
