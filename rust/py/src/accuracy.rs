//! Binding of `trackmetrics_core::accuracy`.

use crate::convert::number;
use crate::error::raise;
use crate::tensor::{Shaped, Tensor, detached};
use pyo3::prelude::*;
use trackmetrics_core::accuracy::rmse as kernel;

/// Root mean square of the errors over `axes` (all of them where it is None).
#[pyfunction]
pub(crate) fn rmse<'py>(
    py: Python<'py>,
    true_states: Tensor<'_>,
    estimated_states: Tensor<'_>,
    axes: Option<Vec<i64>>,
) -> PyResult<Shaped<'py>> {
    let truth = true_states.named("true_states")?;
    let estimate = estimated_states.named("estimated_states")?;
    let work = truth.values().len();
    let (values, shape) =
        detached(py, work, || kernel::rmse(truth, Some(estimate), axes.as_deref()))
            .map_err(raise)?;
    Shaped::new(py, values, &shape)
}

/// Root mean square of given errors over `axes` (all of them where it is None).
#[pyfunction]
pub(crate) fn monte_carlo_rmse<'py>(
    py: Python<'py>,
    errors: Tensor<'_>,
    axes: Option<Vec<i64>>,
) -> PyResult<Shaped<'py>> {
    let errors = errors.named("errors")?;
    let work = errors.values().len();
    let (values, shape) =
        detached(py, work, || kernel::rmse(errors, None, axes.as_deref())).map_err(raise)?;
    Shaped::new(py, values, &shape)
}

/// Root mean square error of the position components.
#[pyfunction]
pub(crate) fn position_rmse(
    true_states: Tensor<'_>,
    estimated_states: Tensor<'_>,
    position_indices: Vec<i64>,
) -> PyResult<f64> {
    let truth = true_states.named("true_states")?;
    let estimate = estimated_states.named("estimated_states")?;
    kernel::rmse_of(truth, estimate, "position_indices", &position_indices).map_err(raise)
}

/// Root mean square error of the velocity components.
#[pyfunction]
pub(crate) fn velocity_rmse(
    true_states: Tensor<'_>,
    estimated_states: Tensor<'_>,
    velocity_indices: Vec<i64>,
) -> PyResult<f64> {
    let truth = true_states.named("true_states")?;
    let estimate = estimated_states.named("estimated_states")?;
    kernel::rmse_of(truth, estimate, "velocity_indices", &velocity_indices).map_err(raise)
}

/// `sigma` standard deviations of every state.
#[pyfunction]
pub(crate) fn estimation_error_bounds<'py>(
    py: Python<'py>,
    covariances: Tensor<'_>,
    #[pyo3(from_py_with = number)] sigma: f64,
) -> PyResult<Shaped<'py>> {
    let covariances = covariances.named("covariances")?;
    let values = kernel::error_bounds(covariances, sigma).map_err(raise)?;
    let leading = covariances.shape().split_last().map_or(&[][..], |(_, leading)| leading);
    Shaped::array(py, values, leading)
}
