//! The argument types that kernels take.
//!
//! Each reads what it can without NumPy's help and raises `NotPlain` otherwise: the public function then
//! has NumPy convert the argument, and calls again.

use crate::error::{not_plain, raise};
use crate::lists::{Array, Items, Packed, Unpacked};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::borrow::Cow;
use trackmetrics_core::{Error, Frames, Points, Result};

/// A set of points: an array whose rows are points, or a list or tuple of points.
pub(crate) struct PointSet<'a> {
    coordinates: Cow<'a, [f64]>,
    dimension: usize,
}

impl<'a> PointSet<'a> {
    /// Reads the argument of this name.
    pub(crate) fn read(argument: &'static str, object: &'a Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(array) = Array::borrow(object.as_borrowed())
            && let (Some(coordinates), &[n, d]) = (array.floats(), array.shape())
            && (d > 0 || n == 0)
        {
            return Ok(Self { coordinates: Cow::Borrowed(coordinates), dimension: d as usize });
        }
        let mut packed = Packed::default();
        match packed.append_set(object.as_borrowed()) {
            Ok(_) => Ok(Self {
                coordinates: Cow::Owned(packed.values),
                dimension: packed.dimension.unwrap_or(0),
            }),
            Err(unpacked) => Err(refuse(object.py(), argument, None, unpacked)),
        }
    }

    /// How many coordinates.
    pub(crate) fn size(&self) -> usize {
        self.coordinates.len()
    }

    /// The points, checked.
    pub(crate) fn points(&self, argument: &'static str) -> Result<Points<'_>> {
        Points::new(argument, &self.coordinates, self.dimension)
    }
}

/// A sequence of point sets, in any of three forms: a list or tuple of sets; a `(T, n, d)` array;
/// or packed, as the tuple of `(N, d)` points and `(T + 1,)` starts.
pub(crate) struct FrameSequence<'a> {
    coordinates: Cow<'a, [f64]>,
    starts: Cow<'a, [i64]>,
    dimension: usize,
}

impl<'a> FrameSequence<'a> {
    /// Reads the argument of this name.
    pub(crate) fn read(argument: &'static str, object: &'a Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(frames) = Self::borrow_stacked(object).or_else(|| Self::borrow_packed(object)) {
            return Ok(frames);
        }
        let sets = Items::of(object.as_borrowed()).ok_or_else(|| not_plain(object.py()))?;
        Self::pack(argument, sets)
    }

    /// How many coordinates all sets have together.
    pub(crate) fn size(&self) -> usize {
        self.coordinates.len()
    }

    /// The sets, checked.
    pub(crate) fn frames(&self, argument: &'static str) -> Result<Frames<'_>> {
        Frames::new(argument, &self.coordinates, &self.starts, self.dimension)
    }

    fn borrow_stacked(object: &'a Bound<'_, PyAny>) -> Option<Self> {
        let array = Array::borrow(object.as_borrowed())?;
        let &[frames, points, d] = array.shape() else { return None };
        let coordinates = array.floats().filter(|_| d > 0 || frames * points == 0)?;
        let starts = (0..=frames).map(|t| (t * points) as i64).collect();
        Some(Self { coordinates: coordinates.into(), starts, dimension: d as usize })
    }

    fn borrow_packed(object: &'a Bound<'_, PyAny>) -> Option<Self> {
        let pair = object.cast_exact::<PyTuple>().ok().filter(|pair| pair.len() == 2)?;
        let points = Array::borrow(pair.get_borrowed_item(0).ok()?)?;
        let starts = Array::borrow(pair.get_borrowed_item(1).ok()?)?;
        if starts.shape().len() != 1 {
            return None;
        }
        let (&[n, d], starts) = (points.shape(), starts.integers()?) else { return None };
        let coordinates = points.floats().filter(|_| d > 0 || n == 0)?;
        Some(Self { coordinates: coordinates.into(), starts: starts.into(), dimension: d as usize })
    }

    fn pack(argument: &'static str, sets: Items<'_, '_>) -> PyResult<Self> {
        let mut packed = Packed::default();
        let (frames, mut end) = (sets.len(), 0);
        let mut starts = Vec::with_capacity(frames + 1);
        starts.push(end);
        for (t, set) in sets.enumerate() {
            let count = packed.append_set(set);
            end += count.map_err(|unpacked| refuse(set.py(), argument, Some(t), unpacked))? as i64;
            starts.push(end);
            if t == 0 {
                // As though the others were as large: most often nothing is moved again.
                let others = packed.values.len().saturating_mul(frames - 1);
                packed.values.reserve(others.min(1 << 20));
            }
        }
        let dimension = packed.dimension.unwrap_or(0);
        Ok(Self { coordinates: packed.values.into(), starts: starts.into(), dimension })
    }
}

/// The exception for a set that was not packed: the `frame`-th of a sequence, or the only one.
fn refuse(
    py: Python<'_>,
    argument: &'static str,
    frame: Option<usize>,
    unpacked: Unpacked,
) -> PyErr {
    match unpacked {
        Unpacked::NotPlain => not_plain(py),
        Unpacked::Dimension { index, found, expected } => {
            let index = frame.into_iter().chain([index]).collect();
            raise(Error::Dimension { argument, index, found, expected })
        }
    }
}

/// A number; anything else the public function names.
pub(crate) fn number(object: &Bound<'_, PyAny>) -> PyResult<f64> {
    object.extract().map_err(|_| not_plain(object.py()))
}

/// A number or `None`.
pub(crate) fn number_or_none(object: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    if object.is_none() { Ok(None) } else { number(object).map(Some) }
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
