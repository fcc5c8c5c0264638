//! Large sets: only pairs closer than the cutoff are looked at, where they are few.
//!
//! Exact as the dense matching is: pairs at the cutoff or beyond cost what staying alone costs.
//! Ties fall as the sparse solver meets them, not as in SciPy, whose matrix would not fit.

use super::cutoff::Cutoff;
use super::near::check_memory;
use super::pairs::Pair;
use super::sets::Sets;
use crate::assignment::sparse::{self, NONE};
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Below this many points in the larger set the dense matching is sooner ready, measured.
pub(super) const SMALLEST: usize = 200;

/// A matching of least total.
pub(super) struct Large {
    /// The least total of the costs of all rows.
    pub(super) total: f64,
    /// The pairs closer than the cutoff, in the order of the cells.
    pub(super) pairs: Vec<Pair>,
}

/// The matching of two sets by their near pairs; `None` where the dense one is the better way.
///
/// # Errors
/// [`Error::Memory`](crate::Error::Memory) where neither way fits into memory.
pub(super) fn solve(
    sets: impl Sets,
    cutoff: &Cutoff,
    interrupt: &Interrupt<'_>,
) -> Result<Option<Large>> {
    let (m, n) = sets.sizes();
    let dense = check_memory(m, n);
    let near = sets.near(cutoff).filter(|near| {
        dense.is_err() || near.expected(sets.dimension()) < m as f64 * most_neighbours(n)
    });
    let Some(near) = near else {
        return dense.map(|()| None);
    };
    let listed = near.pairs(cutoff, interrupt)?;
    let matching = sparse::solve(&listed, n, cutoff.most(), interrupt)?;
    let matched = matching.column_of_row.iter().enumerate().filter(|(_, j)| **j != NONE);
    let pairs = matched.map(|(i, &j)| (near.row(i), near.column(j as usize))).collect();
    Ok(Some(Large { total: matching.cost_of_row.iter().sum(), pairs }))
}

/// The mean number of neighbours up to which the sparse matching is sooner ready, measured: its
/// cost grows faster with them than the dense one, which looks at all pairs in any case.
fn most_neighbours(n: usize) -> f64 {
    (n as f64 / 45.0).max(8.0)
}
