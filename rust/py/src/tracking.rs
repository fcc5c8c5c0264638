//! Binding of `trackmetrics_core::tracking`.

use crate::convert::{FrameSequence, Integers, number};
use crate::error::raise;
use pyo3::prelude::*;
use trackmetrics_core::tracking::{index_scores, labels as kernel};

/// From this many coordinates on the work is worth letting go of the interpreter.
const WORTH_DETACHING: usize = 400;

/// MOTA, MOTP, switches, fragmentations, false positives and misses of a sequence.
type Scores = (f64, f64, usize, usize, usize, usize);

/// CLEAR MOT scores of frames whose list index is the identity: (mota, motp, switches,
/// fragmentations, false positives, misses).
#[pyfunction]
pub(crate) fn mot_metrics(
    py: Python<'_>,
    ground_truth: &Bound<'_, PyAny>,
    estimates: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = number)] threshold: f64,
) -> PyResult<Scores> {
    let ground_truth = FrameSequence::read("ground_truth", ground_truth)?;
    let estimates = FrameSequence::read("estimates", estimates)?;
    let compute = || {
        let ground_truth = ground_truth.frames("ground_truth")?;
        index_scores::mot_metrics(ground_truth, estimates.frames("estimates")?, threshold)
    };
    let detach = ground_truth.size().min(estimates.size()) >= WORTH_DETACHING;
    let scores = if detach { py.detach(compute) } else { compute() };
    let s = scores.map_err(raise)?;
    Ok((s.mota, s.motp, s.switches, s.fragmentations, s.false_positives, s.misses))
}

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
