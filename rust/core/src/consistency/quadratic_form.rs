//! e' P^-1 e for many residuals e and covariances P: the NEES of an estimate, the NIS of an
//! innovation.
//!
//! ```text
//! e' P^-1 e = sum_j z_j^2 / d_j     with  P = L D L'  and  L z = e
//! ```
//!
//! Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
//! section 5.4, doi:10.1002/0471221279. Each covariance is factored once and solved by substitution,
//! never inverted. Up to nine dimensions as many covariances as a vector has lanes go side by side;
//! above, one after the other through nalgebra. One covariance may serve all residuals.
//!
//! A covariance whose triangles differ by no more than `symmetry`, relative to the standard
//! deviations of the row and the column, is replaced by the mean of the two; beyond that, or where a
//! pivot is not positive, it is an error. No residuals give no forms; residuals of no dimension give
//! zeros.

use super::batched_ldl::{Forms, Matrices};
use super::checked_ldl::{Factors, Judge, doubtful_pivot};
use crate::arrays::Array;
use crate::error::{Error, Result};
use crate::format::tuple;
use crate::simd::transpose::dispatch;
use crate::threads;
use nalgebra::{DMatrix, DVectorView};

/// Asymmetry up to which a covariance of double precision counts as symmetric.
pub const SYMMETRY: f64 = 1e-8;

/// Bytes of covariances that are worth a thread.
const THREAD_BYTES: usize = 2 << 20;

/// What the residuals are made of.
#[derive(Debug, Clone, Copy)]
pub enum Residuals<'a> {
    /// These.
    Given(Array<'a>),
    /// The truth less the estimate.
    Between {
        /// The truth, `(..., d)`.
        truth: Array<'a>,
        /// The estimate, of the same shape.
        estimate: Array<'a>,
    },
}

/// How strict to be, and what angles there are.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// The fewest axes that the residuals may have.
    pub axes: usize,
    /// Asymmetry relative to the standard deviations that is an error.
    pub symmetry: f64,
    /// Gives NaN for what cannot be computed, where it would be an error.
    pub nan_where_invalid: bool,
    /// The period of each component of a residual, 0 for one that is not an angle; empty for none.
    pub periods: &'a [f64],
}

impl Default for Rules<'_> {
    fn default() -> Self {
        Self { axes: 1, symmetry: SYMMETRY, nan_where_invalid: false, periods: &[] }
    }
}

/// `e' P^-1 e` for residuals `(..., d)` and covariances `(..., d, d)`, or one `(d, d)` for all;
/// one form for each of the leading axes, last axis fastest.
///
/// # Errors
/// [`Error::Shape`] where shapes do not fit; otherwise for the first residual or covariance at
/// fault: [`Error::NotFinite`], [`Error::NotSymmetric`] or [`Error::NotPositiveDefinite`].
pub fn quadratic_forms(
    residuals: Residuals,
    covariances: Array,
    rules: &Rules,
) -> Result<Vec<f64>> {
    let (first, second) = match residuals {
        Residuals::Given(array) => (array, None),
        Residuals::Between { truth, estimate } => (truth, Some(estimate)),
    };
    check_shapes(&first, second.as_ref(), &covariances, rules)?;
    let dimension = first.shape().last().copied().unwrap_or(0);
    let judge = Judge { first, second, covariances, dimension, symmetry: rules.symmetry };
    if rules.periods.is_empty() {
        return judge.all(rules.nan_where_invalid);
    }
    let wrapped = wrapped_residuals(&judge, rules)?;
    let first = Array::new(first.argument(), &wrapped, first.shape())?;
    Judge { first, second: None, ..judge }.all(rules.nan_where_invalid)
}

fn check_shapes(
    first: &Array,
    second: Option<&Array>,
    covariances: &Array,
    rules: &Rules,
) -> Result<()> {
    let [leading @ .., d] = first.shape() else {
        return Err(first.misshapen(expected_states(rules.axes)));
    };
    if first.shape().len() < rules.axes {
        return Err(first.misshapen(expected_states(rules.axes)));
    }
    if let Some(second) = second {
        second.require_shape(first)?;
    }
    if covariances.shape() == [*d, *d] || covariances.shape() == [leading, &[*d, *d]].concat() {
        return Ok(());
    }
    let one = tuple(&[*d, *d]);
    if leading.is_empty() {
        return Err(covariances.misshapen(one));
    }
    Err(covariances.misshapen(format!("{} or {one}", tuple(&[leading, &[*d, *d]].concat()))))
}

fn expected_states(axes: usize) -> &'static str {
    if axes < 2 { "(..., d)" } else { "(..., N, d)" }
}

/// The residuals, those of angles brought into (-period / 2, period / 2].
fn wrapped_residuals(judge: &Judge, rules: &Rules) -> Result<Vec<f64>> {
    let count = judge.first.values().len() / judge.dimension.max(1);
    let mut residuals = Vec::with_capacity(judge.first.values().len());
    for k in 0..count {
        match judge.residual(k) {
            Ok(residual) => residuals.extend(residual),
            Err(_) if rules.nan_where_invalid => {
                residuals.extend(std::iter::repeat_n(f64::NAN, judge.dimension));
            }
            Err(error) => return Err(error),
        }
    }
    for residual in residuals.chunks_exact_mut(judge.dimension.max(1)) {
        for (e, &period) in residual.iter_mut().zip(rules.periods) {
            if period > 0.0 {
                *e -= period * (*e / period - 0.5).ceil();
            }
        }
    }
    Ok(residuals)
}

impl Judge<'_> {
    /// Every form.
    fn all(&self, nan_where_invalid: bool) -> Result<Vec<f64>> {
        let shape = self.first.shape();
        let mut output = vec![0.0; shape[..shape.len() - 1].iter().product()];
        let shared = match self.covariances.shape().len() {
            2 => match self.factors(0) {
                Ok(factors) => Some(factors),
                Err(_) if nan_where_invalid => {
                    output.fill(f64::NAN);
                    return Ok(output);
                }
                Err(error) => return Err(error),
            },
            _ => None,
        };
        let bytes = 8 * self.dimension * (self.dimension + 2);
        threads::fill(&mut output, (THREAD_BYTES / bytes.max(1)).max(1), |from, piece| {
            if self.fast(from, piece, shared.as_ref()) {
                return Ok(());
            }
            self.settle(from, piece, shared.as_ref(), nan_where_invalid)
        })?;
        Ok(output)
    }

    /// The forms from `from` on, NaN where there is doubt; whether there is none.
    fn fast(&self, from: usize, output: &mut [f64], shared: Option<&Factors>) -> bool {
        match self.dimension {
            0 => true,
            1 => self.lanes::<1, 1>(from, output, shared),
            2 => self.lanes::<2, 4>(from, output, shared),
            3 => self.lanes::<3, 9>(from, output, shared),
            4 => self.lanes::<4, 16>(from, output, shared),
            5 => self.lanes::<5, 25>(from, output, shared),
            6 => self.lanes::<6, 36>(from, output, shared),
            7 => self.lanes::<7, 49>(from, output, shared),
            8 => self.lanes::<8, 64>(from, output, shared),
            9 => self.lanes::<9, 81>(from, output, shared),
            _ => self.one_by_one(from, output, shared),
        }
    }

    fn lanes<const D: usize, const E: usize>(
        &self,
        from: usize,
        output: &mut [f64],
        shared: Option<&Factors>,
    ) -> bool {
        let inverses: Vec<f64> =
            shared.map_or(vec![], |factors| factors.pivots.iter().map(|p| 1.0 / p).collect());
        dispatch(Forms::<D, E> {
            first: &self.first.values()[from * D..],
            second: self.second.map(|array| &array.values()[from * D..]),
            matrices: match shared {
                None => Matrices::Own(&self.covariances.values()[from * E..]),
                Some(factors) => Matrices::Shared { lower: &factors.lower, inverses: &inverses },
            },
            symmetry: self.symmetry,
            output,
        })
    }

    /// Cholesky of one covariance after the other.
    fn one_by_one(&self, from: usize, output: &mut [f64], shared: Option<&Factors>) -> bool {
        let d = self.dimension;
        for (k, form) in output.iter_mut().enumerate() {
            *form = match (shared, self.residual(from + k)) {
                (_, Err(_)) => f64::NAN,
                (Some(factors), Ok(residual)) => factors.form(&residual),
                (None, Ok(residual)) => {
                    let start = (from + k) * d * d;
                    let matrix = &self.covariances.values()[start..start + d * d];
                    cholesky_form(matrix, &residual, self.symmetry)
                }
            };
        }
        output.iter().all(|form| form.is_finite())
    }

    /// Decides what was left in doubt, in order, up to the first error.
    fn settle(
        &self,
        from: usize,
        output: &mut [f64],
        shared: Option<&Factors>,
        nan_where_invalid: bool,
    ) -> Result<()> {
        for (k, form) in output.iter_mut().enumerate().filter(|(_, form)| form.is_nan()) {
            let settled = match shared {
                Some(factors) => self.residual(from + k).map(|e| factors.form(&e)),
                None => self.form(from + k),
            };
            match settled {
                Ok(value) => *form = value,
                Err(_) if nan_where_invalid => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// The form through nalgebra, NaN where the covariance is not clearly symmetric and positive
/// definite.
fn cholesky_form(matrix: &[f64], residual: &[f64], symmetry: f64) -> f64 {
    let d = residual.len();
    let mut p = DMatrix::from_row_slice(d, d, matrix);
    let deviations = p.diagonal().map(|x| x.abs().sqrt());
    for column in 0..d {
        for row in column + 1..d {
            let (below, above) = (p[(row, column)], p[(column, row)]);
            let bound = symmetry * deviations[row] * deviations[column];
            let difference = above - below;
            if difference.is_nan() || difference.abs() > bound {
                return f64::NAN;
            }
            p[(row, column)] = below + 0.5 * difference;
        }
    }
    let bounds = p.diagonal() * doubtful_pivot(d);
    let Some(factor) = p.cholesky() else {
        return f64::NAN;
    };
    let lower = factor.l_dirty();
    // NaN would have stopped the factorisation.
    if (0..d).any(|i| lower[(i, i)] * lower[(i, i)] <= bounds[i]) {
        return f64::NAN;
    }
    let mut z = DVectorView::from_slice(residual, d).into_owned();
    if !lower.solve_lower_triangular_mut(&mut z) {
        return f64::NAN;
    }
    z.norm_squared()
}

/// The share of forms that are at most `threshold`: the errors inside a credibility region.
///
/// # Errors
/// As [`quadratic_forms`], and [`Error::Empty`] where there are no errors.
pub fn share_within(
    errors: Array,
    covariances: Array,
    threshold: f64,
    rules: &Rules,
) -> Result<f64> {
    errors.require_elements()?;
    let forms = quadratic_forms(Residuals::Given(errors), covariances, rules)?;
    let within = forms.iter().filter(|&&form| form <= threshold).count();
    Ok(within as f64 / forms.len() as f64)
}

/// The mean of NEES or NIS values.
///
/// # Errors
/// [`Error::Empty`], or [`Error::Element`] for the first value that is negative, NaN or infinite.
pub fn mean_statistic(values: Array) -> Result<f64> {
    values.require_elements()?;
    let (argument, shape) = (values.argument(), values.shape());
    if let Some(at) = values.values().iter().position(|x| !(x.is_finite() && *x >= 0.0)) {
        return Err(Error::Element {
            argument,
            index: crate::arrays::unravel(at, shape),
            requirement: "finite and at least 0",
            value: values.values()[at],
        });
    }
    Ok(crate::simd::sums::sum(values.values()) / values.values().len() as f64)
}
