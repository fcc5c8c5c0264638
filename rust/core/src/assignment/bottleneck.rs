//! The bottleneck assignment problem: a complete matching whose largest cost is as small as it can
//! be.
//!
//! For costs `C` (`n x m`), over the matchings `M` of `min(n, m)` pairs,
//!
//! ```text
//! minimise  max over (i, j) in M of  C[i, j]
//! ```
//!
//! Burkard, Dell'Amico and Martello, "Assignment Problems", SIAM 2012, section 6.2,
//! doi:10.1137/1.9781611972238.
//!
//! Rows enter one by one along a path whose largest cost is the smallest. The bound rises only
//! where the rows reached have no other column at or below it, and then no complete matching of
//! them has one: the bound at the end is the optimum. It starts at the largest of the row minima,
//! which no matching can beat.
//!
//! Optimal pairs are not unique. Ties fall as in [`dense`](super::dense).
//!
//! Cost: O(n^2 m) for n <= m, nearly always far less.

use super::augmenting_paths::Matching;
use super::dense::{PATIENCE, check_costs, transpose};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

/// What one solution needs and the next can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    transposed: Vec<f64>,
    matching: Matching,
}

/// Matches the rows of a C-ordered `rows x columns` matrix with its columns.
///
/// The result is the smallest largest cost (NaN where there are no pairs) and the column of each
/// row, `usize::MAX` for a row without one (where there are more rows than columns).
///
/// # Errors
/// [`Error::InvalidCosts`](crate::Error::InvalidCosts) for NaN or minus infinity,
/// [`Error::Infeasible`](crate::Error::Infeasible) where every complete matching has an infinite
/// cost.
pub fn solve<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    work: &'w mut Workspace,
) -> Result<(f64, &'w [usize])> {
    solve_until(costs, rows, columns, &Interrupt::never(), work)
}

/// [`solve`], until it is interrupted.
///
/// # Errors
/// Those of [`solve`]; [`Error::Interrupted`](crate::Error::Interrupted).
pub fn solve_until<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    interrupt: &Interrupt<'_>,
    work: &'w mut Workspace,
) -> Result<(f64, &'w [usize])> {
    check_costs(costs)?;
    let Workspace { transposed, matching } = work;
    if columns >= rows {
        let value = dispatch(Solve { costs, rows, columns, interrupt, matching })?;
        return Ok((value, &matching.column_of_row));
    }
    transpose(costs, rows, columns, transposed);
    let (rows, columns) = (columns, rows);
    let value = dispatch(Solve { costs: transposed, rows, columns, interrupt, matching })?;
    std::mem::swap(&mut matching.column_of_row, &mut matching.row_of_column);
    Ok((value, &matching.column_of_row))
}

/// A matrix with at least as many columns as rows, its elements checked.
struct Solve<'a> {
    costs: &'a [f64],
    rows: usize,
    columns: usize,
    interrupt: &'a Interrupt<'a>,
    matching: &'a mut Matching,
}

impl WithSimd for Solve<'_> {
    type Output = Result<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<f64> {
        let Self { costs, rows, columns, interrupt, matching } = self;
        matching.reset(rows, columns);
        if rows == 0 {
            return Ok(f64::NAN);
        }
        let lowest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
        let mut bound = costs.chunks_exact(columns).map(lowest).fold(f64::NEG_INFINITY, f64::max);
        let patience = PATIENCE / columns + 1;
        for row in 0..rows {
            if row % patience == 0 {
                interrupt.check()?;
            }
            bound = matching.add_below(simd, costs, row, bound)?;
        }
        Ok(bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    const NONE: usize = usize::MAX;

    #[test]
    fn the_smallest_largest_cost_is_not_the_least_sum() {
        let costs = [0.0, 5.0, 6.0, 9.0];
        let mut work = Workspace::default();
        assert_eq!(solve(&costs, 2, 2, &mut work), Ok((6.0, &[1, 0][..])));
    }

    #[test]
    fn more_rows_than_columns_leave_rows_alone() {
        let mut work = Workspace::default();
        assert_eq!(solve(&[9.0, 1.0, 5.0], 3, 1, &mut work), Ok((1.0, &[NONE, 0, NONE][..])));
        let (value, columns) = solve(&[], 3, 0, &mut work).unwrap();
        assert!(value.is_nan());
        assert_eq!(columns, &[NONE; 3]);
    }

    #[test]
    fn what_cannot_be_matched_is_an_error() {
        let mut work = Workspace::default();
        let inf = f64::INFINITY;
        assert_eq!(solve(&[inf, inf, 1.0, 1.0], 2, 2, &mut work), Err(Error::Infeasible));
        assert_eq!(solve(&[1.0, inf, 1.0, inf], 2, 2, &mut work), Err(Error::Infeasible));
        assert_eq!(solve(&[f64::NAN], 1, 1, &mut work), Err(Error::InvalidCosts));
        assert_eq!(solve(&[-inf], 1, 1, &mut work), Err(Error::InvalidCosts));
    }
}
