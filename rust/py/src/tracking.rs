//! Binding of `trackmetrics_core::tracking`.

use crate::convert::Integers;
use crate::error::raise;
use pyo3::prelude::*;
use trackmetrics_core::tracking::labels as kernel;

/// The share of observations with the most frequent true label of their estimated label.
#[pyfunction]
pub(crate) fn track_purity(
    py: Python<'_>,
    true_labels: Integers<'_>,
    estimated_labels: Integers<'_>,
) -> PyResult<f64> {
    let (t, e) = (true_labels.values, estimated_labels.values);
    py.detach(|| kernel::track_purity(t, e)).map_err(raise)
}

/// How often the estimated label of a true label changes.
#[pyfunction]
pub(crate) fn track_fragmentation(
    py: Python<'_>,
    true_labels: Integers<'_>,
    estimated_labels: Integers<'_>,
    time_indices: Option<Integers<'_>>,
) -> PyResult<usize> {
    let (t, e) = (true_labels.values, estimated_labels.values);
    let times = time_indices.map(|times| times.values);
    py.detach(|| kernel::track_fragmentation(t, e, times)).map_err(raise)
}

/// How often the true label of an estimated label changes.
#[pyfunction]
pub(crate) fn identity_switches(
    py: Python<'_>,
    true_labels: Integers<'_>,
    estimated_labels: Integers<'_>,
    time_indices: Option<Integers<'_>>,
) -> PyResult<usize> {
    let (t, e) = (true_labels.values, estimated_labels.values);
    let times = time_indices.map(|times| times.values);
    py.detach(|| kernel::identity_switches(t, e, times)).map_err(raise)
}
