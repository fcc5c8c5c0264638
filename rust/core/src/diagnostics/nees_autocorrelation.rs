//! How far correlation in time widens the NEES of one run.
//!
//! The error of a consistent filter obeys e_k = A_k e_(k-1) + d_k with A_k = (I - K_k H_k) F_k, so that
//! with P_k = L_k L_k' the whitened errors of two times have the covariance
//! C_kl = L_k^-1 A_k ... A_(l+1) L_l, and cov(NEES_k, NEES_l) = 2 |C_kl|^2 (Frobenius). A value
//! counts for 1 / tau_k of an independent one, tau_k = (1 / d) sum over l of |C_kl|^2; without A the
//! sum is 1.
//!
//! Where only some components of e_k are known, with the covariance P_I = L_I L_I' = M_k M_k' (L_I
//! the rows of L_k that belong to them), C_kl is seen through U_k = M_k^-1 L_I on the left and U_l'
//! on the right, and d is the number of components that are known.
//!
//! Cost: d^3 for each pair of times that still remember each other.

use super::segmentation::check_starts;
use crate::error::{Error, Result};
use nalgebra::DMatrix;
use std::ops::Range;

/// Two times remember each other while |C_kl|^2 is above this.
const FORGOTTEN: f64 = 1e-4;

/// But no further apart than this.
const LONGEST: usize = 200;

/// tau of every update of many tracks, one behind the other: `transitions[k]` is A_k (that of a
/// track's first update is not used), `covariances[k]` is P_k, both `dimension` x `dimension`;
/// `known` says by 0 or 1 which components of the errors there are, `dimension` for each update.
///
/// # Errors
/// If something is not finite, sizes do not fit, `starts` do not rise to the number of updates, or
/// a covariance is not positive definite.
pub fn nees_inflation(
    transitions: &[f64],
    covariances: &[f64],
    dimension: usize,
    starts: &[i64],
    known: Option<&[i64]>,
) -> Result<Vec<f64>> {
    let size = dimension * dimension;
    let count = covariances.len().checked_div(size).unwrap_or(0);
    check(transitions, covariances, size)?;
    check_starts("covariances", starts, count)?;
    check_known(known, dimension, count)?;
    let mut output = vec![1.0; count];
    for pair in starts.windows(2) {
        let range = pair[0] as usize..pair[1] as usize;
        let factors = factors(covariances, dimension, range.clone())?;
        let steps = whitened_steps(transitions, &factors, range.start);
        let views = known.map(|known| views(&factors, &known[range.start * dimension..]));
        accumulate(&steps, views.as_deref(), dimension, &mut output[range]);
    }
    Ok(output)
}

fn check_known(known: Option<&[i64]>, dimension: usize, count: usize) -> Result<()> {
    match known {
        Some(known) if known.len() != count * dimension => Err(Error::Length {
            argument: "known",
            found: known.len(),
            other: "covariances",
            expected: count * dimension,
            unit: "components",
        }),
        _ => Ok(()),
    }
}

fn check(transitions: &[f64], covariances: &[f64], size: usize) -> Result<()> {
    if transitions.len() != covariances.len() {
        return Err(Error::Length {
            argument: "transitions",
            found: transitions.len() / size.max(1),
            other: "covariances",
            expected: covariances.len() / size.max(1),
            unit: "matrices",
        });
    }
    for (argument, values) in [("transitions", transitions), ("covariances", covariances)] {
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { argument, index: vec![i / size], value: values[i] });
        }
    }
    Ok(())
}

/// L_k of every update of a track.
fn factors(covariances: &[f64], d: usize, range: Range<usize>) -> Result<Vec<DMatrix<f64>>> {
    let size = d * d;
    range
        .map(|k| {
            let covariance = &covariances[k * size..(k + 1) * size];
            cholesky(DMatrix::from_row_slice(d, d, covariance)).map_err(|minor| {
                Error::NotPositiveDefinite { argument: "covariances", index: vec![k], minor }
            })
        })
        .collect()
}

/// L_k^-1 A_k L_(k-1) of every update after the first of a track, which is update `start`.
fn whitened_steps(
    transitions: &[f64],
    factors: &[DMatrix<f64>],
    start: usize,
) -> Vec<DMatrix<f64>> {
    let step = |(i, pair): (usize, &[DMatrix<f64>])| {
        let (d, k) = (pair[0].nrows(), start + i + 1);
        let transition = &transitions[k * d * d..(k + 1) * d * d];
        let mut step = DMatrix::from_row_slice(d, d, transition) * &pair[0];
        pair[1].solve_lower_triangular_mut(&mut step);
        step
    };
    factors.windows(2).enumerate().map(step).collect()
}

/// U_k = M_k^-1 L_I of every update of a track.
fn views(factors: &[DMatrix<f64>], known: &[i64]) -> Vec<DMatrix<f64>> {
    let view = |(factor, known): (&DMatrix<f64>, &[i64])| {
        let rows: Vec<usize> = (0..known.len()).filter(|&i| known[i] != 0).collect();
        let mut view = factor.select_rows(&rows);
        // Rows of a Cholesky factor are independent: their products have a factor as well.
        if let Ok(root) = cholesky(&view * view.transpose()) {
            root.solve_lower_triangular_mut(&mut view);
        }
        view
    };
    let dimension = factors.first().map_or(1, DMatrix::nrows).max(1);
    factors.iter().zip(known.chunks_exact(dimension)).map(view).collect()
}

/// The lower Cholesky factor, or the size of the first leading minor that is not positive.
fn cholesky(mut matrix: DMatrix<f64>) -> std::result::Result<DMatrix<f64>, usize> {
    for j in 0..matrix.nrows() {
        let pivot = matrix[(j, j)] - matrix.row(j).columns(0, j).norm_squared();
        if pivot <= 0.0 {
            return Err(j + 1);
        }
        matrix[(j, j)] = pivot.sqrt();
        for i in j + 1..matrix.nrows() {
            let shared = matrix.row(i).columns(0, j).dot(&matrix.row(j).columns(0, j));
            matrix[(i, j)] = (matrix[(i, j)] - shared) / matrix[(j, j)];
            matrix[(j, i)] = 0.0;
        }
    }
    Ok(matrix)
}

fn accumulate(
    steps: &[DMatrix<f64>],
    views: Option<&[DMatrix<f64>]>,
    d: usize,
    output: &mut [f64],
) {
    for k in 1..output.len() {
        let mut product = DMatrix::identity(d, d);
        for l in (k.saturating_sub(LONGEST)..k).rev() {
            product *= &steps[l];
            let whole = product.norm_squared();
            if whole < FORGOTTEN {
                break;
            }
            let (shared, d_k, d_l) = match views {
                None => (whole, d, d),
                Some(views) => (
                    (&views[k] * &product * views[l].transpose()).norm_squared(),
                    views[k].nrows().max(1),
                    views[l].nrows().max(1),
                ),
            };
            output[k] += shared / d_k as f64;
            output[l] += shared / d_l as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scalar_error_that_halves_counts_for_three_fifths() {
        let n = 60;
        let tau = nees_inflation(&vec![0.5; n], &vec![2.0; n], 1, &[0, n as i64], None).unwrap();
        assert!((tau[n / 2] - (1.0 + 2.0 * (1.0 / 3.0))).abs() < 2e-3);
        assert!((tau[0] - (1.0 + 1.0 / 3.0)).abs() < 2e-3);
    }

    #[test]
    fn without_memory_it_is_one() {
        assert_eq!(nees_inflation(&[0.0; 3], &[2.0; 3], 1, &[0, 1, 3], None).unwrap(), [1.0; 3]);
        assert!(nees_inflation(&[0.0], &[-1.0], 1, &[0, 1], None).is_err());
        assert!(nees_inflation(&[0.0], &[1.0], 1, &[0, 2], None).is_err());
        assert!(nees_inflation(&[0.0], &[1.0], 1, &[0, 1], Some(&[])).is_err());
    }

    #[test]
    fn of_two_strangers_the_known_one_counts_alone() {
        let n = 60;
        let (steps, unit) = ([0.5, 0.0, 0.0, 0.0].repeat(n), [1.0, 0.0, 0.0, 1.0].repeat(n));
        let tau = |known: &[i64]| {
            nees_inflation(&steps, &unit, 2, &[0, n as i64], Some(&known.repeat(n))).unwrap()[n / 2]
        };
        assert!((tau(&[1, 0]) - 5.0 / 3.0).abs() < 2e-3);
        assert_eq!(tau(&[0, 1]), 1.0);
        assert!((tau(&[1, 1]) - 4.0 / 3.0).abs() < 2e-3);
        assert_eq!(tau(&[0, 0]), 1.0);
    }
}
