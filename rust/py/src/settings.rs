//! Binding of `trackmetrics_core::{threads, simd}`: what a user may set.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use trackmetrics_core::simd::Width;

/// How many threads a kernel may use.
#[pyfunction]
pub(crate) fn threads() -> usize {
    trackmetrics_core::threads::threads()
}

/// Lets kernels use at most this many threads; 0 for as many as the machine has.
#[pyfunction]
pub(crate) fn set_threads(threads: usize) {
    trackmetrics_core::threads::set_threads(threads);
}

/// The vector width that kernels run on.
#[pyfunction]
pub(crate) fn simd() -> &'static str {
    trackmetrics_core::simd::width()
}

/// Limits the vector width: "scalar", "avx2" or "widest".
#[pyfunction]
pub(crate) fn set_simd(width: &str) -> PyResult<()> {
    let width = match width {
        "scalar" => Width::Scalar,
        "avx2" => Width::V3,
        "widest" => Width::Widest,
        _ => {
            return Err(PyValueError::new_err("width must be 'scalar', 'avx2' or 'widest'"));
        }
    };
    trackmetrics_core::simd::set_width(width);
    Ok(())
}
