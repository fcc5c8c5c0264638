//! The argument types that kernels take.
//!
//! Each reads what it can without NumPy's help and raises `NotPlain` otherwise: the public door then
//! has NumPy convert the argument, and calls again.

use crate::error::{not_plain, raise};
use crate::lists::{self, Array, Unpacked};
use pyo3::prelude::*;
use std::borrow::Cow;
use trackmetrics_core::{Error, Frames, Points, Result};

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

/// A sequence of point sets, packed: a list of sets of points, a C-ordered `(T, n, d)` float64
/// array, or a tuple of points `(N, d)` and offsets `(T + 1,)`.
pub(crate) struct FrameSequence<'a> {
    coordinates: Cow<'a, [f64]>,
    starts: Cow<'a, [i64]>,
    dimension: usize,
}

impl<'a> FrameSequence<'a> {
    /// Reads the argument of this name.
    pub(crate) fn read(argument: &'static str, object: &'a Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(frames) = Self::cube(object).or_else(|| Self::packed(object)) {
            return Ok(frames);
        }
        let (mut values, mut starts, mut dimension) = (Vec::new(), Vec::new(), None);
        match lists::pack_frames(object, &mut dimension, &mut values, &mut starts) {
            Ok(()) => Ok(Self {
                coordinates: Cow::Owned(values),
                starts: Cow::Owned(starts),
                dimension: dimension.unwrap_or(0),
            }),
            Err((_, Unpacked::NotPlain)) => Err(not_plain(object.py())),
            Err((frame, Unpacked::Dimension { index, found, expected })) => {
                let index = vec![frame, index];
                Err(raise(Error::Dimension { argument, index, found, expected }))
            }
        }
    }

    fn cube(object: &'a Bound<'_, PyAny>) -> Option<Self> {
        let array = Array::borrow(object.as_borrowed())?;
        let &[frames, n, d] = array.shape() else {
            return None;
        };
        let coordinates = array.floats().filter(|values| !values.is_empty())?;
        let starts = (0..=frames as i64).map(|t| t * n as i64).collect();
        Some(Self {
            coordinates: Cow::Borrowed(coordinates),
            starts: Cow::Owned(starts),
            dimension: d as usize,
        })
    }

    fn packed(object: &'a Bound<'_, PyAny>) -> Option<Self> {
        let (points, starts) = lists::pair(object)?;
        let &[_, d] = points.shape() else {
            return None;
        };
        let starts = (starts.shape().len() == 1).then(|| starts.integers()).flatten()?;
        Some(Self {
            coordinates: Cow::Borrowed(points.floats()?),
            starts: Cow::Borrowed(starts),
            dimension: d as usize,
        })
    }

    /// The sequence, checked.
    pub(crate) fn frames(&self, argument: &'static str) -> Result<Frames<'_>> {
        Frames::new(argument, &self.coordinates, &self.starts, self.dimension)
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
