//! e' P^-1 e for many errors e and covariances P: the NEES of an estimate, the NIS of an innovation.
//!
//! Each covariance is factored once and solved by substitution, never inverted.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// Relative difference of the two triangles up to which a covariance counts as symmetric.
pub const SYMMETRY: f64 = 1e-8;

/// `errors[k]' covariances[k]^-1 errors[k]` for every k, into `output`.
///
/// # Errors
/// [`Error::NotSymmetric`] or [`Error::NotPositiveDefinite`] with the first covariance at fault.
pub fn quadratic_forms(
    argument: &'static str,
    errors: &[f64],
    covariances: &[f64],
    dimension: usize,
    output: &mut [f64],
) -> Result<()> {
    let d = dimension;
    for (k, form) in output.iter_mut().enumerate() {
        let p = &covariances[k * d * d..(k + 1) * d * d];
        let e = &errors[k * d..(k + 1) * d];
        for i in 0..d {
            for j in 0..i {
                let scale = (p[i * d + i] * p[j * d + j]).abs().sqrt();
                if (p[i * d + j] - p[j * d + i]).abs() > SYMMETRY * scale {
                    return Err(Error::NotSymmetric {
                        argument,
                        index: Some(k),
                        row: i,
                        column: j,
                    });
                }
            }
        }
        let matrix = DMatrix::from_row_slice(d, d, p);
        let Some(factor) = matrix.cholesky() else {
            return Err(Error::NotPositiveDefinite { argument, index: Some(k), minor: d });
        };
        let e = DVector::from_column_slice(e);
        *form = e.dot(&factor.solve(&e));
    }
    Ok(())
}
