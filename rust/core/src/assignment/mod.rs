//! Who is matched with whom, at the least total cost or at the smallest largest cost.

pub mod bottleneck;
mod columns;
pub mod dense;
mod paths;
pub mod sparse;
mod start;
mod unique;

/// The matched pairs of a matching that is given as the column of each row: rows in rising order
/// and their columns. `usize::MAX` stands for a row without a column.
pub fn pairs(column_of_row: &[usize]) -> (Vec<i64>, Vec<i64>) {
    let matched = column_of_row.iter().enumerate().filter(|(_, j)| **j != usize::MAX);
    matched.map(|(i, &j)| (i as i64, j as i64)).unzip()
}
