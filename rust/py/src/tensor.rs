//! Arrays with any number of axes, in and out.

use crate::error::{not_plain, raise};
use crate::lists::Array;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// A C-ordered float64 array of any number of axes.
pub(crate) struct Tensor<'a> {
    /// The elements.
    pub(crate) values: &'a [f64],
    shape: &'a [usize],
}

impl<'a, 'py> FromPyObject<'a, 'py> for Tensor<'a> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        let array = Array::borrow(object).ok_or_else(|| not_plain(py))?;
        let values = array.floats().ok_or_else(|| not_plain(py))?;
        Ok(Self { values, shape: array.lengths() })
    }
}

impl<'a> Tensor<'a> {
    /// The array with the name that messages give it.
    pub(crate) fn named(&self, argument: &'static str) -> PyResult<trackmetrics_core::Array<'a>> {
        trackmetrics_core::Array::new(argument, self.values, self.shape).map_err(raise)
    }
}

/// What a kernel gives back for leading axes: an array, or a number where there are none.
#[derive(IntoPyObject)]
pub(crate) enum Shaped<'py> {
    /// Without leading axes.
    Number(f64),
    /// With them.
    Array(Bound<'py, PyArrayDyn<f64>>),
}

impl<'py> Shaped<'py> {
    /// An array of this shape, or a number for the empty shape.
    pub(crate) fn new(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Self> {
        match (shape, &values[..]) {
            ([], [value]) => Ok(Self::Number(*value)),
            _ => Self::array(py, values, shape),
        }
    }

    /// An array of this shape.
    pub(crate) fn array(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Self> {
        PyArray1::from_vec(py, values).reshape(shape).map(Self::Array)
    }
}

/// Elements from which work is worth letting go of the interpreter.
const DETACH: usize = 8192;

/// Runs `work` on `elements` elements, detached from the interpreter where that is worth it.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    elements: usize,
    work: impl FnOnce() -> T + Send,
) -> T {
    if elements < DETACH { work() } else { py.detach(work) }
}
