//! Sets of at most three points: every assignment is looked at.

use super::cutoff::Cutoff;
use crate::points::Points;

/// The largest set that is worth it.
pub(super) const LARGEST: usize = 3;

/// The least total cost of matching every point of `x` with one of `y`, for
/// `1 <= x.len() <= y.len() <= 3`.
#[inline]
pub(super) fn least_total(x: Points, y: Points, cutoff: &Cutoff) -> f64 {
    match x.dimension() {
        1 => of_dimension::<1>(x, y, cutoff),
        2 => of_dimension::<2>(x, y, cutoff),
        3 => of_dimension::<3>(x, y, cutoff),
        _ => over_assignments(x.len(), y.len(), |i, j| cutoff.cost_of_square(square(x, y, i, j))),
    }
}

#[inline]
fn of_dimension<const D: usize>(x: Points, y: Points, cutoff: &Cutoff) -> f64 {
    let (a, b) = (x.coordinates().as_chunks::<D>().0, y.coordinates().as_chunks::<D>().0);
    over_assignments(a.len(), b.len(), |i, j| {
        let differences: [f64; D] = std::array::from_fn(|k| a[i][k] - b[j][k]);
        cutoff.cost_of_square(differences.iter().map(|d| d * d).sum())
    })
}

fn square(x: Points, y: Points, i: usize, j: usize) -> f64 {
    x.point(i).iter().zip(y.point(j)).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[inline]
pub(super) fn over_assignments(m: usize, n: usize, cost: impl Fn(usize, usize) -> f64) -> f64 {
    match (m, n) {
        (1, _) => (0..n).map(|j| cost(0, j)).fold(f64::INFINITY, f64::min),
        (2, 2) => (cost(0, 0) + cost(1, 1)).min(cost(0, 1) + cost(1, 0)),
        _ => {
            let mut costs = [[0.0; LARGEST]; LARGEST];
            for (i, row) in costs.iter_mut().enumerate().take(m) {
                *row = std::array::from_fn(|j| cost(i, j));
            }
            least_of_six(&costs)
        }
    }
}

/// A row that does not exist is all zeros.
fn least_of_six(c: &[[f64; LARGEST]; LARGEST]) -> f64 {
    [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
        .map(|[i, j, k]| c[0][i] + c[1][j] + c[2][k])
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}
