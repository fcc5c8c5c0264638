//! A quick start for shortest augmenting paths: most rows are matched, and duals found, by looking
//! at single rows and columns.
//!
//! Jonker and Volgenant, "A shortest augmenting path algorithm for dense and sparse linear assignment
//! problems", Computing 38, 1987, doi:10.1007/BF02278710: column reduction (of square matrices), then
//! augmenting row reduction. The latter creeps by ever smaller amounts where many costs are close,
//! as they are between points: it gets as many looks at a row as there are rows, and no more.

use super::augmenting_paths::Matching;
use super::column_search::{each_vector, two_lowest};
use crate::simd::lower;
use pulp::Simd;

const NONE: usize = usize::MAX;

/// Matches rows of a fresh `matching`; returns the rows that are still free, or `None` where a row
/// or a column has no finite cost.
#[inline(always)]
pub(super) fn start<S: Simd>(
    simd: S,
    costs: &[f64],
    rows: usize,
    columns: usize,
    matching: &mut Matching,
) -> Option<Vec<usize>> {
    if rows == columns {
        reduce_columns(simd, costs, columns, matching)?;
    }
    let free = (0..rows).filter(|&i| matching.column_of_row[i] == NONE).collect();
    let free = reduce_rows(simd, costs, columns, free, matching)?;
    for (i, &j) in matching.column_of_row.iter().enumerate().filter(|(_, j)| **j != NONE) {
        matching.row_dual[i] = costs[i * columns + j] - matching.columns.dual[j];
    }
    Some(free)
}

/// Gives every column its lowest cost as dual, and the row of that cost where it is free.
#[inline(always)]
fn reduce_columns<S: Simd>(
    simd: S,
    costs: &[f64],
    columns: usize,
    matching: &mut Matching,
) -> Option<()> {
    let found = &mut matching.columns;
    found.dual[..columns].fill(f64::INFINITY);
    found.via.fill(0.0);
    for (i, row) in costs.chunks_exact(columns).enumerate() {
        let (lowest, _) = S::as_mut_simd_f64s(&mut found.dual);
        let (row_of_lowest, _) = S::as_mut_simd_f64s(&mut found.via);
        let (i, none) = (simd.splat_f64s(i as f64), simd.splat_f64s(0.0));
        each_vector(
            simd,
            row,
            lowest.len(),
            #[inline(always)]
            |costs, k| {
                let lower = simd.less_than_f64s(costs, lowest[k]);
                lowest[k] = simd.min_f64s(costs, lowest[k]);
                // Rows rise: the maximum writes whole vectors.
                let here = simd.select_f64s(lower, i, none);
                row_of_lowest[k] = simd.max_f64s(here, row_of_lowest[k]);
            },
        );
    }
    for j in (0..columns).rev() {
        if matching.columns.dual[j] == f64::INFINITY {
            return None;
        }
        let i = matching.columns.via[j] as usize;
        if matching.column_of_row[i] == NONE {
            matching.set(i, j);
        }
    }
    Some(())
}

/// Matches each free row with its nearest column, which becomes costlier by as much as the row can pay
/// before its second nearest is as good; a row that loses its column is next.
#[inline(always)]
fn reduce_rows<S: Simd>(
    simd: S,
    costs: &[f64],
    columns: usize,
    free: Vec<usize>,
    matching: &mut Matching,
) -> Option<Vec<usize>> {
    let mut looks = matching.column_of_row.len();
    let mut left = Vec::new();
    for row in free {
        let mut i = row;
        loop {
            if looks == 0 {
                left.push(i);
                break;
            }
            looks -= 1;
            let (lowest, second, j) =
                two_lowest(simd, &costs[i * columns..(i + 1) * columns], &matching.columns);
            if lowest == f64::INFINITY {
                return None;
            }
            let owner = matching.row_of_column[j];
            let dual = matching.columns.dual[j] - (second - lowest);
            let costlier = second < f64::INFINITY && dual < matching.columns.dual[j];
            if owner != NONE && !costlier {
                left.push(i);
                break;
            }
            if costlier {
                lower(simd, S::as_mut_simd_f64s(&mut matching.columns.dual).0, j, dual);
            }
            matching.set(i, j);
            if owner == NONE {
                break;
            }
            matching.column_of_row[owner] = NONE;
            i = owner;
        }
    }
    Some(left)
}
