//! One covariance at a time, with every check: what the lanes hand over when in doubt.
//!
//! The order of operations is fixed and without fused multiply-add, so that every machine, and the
//! NumPy reference, draws the line between positive definite and not at the same place.

use crate::arrays::{Array, unravel};
use crate::error::{Error, Result};

/// What is computed from, and what counts as a covariance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    /// What the residuals are made of: themselves, or truth and estimate.
    pub(super) first: Array<'a>,
    pub(super) second: Option<Array<'a>>,
    pub(super) covariances: Array<'a>,
    /// How long a residual is.
    pub(super) dimension: usize,
    /// Asymmetry relative to the standard deviations up to which the two triangles are averaged.
    pub(super) symmetry: f64,
}

/// The factors of P = L D L': unit lower L below the diagonal of `factor`, and the pivots.
pub(super) struct Factors {
    pub(super) lower: Vec<f64>,
    pub(super) pivots: Vec<f64>,
}

impl Judge<'_> {
    /// The form of residual `k`.
    pub(super) fn form(&self, k: usize) -> Result<f64> {
        let residual = self.residual(k)?;
        let factors = self.factors(k)?;
        Ok(factors.form(&residual))
    }

    /// Residual `k`, finite.
    pub(super) fn residual(&self, k: usize) -> Result<Vec<f64>> {
        let from = k * self.dimension;
        let first = self.finite(&self.first, from)?;
        let Some(second) = &self.second else {
            return Ok(first.to_vec());
        };
        let second = self.finite(second, from)?;
        Ok(first.iter().zip(second).map(|(a, b)| a - b).collect())
    }

    fn finite<'b>(&self, array: &Array<'b>, from: usize) -> Result<&'b [f64]> {
        let values = &array.values()[from..from + self.dimension];
        match values.iter().position(|x| !x.is_finite()) {
            None => Ok(values),
            Some(i) => Err(not_finite(array, from + i)),
        }
    }

    /// The factors of covariance `k`, or of the only one.
    pub(super) fn factors(&self, k: usize) -> Result<Factors> {
        let d = self.dimension;
        let from = if self.covariances.shape().len() == 2 { 0 } else { k * d * d };
        let matrix = &self.covariances.values()[from..from + d * d];
        if let Some(at) = matrix.iter().position(|x| !x.is_finite()) {
            return Err(not_finite(&self.covariances, from + at));
        }
        let lower = self.symmetrized(matrix, from)?;
        factor(lower, d).map_err(|minor| Error::NotPositiveDefinite {
            argument: self.covariances.argument(),
            index: self.place(from),
            minor,
        })
    }

    /// The mean of the two triangles.
    fn symmetrized(&self, matrix: &[f64], from: usize) -> Result<Vec<f64>> {
        let d = self.dimension;
        let mut lower = matrix.to_vec();
        for row in 0..d {
            for column in 0..row {
                let (below, above) = (matrix[row * d + column], matrix[column * d + row]);
                let [a, b] = [row, column].map(|i| matrix[i * d + i].abs().sqrt());
                if (above - below).abs() > self.symmetry * a * b {
                    let (argument, index) = (self.covariances.argument(), self.place(from));
                    return Err(Error::NotSymmetric { argument, index, row, column });
                }
                lower[row * d + column] = below + 0.5 * (above - below);
            }
        }
        Ok(lower)
    }

    /// Which covariance starts at this element.
    fn place(&self, from: usize) -> Vec<usize> {
        let axes = self.covariances.shape();
        let leading = &axes[..axes.len() - 2];
        unravel(from / (self.dimension * self.dimension).max(1), leading)
    }
}

fn not_finite(array: &Array, at: usize) -> Error {
    let (argument, value) = (array.argument(), array.values()[at]);
    Error::NotFinite { argument, index: unravel(at, array.shape()), value }
}

/// The least pivot, relative to the diagonal element it came from, that counts as positive.
///
/// A singular covariance has a pivot of this size and either sign, from rounding alone.
fn least_pivot(dimension: usize) -> f64 {
    dimension as f64 * f64::EPSILON
}

/// The pivot below which a fast factorisation leaves the decision to a [`Judge`].
///
/// Far above [`least_pivot`]: small pivots before it may have magnified its rounding error.
pub(super) fn doubtful_pivot(dimension: usize) -> f64 {
    16384.0 * least_pivot(dimension)
}

/// L D L' of the lower triangle, column after column (right-looking), or the leading minor that is
/// not positive.
fn factor(mut lower: Vec<f64>, d: usize) -> std::result::Result<Factors, usize> {
    let least = least_pivot(d);
    let diagonal: Vec<f64> = (0..d).map(|i| lower[i * d + i]).collect();
    let mut pivots = vec![0.0; d];
    for j in 0..d {
        let pivot = lower[j * d + j];
        if pivot.is_nan() || pivot <= least * diagonal[j] {
            return Err(j + 1);
        }
        pivots[j] = pivot;
        for i in j + 1..d {
            let factor = lower[i * d + j] / pivot;
            for k in j + 1..=i {
                lower[i * d + k] -= factor * lower[k * d + j];
            }
        }
        for i in j + 1..d {
            lower[i * d + j] /= pivot;
        }
    }
    Ok(Factors { lower, pivots })
}

impl Factors {
    /// e' P^-1 e by forward substitution.
    pub(super) fn form(&self, residual: &[f64]) -> f64 {
        let d = residual.len();
        let mut z = residual.to_vec();
        let mut form = 0.0;
        for j in 0..d {
            form += z[j] * z[j] / self.pivots[j];
            for i in j + 1..d {
                z[i] -= self.lower[i * d + j] * z[j];
            }
        }
        form
    }
}
