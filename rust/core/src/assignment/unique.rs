//! Is an optimal matching the only one, by a margin?
//!
//! Duals `u`, `v` that are feasible (the reduced costs `r = c - u - v` are not negative, `v` is not
//! positive and 0 for a free column) and tight on the matching prove it optimal. They also say by
//! how much any other complete matching is costlier: by the reduced costs of its pairs and by `-v` of
//! the columns that it leaves free. What one matching has and the other has not is made of cycles
//! and of paths to a free column. So if another one is nearly as good, there is a cycle in which
//!
//! - row `i` takes the column of row `k`, at a reduced cost that is nearly 0, or
//! - row `i` takes a free column at a reduced cost that is nearly 0, and some row `k` gives up a
//!   column whose dual is nearly 0.
//!
//! Few pairs are that near: the graph of these moves is sparse, and without a cycle the matching is
//! the only one within the margin.
//!
//! Cost: one pass over the costs.

use super::augmenting_paths::Matching;
use super::column_search::each_vector;
use pulp::Simd;

const NONE: usize = usize::MAX;

/// Matchings that differ in cost by less than this times the largest |cost| count as equally good.
const MARGIN: f64 = 1e-12;
/// How far rounding may have taken reduced costs from where they should be, in the same unit.
const ROUNDING: f64 = 1e-13;

/// What the test needs and the next can use again.
#[derive(Debug, Default)]
pub(super) struct Moves {
    /// Where each row may go at nearly no cost: rows, or one past the last for a free column.
    to: Vec<usize>,
    /// The moves of row `i` are `to[starts[i] .. starts[i + 1]]`.
    starts: Vec<usize>,
    /// How many moves lead to each row.
    arrivals: Vec<usize>,
    queue: Vec<usize>,
}

/// Whether any other complete matching of a `rows x columns` matrix costs more by a margin. `largest`
/// is the largest |cost| that is finite.
#[inline(always)]
pub(super) fn is_unique<S: Simd>(
    simd: S,
    costs: &[f64],
    largest: f64,
    matching: &Matching,
    moves: &mut Moves,
) -> bool {
    let (rows, columns) = (matching.column_of_row.len(), matching.row_of_column.len());
    let duals = &matching.columns.dual[..columns];
    let scale = duals.iter().chain(&matching.row_dual).fold(largest, |most, x| most.max(x.abs()));
    let rounding = ROUNDING * scale;
    let near = MARGIN * scale + 2.0 * rows as f64 * rounding;
    if !near.is_finite() {
        return false;
    }
    moves.to.clear();
    moves.starts.clear();
    for (i, row) in costs.chunks_exact(columns.max(1)).enumerate() {
        moves.starts.push(moves.to.len());
        let lowest = moves.collect(simd, row, i, near, matching);
        let j = matching.column_of_row[i];
        let tight = row[j] - matching.row_dual[i] - duals[j] <= rounding;
        // Many moves are a sign of ties: to look for a cycle among them is not worth it.
        if lowest < -rounding || !tight || moves.to.len() > 8 * rows {
            return false;
        }
    }
    moves.starts.push(moves.to.len());
    if columns > rows {
        moves.to.extend((0..rows).filter(|&k| -duals[matching.column_of_row[k]] < near));
    }
    moves.starts.push(moves.to.len());
    moves.has_no_cycle()
}

impl Moves {
    /// Adds the moves of row `i`; returns its lowest reduced cost.
    #[inline(always)]
    fn collect<S: Simd>(
        &mut self,
        simd: S,
        row: &[f64],
        i: usize,
        near: f64,
        matching: &Matching,
    ) -> f64 {
        let row_dual = matching.row_dual[i];
        let (duals, _) = S::as_simd_f64s(&matching.columns.dual);
        let mut lowest = simd.splat_f64s(f64::INFINITY);
        let (row_duals, limit) = (simd.splat_f64s(row_dual), simd.splat_f64s(near));
        each_vector(
            simd,
            row,
            duals.len(),
            #[inline(always)]
            |costs, k| {
                let reduced = simd.sub_f64s(simd.sub_f64s(costs, row_duals), duals[k]);
                lowest = simd.min_f64s(lowest, reduced);
                if simd.first_true_m64s(simd.less_than_f64s(reduced, limit)) < S::F64_LANES {
                    let first = k * S::F64_LANES;
                    let last = row.len().min(first + S::F64_LANES);
                    self.collect_columns(row, first..last, i, near, matching);
                }
            },
        );
        simd.reduce_min_f64s(lowest)
    }

    fn collect_columns(
        &mut self,
        row: &[f64],
        columns: std::ops::Range<usize>,
        i: usize,
        near: f64,
        matching: &Matching,
    ) {
        let dual = matching.row_dual[i];
        for j in columns.filter(|&j| row[j] - dual - matching.columns.dual[j] < near) {
            match matching.row_of_column[j] {
                NONE => self.to.push(matching.column_of_row.len()),
                k if k != i => self.to.push(k),
                _ => {}
            }
        }
    }

    /// Takes away, again and again, a row to which no move leads: without a cycle none is left.
    fn has_no_cycle(&mut self) -> bool {
        let nodes = self.starts.len() - 1;
        self.arrivals.clear();
        self.arrivals.resize(nodes, 0);
        self.to.iter().for_each(|&k| self.arrivals[k] += 1);
        self.queue.clear();
        self.queue.extend((0..nodes).filter(|&k| self.arrivals[k] == 0));
        let mut taken = 0;
        while let Some(i) = self.queue.pop() {
            taken += 1;
            for &k in &self.to[self.starts[i]..self.starts[i + 1]] {
                self.arrivals[k] -= 1;
                if self.arrivals[k] == 0 {
                    self.queue.push(k);
                }
            }
        }
        taken == nodes
    }
}
