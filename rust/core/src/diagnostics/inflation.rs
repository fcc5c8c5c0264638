//! How far correlation in time widens the NEES of one run.
//!
//! The error of an honest filter obeys e_k = A_k e_(k-1) + d_k with A_k = (I - K_k H_k) F_k, so that
//! with P_k = L_k L_k' the whitened errors of two times have the covariance
//! C_kl = L_k^-1 A_k ... A_(l+1) L_l, and cov(NEES_k, NEES_l) = 2 |C_kl|^2 (Frobenius). A value
//! counts for 1 / tau_k of an independent one, tau_k = (1 / d) sum over l of |C_kl|^2; without A the
//! sum is 1.
//!
//! Cost: d^3 for each pair of times that still remember each other.

use super::segmentation::check_starts;
use crate::error::{Error, Result};
use nalgebra::DMatrix;

/// Two times remember each other while |C_kl|^2 is above this.
const FORGOTTEN: f64 = 1e-4;

/// But no further apart than this.
const LONGEST: usize = 200;

/// tau of every update of many tracks, one behind the other: `transitions[k]` is A_k (that of a
/// track's first update is not used), `covariances[k]` is P_k, both `dimension` x `dimension`.
///
/// # Errors
/// If something is not finite, sizes do not fit, `starts` do not rise to the number of updates, or
/// a covariance is not positive definite.
pub fn nees_inflation(
    transitions: &[f64],
    covariances: &[f64],
    dimension: usize,
    starts: &[i64],
) -> Result<Vec<f64>> {
    let size = dimension * dimension;
    let count = covariances.len().checked_div(size).unwrap_or(0);
    check(transitions, covariances, size)?;
    check_starts("covariances", starts, count)?;
    let mut output = vec![1.0; count];
    for pair in starts.windows(2) {
        let (from, to) = (pair[0] as usize, pair[1] as usize);
        let steps = whitened_steps(transitions, covariances, dimension, from..to)?;
        accumulate(&steps, dimension, &mut output[from..to]);
    }
    Ok(output)
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

/// L_k^-1 A_k L_(k-1) of every update after the first.
fn whitened_steps(
    transitions: &[f64],
    covariances: &[f64],
    d: usize,
    range: std::ops::Range<usize>,
) -> Result<Vec<DMatrix<f64>>> {
    let matrix = |values: &[f64], k: usize| {
        DMatrix::from_row_slice(d, d, &values[k * d * d..(k + 1) * d * d])
    };
    let mut steps = Vec::with_capacity(range.len());
    let mut before: Option<DMatrix<f64>> = None;
    for k in range {
        let factor = cholesky(matrix(covariances, k)).map_err(|minor| {
            Error::NotPositiveDefinite { argument: "covariances", index: vec![k], minor }
        })?;
        if let Some(before) = before {
            let mut step = matrix(transitions, k) * before;
            factor.solve_lower_triangular_mut(&mut step);
            steps.push(step);
        }
        before = Some(factor);
    }
    Ok(steps)
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

fn accumulate(steps: &[DMatrix<f64>], d: usize, output: &mut [f64]) {
    for k in 1..output.len() {
        let mut product = DMatrix::identity(d, d);
        for l in (k.saturating_sub(LONGEST)..k).rev() {
            product *= &steps[l];
            let shared = product.norm_squared();
            if shared < FORGOTTEN {
                break;
            }
            output[k] += shared / d as f64;
            output[l] += shared / d as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scalar_error_that_halves_counts_for_three_fifths() {
        let n = 60;
        let tau = nees_inflation(&vec![0.5; n], &vec![2.0; n], 1, &[0, n as i64]).unwrap();
        assert!((tau[n / 2] - (1.0 + 2.0 * (1.0 / 3.0))).abs() < 2e-3);
        assert!((tau[0] - (1.0 + 1.0 / 3.0)).abs() < 2e-3);
    }

    #[test]
    fn without_memory_it_is_one() {
        assert_eq!(nees_inflation(&[0.0; 3], &[2.0; 3], 1, &[0, 1, 3]).unwrap(), [1.0; 3]);
        assert!(nees_inflation(&[0.0], &[-1.0], 1, &[0, 1]).is_err());
        assert!(nees_inflation(&[0.0], &[1.0], 1, &[0, 2]).is_err());
    }
}
