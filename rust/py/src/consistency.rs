//! Binding of `trackmetrics_core::consistency`.

use crate::convert::Floats;
use crate::error::raise;
use numpy::PyArray1;
use pyo3::prelude::*;
use trackmetrics_core::consistency::quadratic_form::quadratic_forms;

/// NEES of many errors with their covariances.
#[pyfunction]
pub(crate) fn nees<'py>(
    py: Python<'py>,
    errors: Floats<'_, 2>,
    covariances: Floats<'_, 3>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let [n, d] = errors.shape;
    let mut output = vec![0.0; n];
    py.detach(|| quadratic_forms("covariances", errors.values, covariances.values, d, &mut output))
        .map_err(raise)?;
    Ok(PyArray1::from_vec(py, output))
}
