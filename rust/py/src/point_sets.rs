//! Binding of `trackmetrics_core::point_sets`.

use crate::convert::{Floats, FrameSequence, PointSet, number};
use crate::error::raise;
use crate::interrupt::detached;
use crate::results::ospa_result;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::cell::RefCell;
use trackmetrics_core::interrupt::Interrupt;
use trackmetrics_core::point_sets::gospa::{self as gospa_kernel, Gospa};
use trackmetrics_core::point_sets::ospa::{self as ospa_kernel, Workspace};
use trackmetrics_core::point_sets::{distances, pairs::Pair, sets::Distances};
use trackmetrics_core::{Array as CoreArray, Points, Result};

/// From this many coordinates on the work is worth letting go of the interpreter.
const WORTH_DETACHING: usize = 400;

thread_local! {
    static WORK: RefCell<Workspace> = RefCell::default();
}

/// Pairs as rows of indices.
type Pairs<'py> = Bound<'py, PyArray2<i64>>;

/// The fields of many `Gospa`: parts, then counts.
type Columns<'py> = (Vec<Bound<'py, PyArray1<f64>>>, Vec<Bound<'py, PyArray1<i64>>>);

/// The fields of a `Gospa`, in their order.
type GospaParts = (f64, f64, f64, f64, usize, usize);

/// Runs a kernel with this thread's workspace, detached from the interpreter and open to signals
/// where the smaller set has many coordinates.
#[inline]
fn run<T: Send>(
    py: Python<'_>,
    size: usize,
    kernel: impl FnOnce(&mut Workspace, &Interrupt<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    if size < WORTH_DETACHING {
        return WORK.with_borrow_mut(|work| kernel(work, &Interrupt::never())).map_err(raise);
    }
    // A signal handler may come back here while the kernel runs: it finds a workspace of its own.
    detached(py, |interrupt| {
        let mut work = WORK.take();
        let result = kernel(&mut work, interrupt);
        WORK.set(work);
        result
    })
}

fn smaller(x: &PointSet, y: &PointSet) -> usize {
    x.size().min(y.size())
}

/// OSPA of one frame.
#[pyfunction]
pub(crate) fn ospa<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    y: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let result = run(py, smaller(&x, &y), |work, interrupt| {
        ospa_kernel::ospa(x.points("X")?, y.points("Y")?, c, p, work, interrupt)
    })?;
    ospa_result(py, result)
}

/// OSPA of every frame of two sequences.
#[pyfunction]
pub(crate) fn ospa_over_time<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (x, y) = (FrameSequence::read("X_sequence", x)?, FrameSequence::read("Y_sequence", y)?);
    let output = run(py, x.size().min(y.size()), |_, interrupt| {
        let (x, y) = (x.frames("X_sequence")?, y.frames("Y_sequence")?);
        let mut output = vec![0.0; x.len()];
        ospa_kernel::ospa_over_time(x, y, c, p, &mut output, interrupt)?;
        Ok(output)
    })?;
    Ok(PyArray1::from_vec(py, output))
}

/// OSPA of one frame whose distances are given.
#[pyfunction]
pub(crate) fn ospa_from_distances<'py>(
    py: Python<'py>,
    distances: Floats<'_, 2>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let result = run(py, distances.values.len(), |work, interrupt| {
        ospa_kernel::ospa_from_distances(given(&distances)?, c, p, work, interrupt)
    })?;
    ospa_result(py, result)
}

/// The pairs of OSPA closer than the cutoff.
#[pyfunction]
pub(crate) fn ospa_assignment<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
) -> PyResult<Pairs<'py>> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let pairs = run(py, smaller(&x, &y), |work, interrupt| {
        ospa_kernel::ospa_assignment(x.points("X")?, y.points("Y")?, c, p, work, interrupt)
    })?;
    indices(py, &pairs)
}

/// GOSPA of one frame: (distance, localization, missed, false, the two counts), pairs.
#[pyfunction]
pub(crate) fn gospa<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
    #[pyo3(from_py_with = number)] alpha: f64,
) -> PyResult<(GospaParts, Pairs<'py>)> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let (result, pairs) = run(py, smaller(&x, &y), |work, interrupt| {
        let (x, y, mut pairs) = (x.points("X")?, y.points("Y")?, Vec::new());
        gospa_kernel::gospa(x, y, (c, p, alpha), work, &mut pairs, interrupt)
            .map(|result| (result, pairs))
    })?;
    Ok((fields(&result), indices(py, &pairs)?))
}

/// GOSPA of one frame whose distances are given.
#[pyfunction]
pub(crate) fn gospa_from_distances<'py>(
    py: Python<'py>,
    distances: Floats<'_, 2>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
    #[pyo3(from_py_with = number)] alpha: f64,
) -> PyResult<(GospaParts, Pairs<'py>)> {
    let (result, pairs) = run(py, distances.values.len(), |work, interrupt| {
        let (sets, mut pairs) = (given(&distances)?, Vec::new());
        gospa_kernel::gospa_from_distances(sets, (c, p, alpha), work, &mut pairs, interrupt)
            .map(|result| (result, pairs))
    })?;
    Ok((fields(&result), indices(py, &pairs)?))
}

/// GOSPA of every frame of two sequences: the fields as columns, the counts as integers.
#[pyfunction]
pub(crate) fn gospa_over_time<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = number)] c: f64,
    #[pyo3(from_py_with = number)] p: f64,
    #[pyo3(from_py_with = number)] alpha: f64,
) -> PyResult<Columns<'py>> {
    let (x, y) = (FrameSequence::read("X_sequence", x)?, FrameSequence::read("Y_sequence", y)?);
    let output = run(py, x.size().min(y.size()), |_, interrupt| {
        let (x, y) = (x.frames("X_sequence")?, y.frames("Y_sequence")?);
        let mut output = vec![Gospa::default(); x.len()];
        gospa_kernel::gospa_over_time(x, y, (c, p, alpha), &mut output, interrupt)?;
        Ok(output)
    })?;
    let parts: [fn(&Gospa) -> f64; 4] =
        [|g| g.distance, |g| g.localization, |g| g.missed, |g| g.false_alarms];
    let counts: [fn(&Gospa) -> i64; 2] = [|g| g.missed_count as i64, |g| g.false_count as i64];
    Ok((
        parts.map(|part| PyArray1::from_iter(py, output.iter().map(part))).into(),
        counts.map(|count| PyArray1::from_iter(py, output.iter().map(count))).into(),
    ))
}

/// Distances between all pairs of points by "manhattan" or "haversine".
#[pyfunction]
pub(crate) fn point_distances<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    metric: &str,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let metric: fn(Points, Points) -> Result<Vec<f64>> = match metric {
        "manhattan" => distances::manhattan,
        "haversine" => distances::haversine,
        _ => return Err(PyValueError::new_err("metric must be 'manhattan' or 'haversine'")),
    };
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let (x, y) = (x.points("X").map_err(raise)?, y.points("Y").map_err(raise)?);
    matrix(py, metric(x, y), x, y)
}

/// Mahalanobis distances between all pairs of points.
#[pyfunction]
pub(crate) fn mahalanobis_distances<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    covariances: Floats<'_, 3>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let (x, y) = (x.points("X").map_err(raise)?, y.points("Y").map_err(raise)?);
    let covariances = CoreArray::new("covariances", covariances.values, &covariances.shape);
    matrix(py, covariances.and_then(|p| distances::mahalanobis(x, y, p)), x, y)
}

fn matrix<'py>(
    py: Python<'py>,
    distances: Result<Vec<f64>>,
    x: Points,
    y: Points,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    PyArray1::from_vec(py, distances.map_err(raise)?).reshape([x.len(), y.len()])
}

fn given<'a>(distances: &Floats<'a, 2>) -> Result<Distances<'a>> {
    let [rows, columns] = distances.shape;
    Distances::new("distances", distances.values, rows, columns)
}

fn indices<'py>(py: Python<'py>, pairs: &[Pair]) -> PyResult<Pairs<'py>> {
    let flat = pairs.iter().flat_map(|&(i, j)| [i as i64, j as i64]);
    PyArray1::from_iter(py, flat).reshape([pairs.len(), 2])
}

fn fields(g: &Gospa) -> GospaParts {
    (g.distance, g.localization, g.missed, g.false_alarms, g.missed_count, g.false_count)
}
