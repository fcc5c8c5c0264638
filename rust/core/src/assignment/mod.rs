//! Which points are matched, at the least total cost or at the smallest largest cost.

pub(crate) mod alternating_cycle;
pub mod auction;
mod augmenting_paths;
pub mod batch;
pub mod bottleneck;
mod column_search;
pub mod dense;
mod reduction;
pub mod sparse;
mod unique;

/// The matched pairs of a matching that is given as the column of each row: rows in rising order
/// and their columns. `usize::MAX` stands for a row without a column.
pub fn pairs(column_of_row: &[usize]) -> (Vec<i64>, Vec<i64>) {
    let mut rows = Vec::with_capacity(column_of_row.len());
    let mut columns = Vec::with_capacity(column_of_row.len());
    for (i, &j) in column_of_row.iter().enumerate().filter(|(_, j)| **j != usize::MAX) {
        rows.push(i as i64);
        columns.push(j as i64);
    }
    (rows, columns)
}
