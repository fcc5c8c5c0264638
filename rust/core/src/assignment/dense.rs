//! The linear assignment problem of a dense cost matrix, by shortest augmenting paths.
//!
//! Given costs `C` (`n x m`), find the matching of `min(n, m)` pairs with the least sum of costs.
//! Crouse, "On implementing 2D rectangular assignment algorithms", IEEE Trans. Aerospace and
//! Electronic Systems 52(4), 2016, doi:10.1109/TAES.2016.140952.
//!
//! Ties are broken as SciPy's `linear_sum_assignment` does: rows enter one by one, the columns not
//! yet reached stand in a list filled from the last to the first and emptied by swapping with its
//! end, the first of equal minima is taken, and a later free column wins a tie. Every sum is
//! written in SciPy's order, since another order rounds differently and so ties differently.
//!
//! The order of the rows costs time: from a quick start (`start`) an optimum is found sooner. It is
//! taken where the duals prove that no other matching is within 1e-12 of the largest |cost|
//! (`unique`), so that SciPy's order would have found the same one.
//!
//! Cost: O(n^2 m) for n <= m.

use super::augmenting_paths::Matching;
use super::column_search::each_vector;
use super::reduction::start;
use super::unique::{Moves, is_unique};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

/// How many columns times rows enter between two looks for an interrupt.
pub(super) const PATIENCE: usize = 1 << 16;

/// What one solution needs and the next can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    /// The costs transposed, negated or both.
    turned: Vec<f64>,
    matching: Matching,
    moves: Moves,
}

impl Workspace {
    /// The column matched with each row of the last solution; `usize::MAX` for none.
    pub fn column_of_row(&self) -> &[usize] {
        &self.matching.column_of_row
    }
}

/// What is to be made of the total cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// As small as it can be.
    Least,
    /// As large as it can be.
    Largest,
}

/// Matches the rows of a C-ordered `rows x columns` matrix with its columns at the least total cost.
///
/// The result is the column of each row, `usize::MAX` for a row without one (where there are more
/// rows than columns).
///
/// # Errors
/// [`Error::InvalidCosts`] for NaN or minus infinity, [`Error::Infeasible`] where every complete
/// matching has an infinite cost.
pub fn solve<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    work: &'w mut Workspace,
) -> Result<&'w [usize]> {
    solve_until(costs, rows, columns, Goal::Least, &Interrupt::never(), work)
}

/// [`solve`] for either goal, until it is interrupted.
///
/// # Errors
/// Those of [`solve`], for the negated costs where the goal is [`Goal::Largest`];
/// [`Error::Interrupted`].
pub fn solve_until<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    goal: Goal,
    interrupt: &Interrupt<'_>,
    work: &'w mut Workspace,
) -> Result<&'w [usize]> {
    let tall = rows > columns;
    let (short, long) = if tall { (columns, rows) } else { (rows, columns) };
    let Workspace { turned, matching, moves } = work;
    let costs = match (tall, goal) {
        (false, Goal::Least) => costs,
        _ => {
            turn(costs, rows, columns, tall, goal, turned);
            turned
        }
    };
    dispatch(Solve { costs, rows: short, columns: long, interrupt, matching, moves })?;
    if tall {
        std::mem::swap(&mut matching.column_of_row, &mut matching.row_of_column);
    }
    Ok(&matching.column_of_row)
}

/// Refuses what no assignment can use.
pub(super) fn check_costs(costs: &[f64]) -> Result<()> {
    if costs.iter().any(|c| c.is_nan() || *c == f64::NEG_INFINITY) {
        return Err(Error::InvalidCosts);
    }
    Ok(())
}

/// Writes the costs to `output` with no more rows than columns and so that the least is wanted.
pub(super) fn turn(
    costs: &[f64],
    rows: usize,
    columns: usize,
    tall: bool,
    goal: Goal,
    output: &mut Vec<f64>,
) {
    if tall {
        transpose(costs, rows, columns, output);
    } else {
        output.clear();
        output.extend_from_slice(costs);
    }
    if goal == Goal::Largest {
        output.iter_mut().for_each(|cost| *cost = -*cost);
    }
}

/// Writes the transposed of a `rows x columns` matrix to `output`.
pub(super) fn transpose(costs: &[f64], rows: usize, columns: usize, output: &mut Vec<f64>) {
    output.clear();
    output.extend((0..columns).flat_map(|j| (0..rows).map(move |i| costs[i * columns + j])));
}

/// A matrix with at least as many columns as rows, its elements checked.
struct Solve<'a> {
    costs: &'a [f64],
    rows: usize,
    columns: usize,
    interrupt: &'a Interrupt<'a>,
    matching: &'a mut Matching,
    moves: &'a mut Moves,
}

impl WithSimd for Solve<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<()> {
        if self.rows == 0 {
            self.matching.reset(0, self.columns);
            return Ok(());
        }
        let largest = check(simd, self.costs)?;
        if self.quick_pays() && self.quick(simd, largest)? {
            return Ok(());
        }
        self.in_order(simd)
    }
}

impl Solve<'_> {
    /// Whether a quick start is likely to be worth its passes over the costs, as measured: small
    /// matrices are solved sooner, and where there are more columns than rows, most rows find a free
    /// one at once anyway.
    fn quick_pays(&self) -> bool {
        let least = if self.rows == self.columns { 40 } else { 400 };
        self.rows >= least && !looks_tied(self.costs)
    }

    /// Finds an optimal matching from a quick start; returns whether it is the only one.
    #[inline(always)]
    fn quick<S: Simd>(&mut self, simd: S, largest: f64) -> Result<bool> {
        let Self { costs, rows, columns, .. } = *self;
        self.matching.reset(rows, columns);
        let Some(free) = start(simd, costs, rows, columns, self.matching) else {
            return Ok(false);
        };
        let patience = PATIENCE / columns.max(1) + 1;
        for (count, &row) in free.iter().enumerate() {
            if count % patience == 0 {
                self.interrupt.check()?;
            }
            // Sums may overflow here and not in the order of the rows.
            if self.matching.add(simd, costs, row).is_err() {
                return Ok(false);
            }
        }
        Ok(is_unique(simd, costs, largest, self.matching, self.moves))
    }

    /// Adds row after row, as SciPy does.
    #[inline(always)]
    fn in_order<S: Simd>(&mut self, simd: S) -> Result<()> {
        self.matching.reset(self.rows, self.columns);
        let patience = PATIENCE / self.columns.max(1) + 1;
        for row in 0..self.rows {
            if row % patience == 0 {
                self.interrupt.check()?;
            }
            self.matching.add(simd, self.costs, row)?;
        }
        Ok(())
    }
}

/// Refuses what no assignment can use; returns the largest |cost| that is finite.
#[inline(always)]
fn check<S: Simd>(simd: S, costs: &[f64]) -> Result<f64> {
    let zero = simd.splat_f64s(0.0);
    let (mut largest, mut sum) = (zero, zero);
    each_vector(
        simd,
        costs,
        usize::MAX,
        #[inline(always)]
        |costs, _| {
            largest = simd.max_f64s(largest, simd.abs_f64s(costs));
            // 0 for a finite number, NaN for any other.
            sum = simd.add_f64s(sum, simd.mul_f64s(costs, zero));
        },
    );
    if simd.reduce_sum_f64s(sum) == 0.0 {
        return Ok(simd.reduce_max_f64s(largest));
    }
    check_costs(costs)?;
    Ok(costs.iter().filter(|c| c.is_finite()).fold(0.0, |most, c| most.max(c.abs())))
}

/// Whether a few costs, taken here and there, hold equal ones: then it is likely that there is more
/// than one optimal matching. A wrong answer costs time only.
fn looks_tied(costs: &[f64]) -> bool {
    const SAMPLE: usize = 32;
    let mut sample = [f64::INFINITY; SAMPLE];
    let stride = (costs.len() / SAMPLE) | 1;
    for (place, &cost) in sample.iter_mut().zip(costs.iter().step_by(stride)) {
        *place = cost;
    }
    sample.sort_unstable_by(f64::total_cmp);
    sample.windows(2).any(|pair| pair[0] == pair[1] && pair[0] < f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Width, set_width};

    const NONE: usize = usize::MAX;

    #[test]
    fn equal_costs_fall_on_the_diagonal() {
        let mut work = Workspace::default();
        assert_eq!(solve(&[1.0; 9], 3, 3, &mut work), Ok(&[0, 1, 2][..]));
    }

    #[test]
    fn more_rows_than_columns_leave_rows_alone() {
        let mut work = Workspace::default();
        let costs = [9.0, 1.0, 5.0];
        assert_eq!(solve(&costs, 3, 1, &mut work), Ok(&[NONE, 0, NONE][..]));
        assert_eq!(solve(&[], 3, 0, &mut work), Ok(&[NONE; 3][..]));
        assert_eq!(solve(&[], 0, 3, &mut work), Ok(&[][..]));
    }

    /// On narrow vectors, columns behind the last vector once kept the distances of the problem
    /// before, and a smaller problem could be matched with them.
    #[test]
    fn a_used_workspace_changes_nothing_on_any_width() {
        let (mut used, mut state) = (Workspace::default(), 1_u64);
        let mut random = |below: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % below
        };
        for _ in 0..2000 {
            let (m, n) = (1 + random(20) as usize, 1 + random(20) as usize);
            let costs: Vec<f64> = (0..m * n).map(|_| random(4) as f64).collect();
            let expected = solve(&costs, m, n, &mut Workspace::default()).unwrap().to_vec();
            for width in [Width::Scalar, Width::V3, Width::Widest] {
                set_width(width);
                assert_eq!(solve(&costs, m, n, &mut used).unwrap(), expected);
            }
        }
    }

    #[test]
    fn what_cannot_be_matched_is_an_error() {
        let mut work = Workspace::default();
        let inf = f64::INFINITY;
        assert_eq!(solve(&[inf, inf, 1.0, 1.0], 2, 2, &mut work), Err(Error::Infeasible));
        assert_eq!(solve(&[f64::NAN], 1, 1, &mut work), Err(Error::InvalidCosts));
        assert_eq!(solve(&[-inf], 1, 1, &mut work), Err(Error::InvalidCosts));
        assert_eq!(solve(&[1.0, 2.0, 3.0, 5.0], 2, 2, &mut work), Ok(&[1, 0][..]));
    }
}
