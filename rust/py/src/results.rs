//! The named tuples of `trackmetrics.results`.

use crate::lists::named_tuple;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use trackmetrics_core::point_sets::results::Ospa;

/// An `OSPAResult`.
pub(crate) fn ospa_result(py: Python<'_>, ospa: Ospa) -> PyResult<Bound<'_, PyAny>> {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = CLASS.import(py, "trackmetrics.results", "OSPAResult")?;
    named_tuple(class, [ospa.distance, ospa.localization, ospa.cardinality])
}
