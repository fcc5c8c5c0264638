//! Sums over runs that do not depend on how the runs were cut.
//!
//! Addition of floats is not associative, so that a sum remembers its order. Here the order belongs
//! to the run numbers alone: a node (start, level) is the sum of the runs start .. start + 2^level,
//! start a multiple of 2^level, and always the sum of its two halves, left plus right. Any interval of
//! runs is a list of at most 2 log2 N such nodes, its *canonical nodes*, and two neighbouring intervals
//! are joined by adding siblings. Whoever added what, in which batches, on which machine: a node has the
//! same bits.
//!
//! Cost: two additions a run and column; memory: at most 2 log2 N rows.

use super::elementwise::Add;
use crate::error::{Error, Result};
use crate::{simd, threads};
use std::ops::Range;

/// The least number of columns times runs that is worth a thread.
const PIECE: u64 = 1 << 16;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    start: u64,
    level: u32,
}

impl Node {
    /// Whether `right` is the other half of the parent that starts where this node starts.
    fn is_left_of(self, right: Self) -> bool {
        let size = 1u64 << self.level;
        self.level == right.level
            && self.start & (2 * size - 1) == 0
            && right.start == self.start + size
    }
}

/// The canonical nodes of an interval of runs, each with a row of sums.
#[derive(Debug, Clone)]
pub struct Tree {
    width: usize,
    nodes: Vec<Node>,
    /// One row after the other; those beyond the nodes are kept to be written again.
    sums: Vec<f64>,
}

impl Tree {
    /// No runs yet; every run has `width` columns.
    pub fn new(width: usize) -> Self {
        Self { width, nodes: Vec::new(), sums: Vec::new() }
    }

    /// Adds the next run, or the next 2^level runs; `fill` writes all of their columns.
    pub fn push<R>(&mut self, start: u64, level: u32, fill: impl FnOnce(&mut [f64]) -> R) -> R {
        let filled = fill(self.next(Node { start, level }));
        self.join();
        filled
    }

    fn next(&mut self, node: Node) -> &mut [f64] {
        let start = self.nodes.len() * self.width;
        self.nodes.push(node);
        if self.sums.len() < start + self.width {
            self.sums.resize(start + self.width, 0.0);
        }
        &mut self.sums[start..start + self.width]
    }

    /// Adds the runs of `later`, which begin where these end.
    pub fn append(&mut self, later: &Self) {
        for (i, &node) in later.nodes.iter().enumerate() {
            let row = i * self.width..(i + 1) * self.width;
            self.next(node).copy_from_slice(&later.sums[row]);
            self.join();
        }
    }

    /// The rows of sums, node by node in the order of the runs.
    pub fn into_sums(mut self) -> Vec<f64> {
        self.sums.truncate(self.nodes.len() * self.width);
        self.sums
    }

    /// Adds siblings at the end of the list for as long as there are any.
    fn join(&mut self) {
        while let [.., left, right] = self.nodes[..]
            && left.is_left_of(right)
        {
            let end = (self.nodes.len() - 1) * self.width;
            let (rest, right) = self.sums.split_at_mut(end);
            let (left, right) = (&mut rest[end - self.width..], &right[..self.width]);
            simd::dispatch(Add { left, right });
            self.nodes.pop();
            if let Some(parent) = self.nodes.last_mut() {
                parent.level += 1;
            }
        }
    }
}

/// Cuts `runs` where a multiple of a power of two stands, into pieces worth a thread each.
pub(crate) fn pieces(runs: Range<u64>, width: usize) -> Vec<Range<u64>> {
    let least = PIECE.div_ceil(width.max(1) as u64);
    let share = (runs.end - runs.start) / (4 * threads::threads() as u64);
    let size = match threads::threads() {
        1 => u64::MAX,
        _ => 1 << least.max(share).max(1).ilog2(),
    };
    let mut pieces = Vec::new();
    let mut start = runs.start;
    while start < runs.end {
        let end = (start / size).saturating_add(1).saturating_mul(size).min(runs.end);
        pieces.push(start..end);
        start = end;
    }
    pieces
}

/// Sums of the columns of `values`, runs by columns, over the canonical nodes of the runs from
/// `first_run`.
///
/// # Errors
/// [`Error::Length`] where `values` are not whole runs.
pub fn run_sums(values: &[f64], columns: usize, first_run: u64) -> Result<Vec<f64>> {
    let runs = values.len().checked_div(columns).unwrap_or(0);
    if runs * columns != values.len() {
        let (argument, other, unit) = ("values", "whole runs", "numbers");
        let (found, expected) = (values.len(), runs * columns);
        return Err(Error::Length { argument, found, other, expected, unit });
    }
    let mut parts: Vec<_> = pieces(first_run..first_run + runs as u64, columns)
        .into_iter()
        .map(|runs| (runs, Tree::new(columns)))
        .collect();
    threads::fill(&mut parts, 1, |_, parts| {
        for (runs, tree) in parts {
            for run in runs.clone() {
                let row = (run - first_run) as usize * columns;
                tree.push(run, 0, |sums| sums.copy_from_slice(&values[row..row + columns]));
            }
        }
        Ok(())
    })?;
    let mut whole = Tree::new(columns);
    parts.iter().for_each(|(_, tree)| whole.append(tree));
    Ok(whole.into_sums())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition: a node is the sum of its halves.
    fn node(values: &[f64], first: u64, start: u64, level: u32) -> f64 {
        if level == 0 {
            return values[(start - first) as usize];
        }
        let half = 1 << (level - 1);
        node(values, first, start, level - 1) + node(values, first, start + half, level - 1)
    }

    fn canonical(first: u64, stop: u64) -> Vec<(u64, u32)> {
        let (mut nodes, mut start) = (Vec::new(), first);
        while start < stop {
            let fits = |&level: &u32| start % (1 << level) == 0 && start + (1 << level) <= stop;
            let level = (0..63).rev().find(fits).unwrap();
            nodes.push((start, level));
            start += 1 << level;
        }
        nodes
    }

    fn noise(n: u64) -> Vec<f64> {
        (0..n)
            .map(|i| ((i * 2_654_435_761 % 1000) as f64 - 499.5) * 1.1f64.powi(i as i32))
            .collect()
    }

    #[test]
    fn an_interval_is_its_canonical_nodes() {
        let values = noise(70);
        for (first, stop) in [(0, 1), (0, 64), (0, 70), (3, 4), (3, 61), (31, 33), (5, 5)] {
            let part = &values[first as usize..stop as usize];
            let expected: Vec<_> = canonical(first, stop)
                .into_iter()
                .map(|(start, level)| node(part, first, start, level))
                .collect();
            assert_eq!(run_sums(part, 1, first).unwrap(), expected, "{first}..{stop}");
        }
    }

    #[test]
    fn every_cut_has_the_same_bits() {
        let values = noise(45);
        let whole = run_sums(&values, 1, 11).unwrap();
        for cut in 0..45usize {
            let mut tree = Tree::new(1);
            let mut rest = Tree::new(1);
            for (i, &x) in values.iter().enumerate() {
                let tree = if i < cut { &mut tree } else { &mut rest };
                tree.push(11 + i as u64, 0, |row| row[0] = x);
            }
            tree.append(&rest);
            assert_eq!(tree.into_sums(), whole, "{cut}");
        }
    }

    #[test]
    fn pieces_cover_the_runs_once() {
        for (runs, width) in [(0..0, 1), (5..1_000_000, 1), (7..9, 100_000), (0..64, 1 << 14)] {
            let cut = pieces(runs.clone(), width);
            assert!(cut.iter().all(|piece| !piece.is_empty()));
            assert!(cut.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert_eq!(cut.iter().map(|p| p.end - p.start).sum::<u64>(), runs.end - runs.start);
        }
    }
}
