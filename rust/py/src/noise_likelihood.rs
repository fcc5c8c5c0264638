//! Binding of `trackmetrics_core::diagnostics::noise_likelihood`.

use crate::convert::{Floats, Integers};
use crate::error::raise;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use trackmetrics_core::diagnostics::noise_likelihood::{self as core, NoiseFactors, NoiseLog};

/// Log-densities, gradients, informations, whitened innovations, means and covariances.
type Likelihood<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray3<f64>>,
);

/// The log-likelihood of factors on the noises that a filter claims.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "a kernel takes arrays, one for each column")]
pub(crate) fn noise_likelihood<'py>(
    py: Python<'py>,
    innovations: Floats<'_, 2>,
    observations: Floats<'_, 3>,
    measurement_noises: Floats<'_, 3>,
    types: Integers<'_>,
    transitions: Floats<'_, 3>,
    process_noises: Floats<'_, 4>,
    corrections: Floats<'_, 2>,
    periods: Floats<'_, 2>,
    initial: Floats<'_, 3>,
    starts: Integers<'_>,
    process_factors: Floats<'_, 1>,
    measurement_factors: Floats<'_, 1>,
    initial_factor: f64,
    tail_dof: f64,
    tail_scales: Floats<'_, 1>,
    derivatives: bool,
) -> PyResult<Likelihood<'py>> {
    let log = NoiseLog {
        innovations: innovations.values,
        observations: observations.values,
        measurement_noises: measurement_noises.values,
        types: types.values,
        transitions: transitions.values,
        process_noises: process_noises.values,
        corrections: corrections.values,
        periods: periods.values,
        initial: initial.values,
        starts: starts.values,
        states: corrections.shape[1],
        components: innovations.shape[1],
        groups: process_noises.shape[1],
    };
    let factors = NoiseFactors {
        process: process_factors.values,
        measurement: measurement_factors.values,
        initial: initial_factor,
        tail_dof,
        tail_scales: tail_scales.values,
    };
    let found = py.detach(|| core::noise_likelihood(&log, &factors, derivatives)).map_err(raise)?;
    let (tracks, n) = (starts.values.len() - 1, log.states);
    let count = if derivatives { factors.count() } else { 0 };
    Ok((
        PyArray1::from_vec(py, found.densities),
        PyArray1::from_vec(py, found.gradients).reshape([tracks, count])?,
        PyArray1::from_vec(py, found.informations).reshape([tracks, count, count])?,
        PyArray1::from_vec(py, found.whitened).reshape(innovations.shape)?,
        PyArray1::from_vec(py, found.means).reshape([tracks, n])?,
        PyArray1::from_vec(py, found.covariances).reshape([tracks, n, n])?,
    ))
}
