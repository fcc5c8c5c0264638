//! The linear assignment problem of a dense cost matrix, by shortest augmenting paths.
//!
//! Given costs `C` (`n x m`), find the matching of `min(n, m)` pairs with the least sum of costs.
//! Crouse, "On implementing 2D rectangular assignment algorithms", IEEE Trans. Aerospace and
//! Electronic Systems 52(4), 2016, doi:10.1109/TAES.2016.140952.
//!
//! Ties are broken as SciPy's `linear_sum_assignment` does: rows enter one by one, the columns not
//! yet reached stand in a list filled from the last to the first and emptied by swapping with its
//! end, the first of equal minima is taken, and a later free column wins a tie. Every sum below is
//! written in SciPy's order, since another order rounds differently and so ties differently.
//!
//! Cost: O(n^2 m) for n <= m.

use crate::error::{Error, Result};

const NONE: usize = usize::MAX;

/// What one solution needs and the next can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    transposed: Vec<f64>,
    negated: Vec<f64>,
    /// Dual of each row, `u`.
    row_dual: Vec<f64>,
    /// Dual of each column, `v`.
    column_dual: Vec<f64>,
    /// Length of the shortest path to each column.
    distance: Vec<f64>,
    /// The row before each column on that path.
    previous: Vec<usize>,
    column_of_row: Vec<usize>,
    row_of_column: Vec<usize>,
    row_reached: Vec<bool>,
    column_reached: Vec<bool>,
    remaining: Vec<usize>,
}

impl Workspace {
    /// The column matched with each row of the last solution; `usize::MAX` for none.
    pub fn column_of_row(&self) -> &[usize] {
        &self.column_of_row
    }
}

/// Matches the rows of a C-ordered `rows x columns` matrix with its columns.
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
    check_costs(costs)?;
    if columns >= rows {
        solve_wide(costs, rows, columns, work)?;
        return Ok(&work.column_of_row);
    }
    let mut transposed = std::mem::take(&mut work.transposed);
    transpose(costs, rows, columns, &mut transposed);
    let solved = solve_wide(&transposed, columns, rows, work);
    work.transposed = transposed;
    solved?;
    std::mem::swap(&mut work.column_of_row, &mut work.row_of_column);
    Ok(&work.column_of_row)
}

/// Matches rows and columns at the largest total cost: [`solve`] for the negated costs.
///
/// # Errors
/// [`Error::InvalidCosts`] for NaN or plus infinity, [`Error::Infeasible`] where every complete
/// matching has a cost of minus infinity.
pub fn solve_largest<'w>(
    costs: &[f64],
    rows: usize,
    columns: usize,
    work: &'w mut Workspace,
) -> Result<&'w [usize]> {
    let mut negated = std::mem::take(&mut work.negated);
    negated.clear();
    negated.extend(costs.iter().map(|cost| -cost));
    let solved = solve(&negated, rows, columns, work).map(|_| ());
    work.negated = negated;
    solved?;
    Ok(&work.column_of_row)
}

/// The same for a matrix with at least as many columns as rows, its elements checked.
fn solve_wide(costs: &[f64], rows: usize, columns: usize, work: &mut Workspace) -> Result<()> {
    reset(&mut work.row_dual, rows, 0.0);
    reset(&mut work.column_dual, columns, 0.0);
    reset(&mut work.distance, columns, 0.0);
    reset(&mut work.previous, columns, NONE);
    reset(&mut work.column_of_row, rows, NONE);
    reset(&mut work.row_of_column, columns, NONE);
    reset(&mut work.row_reached, rows, false);
    reset(&mut work.column_reached, columns, false);
    for row in 0..rows {
        let (sink, length) = shortest_path(costs, columns, row, work)?;
        update_duals(row, length, work);
        augment(row, sink, work);
    }
    Ok(())
}

/// Refuses what no assignment can use.
pub(super) fn check_costs(costs: &[f64]) -> Result<()> {
    if costs.iter().any(|c| c.is_nan() || *c == f64::NEG_INFINITY) {
        return Err(Error::InvalidCosts);
    }
    Ok(())
}

/// Writes the transposed of a `rows x columns` matrix to `output`.
pub(super) fn transpose(costs: &[f64], rows: usize, columns: usize, output: &mut Vec<f64>) {
    output.clear();
    output.extend((0..columns).flat_map(|j| (0..rows).map(move |i| costs[i * columns + j])));
}

fn reset<T: Clone>(values: &mut Vec<T>, length: usize, value: T) {
    values.clear();
    values.resize(length, value);
}

/// The nearest free column from `row` along reduced costs, and its distance.
fn shortest_path(
    costs: &[f64],
    columns: usize,
    row: usize,
    work: &mut Workspace,
) -> Result<(usize, f64)> {
    work.remaining.clear();
    work.remaining.extend((0..columns).rev());
    work.row_reached.fill(false);
    work.column_reached.fill(false);
    work.distance.fill(f64::INFINITY);
    let (mut i, mut length) = (row, 0.0);
    loop {
        work.row_reached[i] = true;
        let index = relax(&costs[i * columns..(i + 1) * columns], i, length, work);
        let Some((index, lowest)) = index else {
            return Err(Error::Infeasible);
        };
        length = lowest;
        let j = work.remaining.swap_remove(index);
        work.column_reached[j] = true;
        if work.row_of_column[j] == NONE {
            return Ok((j, length));
        }
        i = work.row_of_column[j];
    }
}

/// Shortens the paths that lead through row `i`, and finds the nearest column not yet reached.
fn relax(costs: &[f64], i: usize, length: f64, work: &mut Workspace) -> Option<(usize, f64)> {
    let (mut lowest, mut nearest) = (f64::INFINITY, None);
    for (index, &j) in work.remaining.iter().enumerate() {
        let through = length + costs[j] - work.row_dual[i] - work.column_dual[j];
        if through < work.distance[j] {
            work.previous[j] = i;
            work.distance[j] = through;
        }
        let distance = work.distance[j];
        let free = work.row_of_column[j] == NONE;
        if distance < lowest || (distance == lowest && free) {
            lowest = distance;
            nearest = Some(index);
        }
    }
    (lowest < f64::INFINITY).then_some(())?;
    nearest.map(|index| (index, lowest))
}

fn update_duals(row: usize, length: f64, work: &mut Workspace) {
    work.row_dual[row] += length;
    for i in 0..work.row_dual.len() {
        if work.row_reached[i] && i != row {
            work.row_dual[i] += length - work.distance[work.column_of_row[i]];
        }
    }
    for j in 0..work.column_dual.len() {
        if work.column_reached[j] {
            work.column_dual[j] -= length - work.distance[j];
        }
    }
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

    #[test]
    fn what_cannot_be_matched_is_an_error() {
        let mut work = Workspace::default();
        let inf = f64::INFINITY;
        assert_eq!(solve(&[inf, inf, 1.0, 1.0], 2, 2, &mut work), Err(Error::Infeasible));
        assert_eq!(solve(&[f64::NAN], 1, 1, &mut work), Err(Error::InvalidCosts));
        assert_eq!(solve(&[-inf], 1, 1, &mut work), Err(Error::InvalidCosts));
    }
}
