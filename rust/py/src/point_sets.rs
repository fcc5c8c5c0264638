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
use trackmetrics_core::point_sets::cost_source::Distances;
use trackmetrics_core::point_sets::results::{Gospa, Pair};
use trackmetrics_core::point_sets::workspace::Workspace;
use trackmetrics_core::point_sets::{distances, gospa as gospa_kernel, ospa as ospa_kernel};
use trackmetrics_core::{Array as CoreArray, Frames, Points, Result};

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

/// Runs a kernel of two sets.
#[inline]
fn of_sets<T: Send>(
    py: Python<'_>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    kernel: impl FnOnce(Points, Points, &mut Workspace, &Interrupt<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    run(py, x.size().min(y.size()), |work, interrupt| {
        kernel(x.points("X")?, y.points("Y")?, work, interrupt)
    })
}

/// Runs a kernel of two sequences of sets, which writes one result for each frame.
fn of_sequences<T: Clone + Default + Send>(
    py: Python<'_>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    kernel: impl FnOnce(Frames, Frames, &mut [T], &Interrupt<'_>) -> Result<()> + Send,
) -> PyResult<Vec<T>> {
    let (x, y) = (FrameSequence::read("X_sequence", x)?, FrameSequence::read("Y_sequence", y)?);
    run(py, x.size().min(y.size()), |_, interrupt| {
        let (x, y) = (x.frames("X_sequence")?, y.frames("Y_sequence")?);
        let mut output = vec![T::default(); x.len()];
        kernel(x, y, &mut output, interrupt).map(|()| output)
    })
}

/// Runs a kernel of two sets whose distances are given.
fn of_distances<T: Send>(
    py: Python<'_>,
    distances: &Floats<'_, 2>,
    kernel: impl FnOnce(Distances, &mut Workspace, &Interrupt<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    let Floats { values, shape: [rows, columns] } = *distances;
    run(py, values.len(), |work, interrupt| {
        kernel(Distances::new("distances", values, rows, columns)?, work, interrupt)
    })
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
    let result =
        of_sets(py, x, y, |x, y, work, interrupt| ospa_kernel::ospa(x, y, c, p, work, interrupt))?;
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
    let output = of_sequences(py, x, y, |x, y, output, interrupt| {
        ospa_kernel::ospa_over_time(x, y, c, p, output, interrupt)
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
    let result = of_distances(py, &distances, |distances, work, interrupt| {
        ospa_kernel::ospa_from_distances(distances, c, p, work, interrupt)
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
    let pairs = of_sets(py, x, y, |x, y, work, interrupt| {
        ospa_kernel::ospa_assignment(x, y, c, p, work, interrupt)
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
    let mut pairs = Vec::new();
    let result = of_sets(py, x, y, |x, y, work, interrupt| {
        gospa_kernel::gospa(x, y, (c, p, alpha), work, &mut pairs, interrupt)
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
    let mut pairs = Vec::new();
    let result = of_distances(py, &distances, |distances, work, interrupt| {
        gospa_kernel::gospa_from_distances(distances, (c, p, alpha), work, &mut pairs, interrupt)
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
    let output = of_sequences(py, x, y, |x, y, output, interrupt| {
        gospa_kernel::gospa_over_time(x, y, (c, p, alpha), output, interrupt)
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

fn indices<'py>(py: Python<'py>, pairs: &[Pair]) -> PyResult<Pairs<'py>> {
    let flat = pairs.iter().flat_map(|&(i, j)| [i as i64, j as i64]);
    PyArray1::from_iter(py, flat).reshape([pairs.len(), 2])
}

fn fields(g: &Gospa) -> GospaParts {
    (g.distance, g.localization, g.missed, g.false_alarms, g.missed_count, g.false_count)
}
