//! Binding of `trackmetrics_core::monte_carlo`.

use crate::convert::Floats;
use crate::error::raise;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use trackmetrics_core::monte_carlo::batch::Batch;
use trackmetrics_core::monte_carlo::consistency::{self as kernel, Levels};
use trackmetrics_core::monte_carlo::{histogram, pairwise_tree};

/// Sums over the canonical nodes of a batch of runs `(runs, columns)`.
#[pyfunction]
pub(crate) fn run_sums<'py>(
    py: Python<'py>,
    values: Floats<'_, 2>,
    first_run: u64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let [_, columns] = values.shape;
    let sums =
        py.detach(|| pairwise_tree::run_sums(values.values, columns, first_run)).map_err(raise)?;
    let nodes = sums.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, sums).reshape([nodes, columns])
}

/// Counts of each column of `(runs, columns)` in the bins of a histogram.
#[pyfunction]
pub(crate) fn histograms<'py>(
    py: Python<'py>,
    values: Floats<'_, 2>,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let [_, columns] = values.shape;
    let counts = py.detach(|| histogram::histograms(values.values, columns)).map_err(raise)?;
    PyArray1::from_vec(py, counts).reshape([columns, histogram::BINS])
}

type Matrix<'py, T> = Bound<'py, PyArray2<T>>;
type Sums<'py> = (Matrix<'py, f64>, Matrix<'py, f64>, Matrix<'py, i64>, Matrix<'py, i64>);

/// What is kept of the errors of a batch of runs: sums over its nodes, sums of each run, counts, and
/// a histogram.
#[pyfunction]
#[pyo3(signature = (truth, estimates, covariances, periods, first_run, decibels, thresholds))]
#[allow(clippy::too_many_arguments)] // the reference takes the same
pub(crate) fn consistency_sums<'py>(
    py: Python<'py>,
    truth: Floats<'_, 3>,
    estimates: Option<Floats<'_, 3>>,
    covariances: Floats<'_, 4>,
    periods: Floats<'_, 1>,
    first_run: u64,
    decibels: f64,
    thresholds: Floats<'_, 1>,
) -> PyResult<Sums<'py>> {
    let [runs, steps, d] = truth.shape;
    let batch = Batch {
        truth: truth.values,
        estimates: estimates.as_ref().map(|estimates| estimates.values),
        covariances: covariances.values,
        runs,
        steps,
        periods: periods.values,
        first_run,
    };
    let levels = Levels { decibels, thresholds: thresholds.values };
    let sums = py.detach(|| kernel::consistency_sums(batch, levels)).map_err(raise)?;
    let width = steps * (kernel::FORM_COLUMNS + kernel::STATE_COLUMNS * d);
    let nodes = sums.nodes.len() / width;
    Ok((
        PyArray1::from_vec(py, sums.nodes).reshape([nodes, width])?,
        PyArray1::from_vec(py, sums.runs).reshape([runs, 2 + d])?,
        PyArray1::from_vec(py, sums.counts).reshape([1 + thresholds.values.len(), steps])?,
        PyArray1::from_vec(py, sums.histogram).reshape([steps, histogram::BINS])?,
    ))
}
