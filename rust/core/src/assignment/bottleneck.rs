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
//! Optimal pairs are not unique. The nearest column is taken, a free one before a taken one and
//! then the one of lower index.
//!
//! Cost: O(n^2 m) for n <= m, nearly always far less.

use crate::assignment::dense::{check_costs, transpose};
use crate::error::{Error, Result};

const NONE: usize = usize::MAX;

/// What one solution needs and the next can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    transposed: Vec<f64>,
    /// The smallest largest cost of a path to each column.
    height: Vec<f64>,
    /// The row before each column on that path.
    previous: Vec<usize>,
    reached: Vec<bool>,
    column_of_row: Vec<usize>,
    row_of_column: Vec<usize>,
}

/// Matches the rows of a C-ordered `rows x columns` matrix with its columns.
///
/// The result is the smallest largest cost (NaN where there are no pairs) and the column of each
/// row, `usize::MAX` for a row without one (where there are more rows than columns).
///
/// # Errors
/// [`Error::InvalidCosts`] for NaN or minus infinity, [`Error::Infeasible`] where every complete
/// matching has an infinite cost.
pub fn solve<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    work: &'w mut Workspace,
) -> Result<(f64, &'w [usize])> {
    check_costs(costs)?;
    if columns >= rows {
        let value = solve_wide(costs, rows, columns, work)?;
        return Ok((value, &work.column_of_row));
    }
    let mut transposed = std::mem::take(&mut work.transposed);
    transpose(costs, rows, columns, &mut transposed);
    let solved = solve_wide(&transposed, columns, rows, work);
    work.transposed = transposed;
    let value = solved?;
    std::mem::swap(&mut work.column_of_row, &mut work.row_of_column);
    Ok((value, &work.column_of_row))
}

/// The same for a matrix with at least as many columns as rows, its elements checked.
fn solve_wide(costs: &[f64], rows: usize, columns: usize, work: &mut Workspace) -> Result<f64> {
    for (values, length) in [(&mut work.column_of_row, rows), (&mut work.row_of_column, columns)] {
        values.clear();
        values.resize(length, NONE);
    }
    if rows == 0 {
        return Ok(f64::NAN);
    }
    let lowest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
    let mut bound = costs.chunks_exact(columns).map(lowest).fold(f64::NEG_INFINITY, f64::max);
    for row in 0..rows {
        let (sink, height) = lowest_path(costs, columns, row, bound, work)?;
        bound = height;
        augment(row, sink, work);
    }
    Ok(bound)
}

/// The free column that a path from `row` reaches at the smallest largest cost, at least `bound`,
/// and that cost.
fn lowest_path(
    costs: &[f64],
    columns: usize,
    row: usize,
    bound: f64,
    work: &mut Workspace,
) -> Result<(usize, f64)> {
    work.height.clear();
    work.height.resize(columns, f64::INFINITY);
    work.previous.resize(columns, NONE);
    work.reached.clear();
    work.reached.resize(columns, false);
    let (mut i, mut bound) = (row, bound);
    loop {
        relax(&costs[i * columns..(i + 1) * columns], i, bound, work);
        let (j, height) = nearest(work).ok_or(Error::Infeasible)?;
        bound = height;
        work.reached[j] = true;
        i = work.row_of_column[j];
        if i == NONE {
            return Ok((j, bound));
        }
    }
}

/// Lowers the paths that lead through row `i`.
fn relax(costs: &[f64], i: usize, bound: f64, work: &mut Workspace) {
    for (j, cost) in costs.iter().enumerate() {
        let through = cost.max(bound);
        if through < work.height[j] {
            work.height[j] = through;
            work.previous[j] = i;
        }
    }
}

/// The column not yet reached with the lowest path, a free one before a taken one.
fn nearest(work: &Workspace) -> Option<(usize, f64)> {
    let (mut lowest, mut nearest, mut nearest_is_free) = (f64::INFINITY, None, false);
    for (j, &height) in work.height.iter().enumerate().filter(|&(j, _)| !work.reached[j]) {
        let free = work.row_of_column[j] == NONE;
        if height < lowest || (height == lowest && free && !nearest_is_free) {
            (lowest, nearest, nearest_is_free) = (height, Some(j), free);
        }
    }
    (lowest < f64::INFINITY).then_some(())?;
    nearest.map(|j| (j, lowest))
}

/// Turns the path from `row` to `sink` into matched pairs.
fn augment(row: usize, sink: usize, work: &mut Workspace) {
    let mut j = sink;
    loop {
        let i = work.previous[j];
        work.row_of_column[j] = i;
        std::mem::swap(&mut work.column_of_row[i], &mut j);
        if i == row {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
