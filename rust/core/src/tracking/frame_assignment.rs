//! The assignment of one frame from its candidate pairs, with the pairs that SciPy's
//! `linear_sum_assignment` finds on the whole matrix.
//!
//! Most frames are solved at a glance: where each row's best candidate is best for no other row, or where pairs
//! that gain more than their rivals leave nothing over, no other matching is as good. Otherwise the sparse solver finds an optimum and says
//! whether it is the only one. Where it is not, within rounding, the whole matrix is solved in SciPy's
//! order, so that ties fall as they do there.
//!
//! Cost: O(k) for k candidates in most frames; the dense assignment where there are ties.

use crate::assignment::dense::{self, Goal};
use crate::assignment::sparse;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// A row without a candidate.
pub(super) const NONE: u32 = u32::MAX;

/// Relative to the largest value: how much worse the next best must be to be no rival.
const MARGIN: f64 = 4e-12;

/// What is to be made of the values of the pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Objective {
    /// The largest total of scores of at most this size; a pair that is no candidate scores 0.
    Most(f64),
    /// As many candidates as possible, at the least total cost; any other pair costs this.
    Least(f64),
}

impl Objective {
    /// The cost of a row without a candidate.
    #[inline(always)]
    fn alone(self) -> f64 {
        match self {
            Self::Most(_) => 0.0,
            Self::Least(large) => large,
        }
    }

    #[inline(always)]
    fn cost(self, value: f64) -> f64 {
        match self {
            Self::Most(_) => -value,
            Self::Least(_) => value,
        }
    }

    fn scale(self) -> f64 {
        let (Self::Most(scale) | Self::Least(scale)) = self;
        scale
    }
}

/// The candidates of a frame, the pairs taken, and what the next frame can use again.
#[derive(Debug, Default)]
pub(super) struct FrameAssignment {
    /// The candidates row by row, with their values in `costs`.
    candidates: sparse::Pairs,
    /// Where each candidate stands in the caller's list of pairs.
    places: Vec<u32>,
    /// Of each row, the candidate taken.
    taken: Vec<u32>,
    /// Of each column.
    best: Vec<Best>,
    best_of_row: Vec<Best>,
    shifted: sparse::Pairs,
    matrix: Vec<f64>,
    dense: dense::Workspace,
}

/// The lowest and the second lowest cost of a row or column, and the candidate of the lowest.
#[derive(Debug, Clone, Copy)]
struct Best {
    least: f64,
    second: f64,
    candidate: u32,
    is_taken: bool,
}

impl Best {
    #[inline(always)]
    fn new(alone: f64) -> Self {
        Self { least: alone, second: alone, candidate: NONE, is_taken: false }
    }

    #[inline(always)]
    fn take(&mut self, cost: f64, candidate: usize) {
        if cost < self.least {
            (self.second, self.least, self.candidate) = (self.least, cost, candidate as u32);
        } else if cost < self.second {
            self.second = cost;
        }
    }

    #[inline(always)]
    fn is_clear(&self, margin: f64) -> bool {
        self.second - self.least > margin
    }
}

impl FrameAssignment {
    /// Begins a frame.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.candidates.starts.clear();
        self.candidates.starts.push(0);
        self.candidates.columns.clear();
        self.candidates.costs.clear();
        self.places.clear();
    }

    /// Adds a candidate to the current row. Its value is positive for scores.
    #[inline(always)]
    pub(super) fn push(&mut self, column: usize, value: f64, place: usize) {
        self.candidates.columns.push(column as u32);
        self.candidates.costs.push(value);
        self.places.push(place as u32);
    }

    /// Ends the current row.
    #[inline(always)]
    pub(super) fn end_row(&mut self) {
        self.candidates.starts.push(self.candidates.columns.len());
    }

    /// Whether there is no candidate.
    pub(super) fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The largest value of a candidate, or 0.
    pub(super) fn largest(&self) -> f64 {
        self.candidates.costs.iter().fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Row, place and value of each candidate that was taken.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.taken.iter().enumerate().filter(|(_, k)| **k != NONE).map(|(row, &k)| {
            let k = k as usize;
            (row, self.places[k] as usize, self.candidates.costs[k])
        })
    }

    /// Assigns the rows to `columns` columns.
    pub(super) fn solve(
        &mut self,
        columns: usize,
        objective: Objective,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        let margin = MARGIN * objective.scale();
        self.taken.clear();
        self.taken.resize(self.candidates.starts.len() - 1, NONE);
        if self.is_empty()
            || self.rows_do_not_compete(columns, objective, margin)
            || self.pairs_without_rivals(columns, objective, margin)
            || self.solve_sparse(columns, objective, interrupt)?
        {
            return Ok(());
        }
        self.solve_dense(columns, objective, interrupt)
    }

    /// Whether each row's best candidate is clearly its best, and of a column of its own.
    #[inline]
    fn rows_do_not_compete(&mut self, columns: usize, objective: Objective, margin: f64) -> bool {
        let Self { candidates, taken, best, .. } = self;
        best.clear();
        best.resize(columns, Best::new(0.0));
        for (row, range) in candidates.starts.windows(2).enumerate() {
            let mut own = Best::new(objective.alone());
            for k in range[0]..range[1] {
                own.take(objective.cost(candidates.costs[k]), k);
            }
            if range[0] == range[1] {
                continue;
            }
            if !own.is_clear(margin) {
                return false;
            }
            let column = &mut best[candidates.columns[own.candidate as usize] as usize];
            if column.candidate != NONE {
                return false;
            }
            column.candidate = own.candidate;
            taken[row] = own.candidate;
        }
        true
    }

    /// Whether pairs that gain more than all their rivals together leave no candidate over.
    ///
    /// Whoever leaves such a pair out gives its row and its column at most their second bests, and
    /// loses: every optimum holds it.
    fn pairs_without_rivals(&mut self, columns: usize, objective: Objective, margin: f64) -> bool {
        let Self { candidates, taken, best, best_of_row, .. } = self;
        let alone = objective.alone();
        best.clear();
        best.resize(columns, Best::new(alone));
        best_of_row.clear();
        for range in candidates.starts.windows(2) {
            let mut own = Best::new(alone);
            for k in range[0]..range[1] {
                let cost = objective.cost(candidates.costs[k]);
                own.take(cost, k);
                best[candidates.columns[k] as usize].take(cost, k);
            }
            best_of_row.push(own);
        }
        for (taken, own) in taken.iter_mut().zip(&*best_of_row) {
            *taken = NONE;
            if own.candidate == NONE {
                continue;
            }
            let column = &mut best[candidates.columns[own.candidate as usize] as usize];
            let rival = alone - column.second;
            if column.candidate == own.candidate && own.second - own.least - rival > margin {
                *taken = own.candidate;
                column.is_taken = true;
            }
        }
        let mut rows = candidates.starts.windows(2).zip(&*taken);
        rows.all(|(range, &taken)| {
            let mut columns = candidates.columns[range[0]..range[1]].iter();
            taken != NONE || columns.all(|&column| best[column as usize].is_taken)
        })
    }

    /// Finds an optimum; returns whether it is the only one.
    fn solve_sparse(
        &mut self,
        columns: usize,
        objective: Objective,
        interrupt: &Interrupt<'_>,
    ) -> Result<bool> {
        let Self { candidates, taken, shifted, .. } = self;
        let pairs = match objective {
            Objective::Least(_) => &*candidates,
            Objective::Most(scale) => {
                shifted.starts.clone_from(&candidates.starts);
                shifted.columns.clone_from(&candidates.columns);
                shifted.costs.clear();
                shifted.costs.extend(candidates.costs.iter().map(|score| scale - score));
                &*shifted
            }
        };
        let matching = sparse::solve(pairs, columns, objective.scale(), interrupt)?;
        if !matching.is_unique() {
            return Ok(false);
        }
        for (row, &column) in matching.column_of_row().iter().enumerate() {
            taken[row] = find(candidates, row, column);
        }
        Ok(true)
    }

    /// Solves the whole matrix, as SciPy does.
    fn solve_dense(
        &mut self,
        columns: usize,
        objective: Objective,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        let Self { candidates, taken, matrix, .. } = self;
        let rows = taken.len();
        matrix.clear();
        matrix.resize(rows * columns, objective.alone());
        for (row, range) in candidates.starts.windows(2).enumerate() {
            for k in range[0]..range[1] {
                matrix[row * columns + candidates.columns[k] as usize] = candidates.costs[k];
            }
        }
        let goal = match objective {
            Objective::Most(_) => Goal::Largest,
            Objective::Least(_) => Goal::Least,
        };
        let chosen = dense::solve_until(matrix, rows, columns, goal, interrupt, &mut self.dense)?;
        for (row, &column) in chosen.iter().enumerate() {
            taken[row] = find(candidates, row, u32::try_from(column).unwrap_or(NONE));
        }
        Ok(())
    }
}

/// The candidate of a row in this column, if there is one.
fn find(candidates: &sparse::Pairs, row: usize, column: u32) -> u32 {
    let mut range = candidates.starts[row]..candidates.starts[row + 1];
    range.find(|&k| candidates.columns[k] == column).map_or(NONE, |k| k as u32)
}
