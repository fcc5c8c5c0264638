//! Binding of `trackmetrics_core::vessel`.

use crate::convert::{Floats, Integers};
use crate::error::raise;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use trackmetrics_core::vessel::{self, Life, Motion, Reports, Rows, Tracks};

type One<'py, T> = Bound<'py, PyArray1<T>>;
type Two<'py> = Bound<'py, PyArray2<f64>>;
type Three<'py> = Bound<'py, PyArray3<f64>>;
type TrackArrays<'py> = (Two<'py>, Two<'py>, Three<'py>);
type PairArrays<'py> = (One<'py, i64>, One<'py, i64>, One<'py, f64>, One<'py, f64>);
type RowArrays<'py> = (
    One<'py, i64>,
    One<'py, i64>,
    Two<'py>,
    Three<'py>,
    Two<'py>,
    Three<'py>,
    Three<'py>,
    One<'py, f64>,
    Two<'py>,
    Three<'py>,
    Three<'py>,
);

/// Densities of acceleration, turn and course, and the time constant of the turn rate.
type MotionNumbers = (f64, f64, f64, f64);

fn motion((acceleration, turn, course, decay): MotionNumbers) -> Motion {
    Motion { acceleration, turn, course, decay }
}

fn two<'py>(py: Python<'py>, values: Vec<f64>, width: usize) -> PyResult<Two<'py>> {
    let rows = values.len() / width;
    PyArray1::from_vec(py, values).reshape([rows, width])
}

fn three<'py>(py: Python<'py>, values: Vec<f64>, width: usize) -> PyResult<Three<'py>> {
    let rows = values.len() / (width * width);
    PyArray1::from_vec(py, values).reshape([rows, width, width])
}

/// States after their times, without noise.
#[pyfunction]
pub(crate) fn vessel_advance<'py>(
    py: Python<'py>,
    x: Floats<'_, 2>,
    times: Floats<'_, 1>,
    motion: MotionNumbers,
) -> PyResult<Two<'py>> {
    let motion = self::motion(motion);
    let states = py.detach(|| vessel::advance(x.values, times.values, &motion)).map_err(raise)?;
    two(py, states, 5)
}

/// States, covariances and Jacobians after their times: (x, P, F).
#[pyfunction]
#[pyo3(signature = (x, P, times, motion))]
#[expect(non_snake_case, reason = "P is the field's letter, in Python too")]
pub(crate) fn vessel_predict<'py>(
    py: Python<'py>,
    x: Floats<'_, 2>,
    P: Floats<'_, 3>,
    times: Floats<'_, 1>,
    motion: MotionNumbers,
) -> PyResult<(Two<'py>, Three<'py>, Three<'py>)> {
    let motion = self::motion(motion);
    let at =
        py.detach(|| vessel::predict(x.values, P.values, times.values, &motion)).map_err(raise)?;
    Ok((two(py, at.x, 5)?, three(py, at.p, 5)?, three(py, at.f, 5)?))
}

/// Reports through the filters of their tracks: the tracks afterwards, and a row for each report.
#[pyfunction]
#[pyo3(signature = (life, x, P, starts, times, z, observed, sigmas, motion, rules))]
#[expect(non_snake_case, reason = "P is the field's letter, in Python too")]
#[expect(clippy::too_many_arguments, reason = "one array for each column, as NumPy holds them")]
pub(crate) fn vessel_filter<'py>(
    py: Python<'py>,
    life: Floats<'_, 2>,
    x: Floats<'_, 2>,
    P: Floats<'_, 3>,
    starts: Integers<'_>,
    times: Floats<'_, 1>,
    z: Floats<'_, 2>,
    observed: Integers<'_>,
    sigmas: Floats<'_, 2>,
    motion: MotionNumbers,
    rules: (usize, f64, bool, f64),
) -> PyResult<(TrackArrays<'py>, RowArrays<'py>)> {
    let (tentative, turn_rate, placeholders, delete_after) = rules;
    let rules = Life { tentative, turn_rate, placeholders, delete_after };
    let mut tracks = Tracks { life: life.values.into(), x: x.values.into(), p: P.values.into() };
    let reports = Reports {
        starts: starts.values,
        times: times.values,
        z: z.values,
        observed: observed.values,
        sigmas: sigmas.values,
    };
    let motion = self::motion(motion);
    let rows =
        py.detach(|| vessel::filter(&mut tracks, &reports, &motion, &rules)).map_err(raise)?;
    let tracks = (two(py, tracks.life, 7)?, two(py, tracks.x, 5)?, three(py, tracks.p, 5)?);
    Ok((tracks, rows_to_arrays(py, rows)?))
}

fn rows_to_arrays<'py>(py: Python<'py>, rows: Rows) -> PyResult<RowArrays<'py>> {
    Ok((
        PyArray1::from_vec(py, rows.outcome),
        PyArray1::from_vec(py, rows.start),
        two(py, rows.x_pred, 5)?,
        three(py, rows.p_pred, 5)?,
        two(py, rows.innovation, 4)?,
        three(py, rows.s, 4)?,
        three(py, rows.r, 4)?,
        PyArray1::from_vec(py, rows.nis),
        two(py, rows.x, 5)?,
        three(py, rows.p, 5)?,
        three(py, rows.a, 5)?,
    ))
}

/// Positions and tracks within each other's gate: (position, track, distance squared, ln det S).
#[pyfunction]
#[pyo3(signature = (x, P, times, z, sigmas, gate, motion))]
#[expect(non_snake_case, reason = "P is the field's letter, in Python too")]
#[expect(clippy::too_many_arguments, reason = "one array for each column, as NumPy holds them")]
pub(crate) fn vessel_gate<'py>(
    py: Python<'py>,
    x: Floats<'_, 2>,
    P: Floats<'_, 3>,
    times: Floats<'_, 1>,
    z: Floats<'_, 2>,
    sigmas: Floats<'_, 1>,
    gate: f64,
    motion: MotionNumbers,
) -> PyResult<PairArrays<'py>> {
    let (motion, tracks) = (self::motion(motion), (x.values, P.values, times.values));
    let pairs = py
        .detach(|| vessel::gate(tracks, z.values, sigmas.values, gate, &motion))
        .map_err(raise)?;
    let (mut positions, mut tracks) = (Vec::new(), Vec::new());
    let (mut distances, mut log_dets) = (Vec::new(), Vec::new());
    for pair in pairs {
        positions.push(pair.position as i64);
        tracks.push(pair.track as i64);
        distances.push(pair.distance);
        log_dets.push(pair.log_det);
    }
    Ok((
        PyArray1::from_vec(py, positions),
        PyArray1::from_vec(py, tracks),
        PyArray1::from_vec(py, distances),
        PyArray1::from_vec(py, log_dets),
    ))
}
