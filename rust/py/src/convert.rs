//! The argument types that kernels take.
//!
//! Each reads what it can without NumPy's help and raises `NotPlain` otherwise: the public door then
//! has NumPy convert the argument, and calls again.

use crate::error::{not_plain, raise};
use crate::lists::{self, Array, Unpacked};
use pyo3::prelude::*;
use std::borrow::Cow;
use trackmetrics_core::{Error, Points, Result};

/// A set of points: a C-ordered `(n, d)` float64 array, or a list of arrays of `d` numbers each.
pub(crate) struct PointSet<'a> {
    coordinates: Cow<'a, [f64]>,
    dimension: usize,
}

impl<'a> PointSet<'a> {
    /// Reads the argument of this name.
    pub(crate) fn read(argument: &'static str, object: &'a Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(array) = Array::borrow(object.as_borrowed())
            && let (Some(coordinates), &[_, d]) = (array.floats(), array.shape())
        {
            return Ok(Self { coordinates: Cow::Borrowed(coordinates), dimension: d as usize });
        }
        let (mut values, mut dimension) = (Vec::new(), None);
        match lists::pack_points(object, &mut dimension, &mut values) {
            Ok(_) => {
                Ok(Self { coordinates: Cow::Owned(values), dimension: dimension.unwrap_or(0) })
            }
            Err(Unpacked::NotPlain) => Err(not_plain(object.py())),
            Err(Unpacked::Dimension { index, found, expected }) => {
                Err(raise(Error::Dimension { argument, index: vec![index], found, expected }))
            }
        }
    }

    /// The points, checked.
    pub(crate) fn points(&self, argument: &'static str) -> Result<Points<'_>> {
        Points::new(argument, &self.coordinates, self.dimension)
    }
}

/// A C-ordered float64 array of `N` axes.
pub(crate) struct Floats<'a, const N: usize> {
    /// The elements.
    pub(crate) values: &'a [f64],
    /// The lengths of the axes.
    pub(crate) shape: [usize; N],
}

impl<'a, 'py, const N: usize> FromPyObject<'a, 'py> for Floats<'a, N> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        let array = Array::borrow(object).ok_or_else(|| not_plain(py))?;
        let values = array.floats().ok_or_else(|| not_plain(py))?;
        let lengths: &[isize; N] = array.shape().try_into().map_err(|_| not_plain(py))?;
        Ok(Self { values, shape: lengths.map(|length| length as usize) })
    }
}

/// A C-ordered int64 array of one axis.
pub(crate) struct Integers<'a> {
    /// The elements.
    pub(crate) values: &'a [i64],
}

impl<'a, 'py> FromPyObject<'a, 'py> for Integers<'a> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array = Array::borrow(object).filter(|array| array.shape().len() == 1);
        let values = array.and_then(|array| array.integers());
        values.map(|values| Self { values }).ok_or_else(|| not_plain(object.py()))
    }
}
