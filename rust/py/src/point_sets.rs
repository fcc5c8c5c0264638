//! Binding of `trackmetrics_core::point_sets`.

use crate::convert::{FrameSequence, PointSet};
use crate::error::raise;
use crate::results::ospa_result;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::cell::RefCell;
use trackmetrics_core::point_sets::ospa::{self as kernel, Workspace};

/// From this many coordinates on the work is worth letting go of the interpreter.
const WORTH_DETACHING: usize = 400;

thread_local! {
    static WORK: RefCell<Workspace> = RefCell::default();
}

/// OSPA of one frame.
#[pyfunction]
pub(crate) fn ospa<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    y: &Bound<'py, PyAny>,
    c: f64,
    p: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let compute =
        || WORK.with_borrow_mut(|work| kernel::ospa(x.points("X")?, y.points("Y")?, c, p, work));
    let detach = x.size().min(y.size()) >= WORTH_DETACHING;
    let result = if detach { py.detach(compute) } else { compute() };
    ospa_result(py, result.map_err(raise)?)
}

/// OSPA of every frame of two sequences.
#[pyfunction]
pub(crate) fn ospa_over_time<'py>(
    py: Python<'py>,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    c: f64,
    p: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (x, y) = (FrameSequence::read("X_sequence", x)?, FrameSequence::read("Y_sequence", y)?);
    let compute = || {
        let (x, y) = (x.frames("X_sequence")?, y.frames("Y_sequence")?);
        let mut output = vec![0.0; x.len()];
        kernel::ospa_over_time(x, y, c, p, &mut output)?;
        Ok(output)
    };
    let detach = x.size().min(y.size()) >= WORTH_DETACHING;
    let output = if detach { py.detach(compute) } else { compute() };
    output.map(|output| PyArray1::from_vec(py, output)).map_err(raise)
}
