//! Core errors as Python exceptions, in one place.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use trackmetrics_core::Error;

/// The exception for a core error: `LinAlgError` for a covariance that is not positive definite,
/// `ValueError` for everything else.
pub(crate) fn raise(error: Error) -> PyErr {
    let text = error.to_string();
    match error {
        Error::NotPositiveDefinite { .. } => {
            Python::attach(|py| exception(py, "numpy.linalg", "LinAlgError", &LIN_ALG_ERROR, text))
        }
        _ => PyValueError::new_err(text),
    }
}

/// Says that an argument is not in the form that a kernel reads by itself: the public function converts
/// it and calls again.
pub(crate) fn not_plain(py: Python<'_>) -> PyErr {
    exception(py, "trackmetrics.errors", "NotPlain", &NOT_PLAIN, String::new())
}

static LIN_ALG_ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static NOT_PLAIN: PyOnceLock<Py<PyType>> = PyOnceLock::new();

fn exception(
    py: Python<'_>,
    module: &str,
    name: &str,
    cell: &'static PyOnceLock<Py<PyType>>,
    text: String,
) -> PyErr {
    match cell.import(py, module, name) {
        Ok(kind) => PyErr::from_type(kind.clone(), text),
        Err(error) => error,
    }
}
