//! The named tuples of `trackmetrics.results`, made here: a tenth of a microsecond sooner than in
//! Python.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyTuple, PyType};
use trackmetrics_core::point_sets::ospa::Ospa;

/// An `OSPAResult`.
pub(crate) fn ospa_result(py: Python<'_>, ospa: Ospa) -> PyResult<Bound<'_, PyAny>> {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = CLASS.import(py, "trackmetrics.results", "OSPAResult")?;
    tuple_new(py)?.call1((class, (ospa.distance, ospa.localization, ospa.cardinality)))
}

/// `tuple.__new__`, which does not go through the named tuple's own.
fn tuple_new(py: Python<'_>) -> PyResult<&Bound<'_, PyAny>> {
    static NEW: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let new = || py.get_type::<PyTuple>().getattr("__new__").map(Bound::unbind);
    Ok(NEW.get_or_try_init(py, new)?.bind(py))
}
