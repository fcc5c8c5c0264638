//! Bertsekas' auction for the linear assignment problem of a dense cost matrix.
//!
//! Rows bid for columns. A row without a column looks at the columns' value `-C[i, j] - price[j]`,
//! takes the best one away from whoever holds it and raises its price by the difference to the
//! second best and by epsilon. When every row has a column, the total is within `n epsilon` of the
//! least. Prices are found for a large epsilon first and kept for a smaller one (epsilon scaling).
//!
//! Bertsekas, "The auction algorithm: a distributed relaxation method for the assignment problem",
//! Annals of Operations Research 14, 1988, doi:10.1007/BF02186476; Bertsekas and Castanon, "A
//! forward/reverse auction algorithm for asymmetric assignment problems", Computational Optimization
//! and Applications 1, 1992, doi:10.1007/BF00249638, on why a rectangular problem whose prices are
//! kept from a larger epsilon needs more than that: here it is padded to a square one with rows that
//! cost nothing.
//!
//! The bound is not taken from the theory but computed: prices, and profits of the rows at these
//! prices, are feasible duals, whose sum no matching can beat. So it also covers the rounding.
//!
//! Cost: O(n^2 m log(n C / epsilon)) for costs of at most C.

use super::bottleneck;
use super::column_search::{Columns, two_lowest};
use super::dense::{Goal, PATIENCE, check_costs, turn};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::simd::{dispatch, lower};
use pulp::{Simd, WithSimd};

const NONE: usize = usize::MAX;

/// By how much epsilon shrinks from one round to the next.
const SHRINK: f64 = 5.0;

/// A complete matching and how far it can be from the best one.
#[derive(Debug, Clone, PartialEq)]
pub struct Auction {
    /// The column of each row, `usize::MAX` for a row without one.
    pub column_of_row: Vec<usize>,
    /// The last epsilon.
    pub epsilon: f64,
    /// The total cost is at most this far from the best one.
    pub bound: f64,
}

/// What one solution needs and the next can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    turned: Vec<f64>,
    /// The costs of a row that was added.
    zeros: Vec<f64>,
    /// The dual of a column is its price, negated.
    columns: Columns,
    row_of_column: Vec<usize>,
    free: Vec<usize>,
    feasible: bottleneck::Workspace,
}

/// Matches the rows of a C-ordered `rows x columns` matrix with its columns.
///
/// Without `epsilon` it is small enough for the optimum where all costs are whole numbers, and
/// otherwise for a bound of a millionth of the largest |cost|.
///
/// # Errors
/// [`Error::InvalidCosts`] and [`Error::Infeasible`] as in [`dense`](super::dense), before anything
/// is bid; [`Error::Parameter`] for an epsilon that is not positive, or so small that prices would not
/// change by it; [`Error::Interrupted`].
pub fn solve(
    costs: &[f64],
    rows: usize,
    columns: usize,
    epsilon: Option<f64>,
    goal: Goal,
    interrupt: &Interrupt<'_>,
    work: &mut Workspace,
) -> Result<Auction> {
    let tall = rows > columns;
    let (short, long) = if tall { (columns, rows) } else { (rows, columns) };
    let mut turned = std::mem::take(&mut work.turned);
    turn(costs, rows, columns, tall, goal, &mut turned);
    check_costs(&turned)?;
    bottleneck::solve_until(&turned, short, long, interrupt, &mut work.feasible)?;
    let largest = turned.iter().filter(|c| c.is_finite()).fold(0.0f64, |most, c| most.max(c.abs()));
    if !(64.0 * largest * long as f64).is_finite() {
        return Err(Error::Parameter {
            argument: "cost_matrix",
            requirement: "so small that its elements can be added",
            value: largest,
        });
    }
    let whole = turned.iter().all(|c| c.fract() == 0.0 || *c == f64::INFINITY);
    let epsilon = final_epsilon(epsilon, long, largest, whole)?;
    let problem = Problem { costs: &turned, rows: short, columns: long, largest, epsilon };
    let bound = dispatch(Solve { problem, interrupt, work })?;
    work.turned = turned;
    let exact = bound == 0.0 || (whole && bound < 1.0);
    let column_of_row = read(&work.row_of_column, rows, columns, tall);
    Ok(Auction { column_of_row, epsilon, bound: if exact { 0.0 } else { bound } })
}

/// The last epsilon: the caller's, checked, or the default.
fn final_epsilon(epsilon: Option<f64>, size: usize, largest: f64, whole: bool) -> Result<f64> {
    // Prices reach size * largest, and have 52 bits.
    let least = largest * f64::max(1e-12, 1e-15 * size as f64);
    let size = size.max(1) as f64;
    let Some(value) = epsilon else {
        let default =
            if whole || largest == 0.0 { 1.0 / (size + 1.0) } else { 1e-6 * largest / size };
        return Ok(default.max(least));
    };
    let requirement = match () {
        () if !(value > 0.0 && value.is_finite()) => "positive and finite",
        () if value < least => "at least 1e-12 (and 1e-15 a row) of the largest cost",
        () => return Ok(value),
    };
    Err(Error::Parameter { argument: "epsilon", requirement, value })
}

/// The column of each row of the matrix as it was given.
fn read(row_of_column: &[usize], rows: usize, columns: usize, tall: bool) -> Vec<usize> {
    if tall {
        return row_of_column.iter().map(|&i| if i < columns { i } else { NONE }).collect();
    }
    let mut column_of_row = vec![NONE; rows];
    for (j, &i) in row_of_column.iter().enumerate().filter(|&(_, &i)| i < rows) {
        column_of_row[i] = j;
    }
    column_of_row
}

/// A matrix with at least as many columns as rows, feasible.
#[derive(Clone, Copy)]
struct Problem<'a> {
    costs: &'a [f64],
    rows: usize,
    columns: usize,
    largest: f64,
    epsilon: f64,
}

struct Solve<'a> {
    problem: Problem<'a>,
    interrupt: &'a Interrupt<'a>,
    work: &'a mut Workspace,
}

impl WithSimd for Solve<'_> {
    type Output = Result<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<f64> {
        let Self { problem, interrupt, work } = self;
        work.columns.reset(problem.columns);
        work.zeros.clear();
        work.zeros.resize(problem.columns, 0.0);
        let mut epsilon = f64::max(problem.largest / 2.0, problem.epsilon);
        loop {
            work.auction(simd, problem, epsilon, interrupt)?;
            if epsilon <= problem.epsilon {
                return Ok(work.bound(simd, problem));
            }
            epsilon = f64::max(epsilon / SHRINK, problem.epsilon);
        }
    }
}

impl Workspace {
    /// Lets rows bid until each has a column.
    #[inline(always)]
    fn auction<S: Simd>(
        &mut self,
        simd: S,
        problem: Problem<'_>,
        epsilon: f64,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        self.row_of_column.clear();
        self.row_of_column.resize(problem.columns, NONE);
        self.free.clear();
        self.free.extend((0..problem.columns).rev());
        let patience = PATIENCE / problem.columns.max(1) + 1;
        let mut bids = 0;
        while let Some(i) = self.free.pop() {
            bids += 1;
            if bids % patience == 0 {
                interrupt.check()?;
            }
            let (lowest, second, j) = two_lowest(simd, row(problem, i, &self.zeros), &self.columns);
            // A row with one column only can pay any price.
            let costlier = if second < f64::INFINITY { second - lowest } else { problem.largest };
            let dual = self.columns.dual[j] - (costlier + epsilon);
            lower(simd, S::as_mut_simd_f64s(&mut self.columns.dual).0, j, dual);
            let owner = std::mem::replace(&mut self.row_of_column[j], i);
            if owner != NONE {
                self.free.push(owner);
            }
        }
        Ok(())
    }

    /// How much costlier the matching is than the duals prove every one to be: what each row pays more
    /// than in its best column, and what sums may have lost by rounding.
    #[inline(always)]
    fn bound<S: Simd>(&self, simd: S, problem: Problem<'_>) -> f64 {
        let duals = &self.columns.dual[..problem.columns];
        let scale = duals.iter().fold(problem.largest, |most, dual| most.max(dual.abs()));
        let mut bound = 0.0;
        for (j, &i) in self.row_of_column.iter().enumerate() {
            let costs = row(problem, i, &self.zeros);
            let (lowest, _, _) = two_lowest(simd, costs, &self.columns);
            bound += (costs[j] - duals[j]) - lowest;
        }
        bound + 2.0 * f64::EPSILON * scale * problem.columns as f64
    }
}

/// The costs of row `i`, which are 0 for a row that was added.
#[inline(always)]
fn row<'a>(problem: Problem<'a>, i: usize, zeros: &'a [f64]) -> &'a [f64] {
    if i < problem.rows { &problem.costs[i * problem.columns..][..problem.columns] } else { zeros }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(
        costs: &[f64],
        rows: usize,
        columns: usize,
        epsilon: Option<f64>,
    ) -> Result<Auction> {
        let mut work = Workspace::default();
        solve(costs, rows, columns, epsilon, Goal::Least, &Interrupt::never(), &mut work)
    }

    #[test]
    fn whole_numbers_are_solved_to_the_optimum() {
        let costs = [4.0, 1.0, 3.0, 2.0, 0.0, 5.0, 3.0, 2.0, 2.0];
        let found = columns(&costs, 3, 3, None).unwrap();
        assert_eq!((found.column_of_row, found.bound), (vec![1, 0, 2], 0.0));
        let found = columns(&[9.0, 1.0, 5.0], 3, 1, None).unwrap();
        assert_eq!(found.column_of_row, [NONE, 0, NONE]);
        assert_eq!(columns(&[], 0, 0, None).unwrap().column_of_row, []);
    }

    #[test]
    fn what_cannot_be_solved_is_an_error() {
        let inf = f64::INFINITY;
        assert_eq!(columns(&[inf, inf, 1.0, 1.0], 2, 2, None), Err(Error::Infeasible));
        assert_eq!(columns(&[f64::NAN], 1, 1, None), Err(Error::InvalidCosts));
        for epsilon in [0.0, -1.0, f64::NAN, inf, 1e-13] {
            assert!(matches!(columns(&[1.0], 1, 1, Some(epsilon)), Err(Error::Parameter { .. })));
        }
    }

    #[test]
    fn a_column_that_only_one_row_can_take() {
        let inf = f64::INFINITY;
        let found = columns(&[1.0, inf, 1.0, 9.0], 2, 2, None).unwrap();
        assert_eq!((found.column_of_row, found.bound), (vec![0, 1], 0.0));
    }
}
