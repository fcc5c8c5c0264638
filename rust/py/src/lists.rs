//! Reading NumPy arrays, and lists of small ones, without copying through NumPy.
//!
//! The documented API takes lists of small arrays. Packing such a list through NumPy costs hundreds
//! of nanoseconds an element; walking it and reading each array's fields costs about five. What is
//! not an exact `ndarray` of native `float64` or `int64` is left to the public door, which has NumPy
//! convert it.
//!
//! This is the only file of the crate with `unsafe` code. All of it rests on two facts: the
//! interpreter is attached (a [`Bound`] proves it), so that no Python code runs while a field is
//! read; and the layout of an exact `ndarray` is part of NumPy's ABI.

#![allow(unsafe_code)]

use numpy::npyffi::{self, PyArrayObject};
use numpy::{Element, PyArrayDescr};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyList, PyTuple};

/// The element types that are read without NumPy's help.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Float64,
    Int64,
}

/// An exact, aligned, C-contiguous `ndarray` of a native number type, borrowed.
pub(crate) struct Array<'a> {
    kind: Kind,
    data: *const u8,
    shape: &'a [isize],
}

impl<'a> Array<'a> {
    /// Borrows `object` where it is such an array.
    #[inline]
    pub(crate) fn borrow(object: Borrowed<'a, '_, PyAny>) -> Option<Self> {
        let py = object.py();
        let pointer = object.as_ptr();
        // SAFETY: `pointer` is a live object and the interpreter is attached.
        if unsafe { npyffi::PyArray_CheckExact(py, pointer) } == 0 {
            return None;
        }
        // SAFETY: an exact ndarray starts with the fields of `PyArrayObject`; they are written by
        // NumPy only, under the interpreter, which is attached for the lifetime of `object`.
        let fields = unsafe { &(*pointer.cast::<PyArrayObject>()).fields };
        let plain = npyffi::NPY_ARRAY_C_CONTIGUOUS | npyffi::NPY_ARRAY_ALIGNED;
        if fields.flags & plain != plain {
            return None;
        }
        let kind = kind(py, fields.descr.cast())?;
        let shape = if fields.nd == 0 {
            &[]
        } else {
            // SAFETY: `dimensions` holds `nd` lengths as long as the array lives unchanged.
            unsafe { std::slice::from_raw_parts(fields.dimensions, fields.nd as usize) }
        };
        Some(Self { kind, data: fields.data.cast(), shape })
    }

    /// Its shape; every length is at least 0.
    #[inline]
    pub(crate) fn shape(&self) -> &'a [isize] {
        self.shape
    }

    /// How many elements.
    #[inline]
    pub(crate) fn size(&self) -> usize {
        self.shape.iter().product::<isize>() as usize
    }

    /// The elements, where they are `float64`.
    ///
    /// Another thread that writes into the array while a kernel reads it, detached, gives a wrong
    /// number, as it does in every NumPy function.
    #[inline]
    pub(crate) fn floats(&self) -> Option<&'a [f64]> {
        self.slice(Kind::Float64)
    }

    /// The elements, where they are `int64`.
    #[inline]
    pub(crate) fn integers(&self) -> Option<&'a [i64]> {
        self.slice(Kind::Int64)
    }

    #[inline]
    fn slice<T>(&self, kind: Kind) -> Option<&'a [T]> {
        if self.kind != kind {
            return None;
        }
        if self.size() == 0 {
            return Some(&[]);
        }
        // SAFETY: the array is aligned, contiguous and of this kind, checked in `borrow`, so that
        // `size` elements of `T` stand at `data`; the object is borrowed for 'a and keeps them.
        Some(unsafe { std::slice::from_raw_parts(self.data.cast(), self.size()) })
    }

    /// Appends the elements as floats.
    #[inline]
    fn append_to(&self, values: &mut Vec<f64>) {
        match self.kind {
            Kind::Float64 => values.extend_from_slice(self.floats().unwrap_or_default()),
            Kind::Int64 => {
                values.extend(self.integers().unwrap_or_default().iter().map(|&i| i as f64));
            }
        }
    }
}

/// The kind of a descriptor: a comparison of pointers, since NumPy has one object for each native
/// type.
#[inline]
fn kind(py: Python<'_>, descr: *const pyo3::ffi::PyObject) -> Option<Kind> {
    static KINDS: PyOnceLock<[Py<PyArrayDescr>; 2]> = PyOnceLock::new();
    let [float64, int64] =
        KINDS.get_or_init(py, || [f64::get_dtype(py).unbind(), i64::get_dtype(py).unbind()]);
    if descr == float64.as_ptr().cast_const() {
        Some(Kind::Float64)
    } else if descr == int64.as_ptr().cast_const() {
        Some(Kind::Int64)
    } else {
        None
    }
}

/// Why a list was not packed.
pub(crate) enum Unpacked {
    /// It is not a plain list of plain arrays.
    NotPlain,
    /// The element of this index has `found` coordinates, those before it `expected`.
    Dimension { index: usize, found: usize, expected: usize },
}

/// Appends the arrays of a list or tuple to `values`, one point each, and returns how many points.
///
/// `dimension` is the number of coordinates of every point, set by the first where it is `None`.
pub(crate) fn pack_points(
    items: &Bound<'_, PyAny>,
    dimension: &mut Option<usize>,
    values: &mut Vec<f64>,
) -> Result<usize, Unpacked> {
    if let Ok(list) = items.cast_exact::<PyList>() {
        pack(list.iter(), dimension, values)
    } else if let Ok(tuple) = items.cast_exact::<PyTuple>() {
        pack(tuple.iter(), dimension, values)
    } else {
        Err(Unpacked::NotPlain)
    }
}

fn pack<'py>(
    items: impl ExactSizeIterator<Item = Bound<'py, PyAny>>,
    dimension: &mut Option<usize>,
    values: &mut Vec<f64>,
) -> Result<usize, Unpacked> {
    let count = items.len();
    values.reserve(count * dimension.unwrap_or(3));
    for (index, item) in items.enumerate() {
        let array = Array::borrow(item.as_borrowed()).ok_or(Unpacked::NotPlain)?;
        let found = array.size();
        let expected = *dimension.get_or_insert(found);
        if found != expected {
            return Err(Unpacked::Dimension { index, found, expected });
        }
        if found == 0 {
            return Err(Unpacked::NotPlain);
        }
        array.append_to(values);
    }
    Ok(count)
}

/// Appends the frames of a list or tuple to `values`, and their offsets to `starts`.
///
/// A frame is an `(n, d)` array or what [`pack_points`] takes; the error names the frame.
pub(crate) fn pack_frames(
    frames: &Bound<'_, PyAny>,
    dimension: &mut Option<usize>,
    values: &mut Vec<f64>,
    starts: &mut Vec<i64>,
) -> Result<(), (usize, Unpacked)> {
    if let Ok(list) = frames.cast_exact::<PyList>() {
        pack_each_frame(list.iter(), dimension, values, starts)
    } else if let Ok(tuple) = frames.cast_exact::<PyTuple>() {
        pack_each_frame(tuple.iter(), dimension, values, starts)
    } else {
        Err((0, Unpacked::NotPlain))
    }
}

fn pack_each_frame<'py>(
    frames: impl ExactSizeIterator<Item = Bound<'py, PyAny>>,
    dimension: &mut Option<usize>,
    values: &mut Vec<f64>,
    starts: &mut Vec<i64>,
) -> Result<(), (usize, Unpacked)> {
    let mut points = 0;
    starts.reserve(frames.len() + 1);
    starts.push(0);
    for (t, frame) in frames.enumerate() {
        points += match Array::borrow(frame.as_borrowed()) {
            Some(array) => pack_rows(&array, dimension, values),
            None => pack_points(&frame, dimension, values),
        }
        .map_err(|error| (t, error))?;
        starts.push(points as i64);
    }
    Ok(())
}

/// Appends the rows of an `(n, d)` array, one point each.
fn pack_rows(
    array: &Array<'_>,
    dimension: &mut Option<usize>,
    values: &mut Vec<f64>,
) -> Result<usize, Unpacked> {
    let &[rows, found] = array.shape() else {
        return Err(Unpacked::NotPlain);
    };
    let (rows, found) = (rows as usize, found as usize);
    if rows == 0 {
        return Ok(0);
    }
    let expected = *dimension.get_or_insert(found);
    if found != expected {
        return Err(Unpacked::Dimension { index: 0, found, expected });
    }
    if found == 0 {
        return Err(Unpacked::NotPlain);
    }
    array.append_to(values);
    Ok(rows)
}

/// The two arrays of a tuple of two.
pub(crate) fn pair<'a>(object: &'a Bound<'_, PyAny>) -> Option<(Array<'a>, Array<'a>)> {
    let tuple = object.cast_exact::<PyTuple>().ok().filter(|tuple| tuple.len() == 2)?;
    let item = |i| tuple.get_borrowed_item(i).ok().and_then(Array::borrow);
    Some((item(0)?, item(1)?))
}
