//! Binding of `trackmetrics_core::consistency`.

use crate::convert::Floats;
use crate::error::{not_plain, raise};
use crate::tensor::{Shaped, Tensor, detached};
use pyo3::prelude::*;
use trackmetrics_core::Array;
use trackmetrics_core::consistency::quadratic_form::{self as kernel, Residuals, Rules};

/// Normalised estimation error squared of states `(..., d)`.
#[pyfunction]
pub(crate) fn nees<'py>(
    py: Python<'py>,
    true_state: Tensor<'_>,
    estimated_state: Tensor<'_>,
    covariance: Tensor<'_>,
    symmetry: f64,
    periods: Option<Floats<'_, 1>>,
    nan_where_invalid: bool,
) -> PyResult<Shaped<'py>> {
    let truth = true_state.named("true_state")?;
    let estimate = estimated_state.named("estimated_state")?;
    let covariances = covariance.named("covariance")?;
    let periods = periods.as_ref().map_or(&[][..], |periods| periods.values);
    let rules = Rules { axes: 1, symmetry, nan_where_invalid, periods };
    forms(py, Residuals::Between { truth, estimate }, covariances, &rules)
}

/// Normalised estimation error squared of sequences of states `(..., N, d)`.
#[pyfunction]
pub(crate) fn nees_sequence<'py>(
    py: Python<'py>,
    true_states: Tensor<'_>,
    estimated_states: Tensor<'_>,
    covariances: Tensor<'_>,
    symmetry: f64,
    periods: Option<Floats<'_, 1>>,
    nan_where_invalid: bool,
) -> PyResult<Shaped<'py>> {
    let truth = true_states.named("true_states")?;
    let estimate = estimated_states.named("estimated_states")?;
    let covariances = covariances.named("covariances")?;
    let periods = periods.as_ref().map_or(&[][..], |periods| periods.values);
    let rules = Rules { axes: 2, symmetry, nan_where_invalid, periods };
    forms(py, Residuals::Between { truth, estimate }, covariances, &rules)
}

/// Normalised innovation squared of innovations `(..., m)`.
#[pyfunction]
pub(crate) fn nis<'py>(
    py: Python<'py>,
    innovation: Tensor<'_>,
    innovation_covariance: Tensor<'_>,
    symmetry: f64,
    periods: Option<Floats<'_, 1>>,
    nan_where_invalid: bool,
) -> PyResult<Shaped<'py>> {
    let residuals = Residuals::Given(innovation.named("innovation")?);
    let covariances = innovation_covariance.named("innovation_covariance")?;
    let periods = periods.as_ref().map_or(&[][..], |periods| periods.values);
    let rules = Rules { axes: 1, symmetry, nan_where_invalid, periods };
    forms(py, residuals, covariances, &rules)
}

/// Normalised innovation squared of sequences of innovations `(..., N, m)`.
#[pyfunction]
pub(crate) fn nis_sequence<'py>(
    py: Python<'py>,
    innovations: Tensor<'_>,
    innovation_covariances: Tensor<'_>,
    symmetry: f64,
    periods: Option<Floats<'_, 1>>,
    nan_where_invalid: bool,
) -> PyResult<Shaped<'py>> {
    let residuals = Residuals::Given(innovations.named("innovations")?);
    let covariances = innovation_covariances.named("innovation_covariances")?;
    let periods = periods.as_ref().map_or(&[][..], |periods| periods.values);
    let rules = Rules { axes: 2, symmetry, nan_where_invalid, periods };
    forms(py, residuals, covariances, &rules)
}

/// The share of errors inside their credibility region: forms of at most `threshold`.
#[pyfunction]
pub(crate) fn credibility_interval(
    py: Python<'_>,
    errors: Tensor<'_>,
    covariances: Tensor<'_>,
    threshold: f64,
    symmetry: f64,
) -> PyResult<f64> {
    let errors = errors.named("errors")?;
    let covariances = covariances.named("covariances")?;
    refuse_columns(py, &errors, &covariances)?;
    let rules = Rules { axes: 2, symmetry, ..Rules::default() };
    let work = covariances.values().len();
    detached(py, work, || kernel::share_within(errors, covariances, threshold, &rules))
        .map_err(raise)
}

/// The mean of NEES or NIS values, each finite and at least 0, and how many there are.
#[pyfunction]
pub(crate) fn mean_statistic(nees_or_nis_values: Tensor<'_>) -> PyResult<(f64, usize)> {
    let values = nees_or_nis_values.named("nees_or_nis_values")?;
    let mean = kernel::mean_statistic(values).map_err(raise)?;
    Ok((mean, values.values().len()))
}

fn forms<'py>(
    py: Python<'py>,
    residuals: Residuals<'_>,
    covariances: Array<'_>,
    rules: &Rules<'_>,
) -> PyResult<Shaped<'py>> {
    let (Residuals::Given(states) | Residuals::Between { truth: states, .. }) = residuals;
    refuse_columns(py, &states, &covariances)?;
    let work = covariances.values().len() + states.values().len();
    let values = detached(py, work, || kernel::quadratic_forms(residuals, covariances, rules))
        .map_err(raise)?;
    let leading = states.shape().split_last().map_or(&[][..], |(_, leading)| leading);
    Shaped::new(py, values, leading)
}

/// Leaves scalars and column vectors to the public function, which knows how to flatten them.
fn refuse_columns(py: Python<'_>, states: &Array<'_>, covariances: &Array<'_>) -> PyResult<()> {
    match (states.shape(), covariances.shape()) {
        ([], _) | (_, [] | [_]) => Err(not_plain(py)),
        ([_, .., 1], [.., d]) if *d != 1 => Err(not_plain(py)),
        _ => Ok(()),
    }
}
