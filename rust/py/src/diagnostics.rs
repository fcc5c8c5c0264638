//! Binding of `trackmetrics_core::diagnostics`.

use crate::convert::{Floats, Integers};
use crate::error::raise;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use trackmetrics_core::diagnostics::{
    best_split, cusum, nees_autocorrelation, segmentation, shapley,
};

/// Gains and cuts.
type Partitions<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<i64>>);

/// The best partitions of many sequences: gains `(k, most)` and cuts `(k, most, most - 1)`.
#[pyfunction]
pub(crate) fn scale_partitions<'py>(
    py: Python<'py>,
    values: Floats<'_, 1>,
    dof: Floats<'_, 1>,
    starts: Integers<'_>,
    least: usize,
    most: usize,
) -> PyResult<Partitions<'py>> {
    let partitions = py
        .detach(|| {
            segmentation::scale_partitions(values.values, dof.values, starts.values, least, most)
        })
        .map_err(raise)?;
    let (gains, cuts) = segmentation::flatten(&partitions, most);
    let sequences = partitions.len();
    let gains = PyArray1::from_vec(py, gains).reshape([sequences, most])?;
    let cuts = PyArray1::from_vec(py, cuts).reshape([sequences, most, most - 1])?;
    Ok((gains, cuts))
}

/// The gain of the best cut of each row of draws.
#[pyfunction]
pub(crate) fn best_split_gains<'py>(
    py: Python<'py>,
    draws: Floats<'_, 2>,
    dof: Floats<'_, 1>,
    least: usize,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let gains = py
        .detach(|| best_split::best_split_gains(draws.values, dof.values, least))
        .map_err(raise)?;
    Ok(PyArray1::from_vec(py, gains))
}

/// The first alarm of each sequence and where its rise began `(k, 2)`; -1 where there is none.
#[pyfunction]
pub(crate) fn first_alarms<'py>(
    py: Python<'py>,
    values: Floats<'_, 1>,
    dof: Floats<'_, 1>,
    starts: Integers<'_>,
    scale: f64,
    alpha: f64,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let alarms = py
        .detach(|| cusum::first_alarms(values.values, dof.values, starts.values, scale, alpha))
        .map_err(raise)?;
    let pair =
        |alarm: &Option<(usize, usize)>| alarm.map_or([-1; 2], |(k, j)| [k as i64, j as i64]);
    PyArray1::from_vec(py, alarms.iter().flat_map(pair).collect()).reshape([alarms.len(), 2])
}

/// The Shapley split of many squared errors over the states.
#[pyfunction]
pub(crate) fn shapley_shares<'py>(
    py: Python<'py>,
    errors: Floats<'_, 2>,
    covariances: Floats<'_, 3>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = errors.shape;
    let shares = py
        .detach(|| shapley::shapley_shares(errors.values, covariances.values, shape[1]))
        .map_err(raise)?;
    PyArray1::from_vec(py, shares).reshape(shape)
}

/// The same as a mean over given orders of the states.
#[pyfunction]
pub(crate) fn sampled_shapley_shares<'py>(
    py: Python<'py>,
    errors: Floats<'_, 2>,
    covariances: Floats<'_, 3>,
    orders: Integers<'_>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = errors.shape;
    let shares = py
        .detach(|| {
            shapley::sampled_shapley_shares(
                errors.values,
                covariances.values,
                shape[1],
                orders.values,
            )
        })
        .map_err(raise)?;
    PyArray1::from_vec(py, shares).reshape(shape)
}

/// By how much correlation in time widens each NEES of many tracks.
#[pyfunction]
pub(crate) fn nees_inflation<'py>(
    py: Python<'py>,
    transitions: Floats<'_, 3>,
    covariances: Floats<'_, 3>,
    starts: Integers<'_>,
    known: Option<Integers<'_>>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let dimension = covariances.shape[1];
    let tau = py
        .detach(|| {
            nees_autocorrelation::nees_inflation(
                transitions.values,
                covariances.values,
                dimension,
                starts.values,
                known.as_ref().map(|known| known.values),
            )
        })
        .map_err(raise)?;
    Ok(PyArray1::from_vec(py, tau))
}
