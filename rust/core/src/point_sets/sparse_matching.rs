//! Large sets: only pairs closer than the cutoff are looked at, where they are few.
//!
//! Exact as the dense matching is: pairs at the cutoff or beyond cost what staying alone costs.
//! Whether there are ties is said; above some thousand points, where SciPy's matrix would take
//! seconds or not fit, they fall as the sparse solver meets them.

use super::cell_grid::{Near, check_memory};
use super::cost_source::Sets;
use super::cutoff::Cutoff;
use super::results::Pair;
use crate::assignment::sparse::{self, Matching, NONE};
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Below this many points in the larger set the dense matching is sooner ready: at 100 points with
/// five neighbours each it takes 25 us, this one 16 us.
pub(super) const SMALLEST: usize = 100;

/// Up to this many pairs of points ties fall as in SciPy.
const MOST_FOR_SCIPY: usize = 4_000_000;

/// A matching of least total.
pub(super) struct Large<'a> {
    near: &'a Near,
    matching: Matching<'a>,
}

impl Large<'_> {
    /// The least total of the costs of all rows.
    pub(super) fn total(&self) -> f64 {
        self.matching.cost_of_row().iter().sum()
    }

    /// The pairs closer than the cutoff, in the order of the cells.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Pair> {
        let rows = self.matching.column_of_row().iter().enumerate();
        let matched = rows.filter(|(_, j)| **j != NONE);
        matched.map(|(i, &j)| (self.near.row(i), self.near.column(j as usize)))
    }

    /// Whether other pairs cost as little, and the sets are small enough for SciPy's order.
    pub(super) fn has_ties(&self, (m, n): (usize, usize)) -> bool {
        m.saturating_mul(n) <= MOST_FOR_SCIPY && !self.matching.is_unique()
    }
}

/// What `finish` makes of the matching of two sets by their near pairs; `None` where the dense
/// matching is the better way.
///
/// # Errors
/// [`Error::Memory`](crate::Error::Memory) where neither way fits into memory.
pub(super) fn solve<T>(
    sets: impl Sets,
    cutoff: &Cutoff,
    interrupt: &Interrupt<'_>,
    finish: impl FnOnce(Large) -> T,
) -> Result<Option<T>> {
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
    Ok(Some(finish(Large { near: &near, matching })))
}

/// The mean number of neighbours up to which the sparse matching is sooner ready: at 300, 1 000 and
/// 2 000 points it breaks even with the dense one, which looks at all pairs in any case, at about 15,
/// 50 and more than 100.
fn most_neighbours(n: usize) -> f64 {
    (n as f64 / 20.0).max(15.0)
}
