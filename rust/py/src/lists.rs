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
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

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

    /// Its shape, as unsigned numbers.
    #[inline]
    pub(crate) fn lengths(&self) -> &'a [usize] {
        // SAFETY: `isize` and `usize` have one layout, and no length is negative.
        unsafe { std::slice::from_raw_parts(self.shape.as_ptr().cast(), self.shape.len()) }
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
    /// It is not a plain list of plain arrays or numbers.
    NotPlain,
    /// The element of this index has `found` coordinates, those before it `expected`.
    Dimension { index: usize, found: usize, expected: usize },
}

/// Points on their way from Python's objects into one array.
#[derive(Default)]
pub(crate) struct Packed {
    /// The coordinates, point by point.
    pub(crate) values: Vec<f64>,
    /// The number of coordinates of every point, set by the first.
    pub(crate) dimension: Option<usize>,
}

impl Packed {
    /// Appends a set of points: an array whose rows are points, or a list or tuple of points.
    #[inline]
    pub(crate) fn append_set(&mut self, set: &Bound<'_, PyAny>) -> Result<usize, Unpacked> {
        if let Ok(list) = set.cast_exact::<PyList>() {
            self.append_points(list.iter())
        } else if let Ok(tuple) = set.cast_exact::<PyTuple>() {
            self.append_points(tuple.iter())
        } else {
            self.append_rows(&Array::borrow(set.as_borrowed()).ok_or(Unpacked::NotPlain)?)
        }
    }

    fn append_points<'py>(
        &mut self,
        points: impl ExactSizeIterator<Item = Bound<'py, PyAny>>,
    ) -> Result<usize, Unpacked> {
        let count = points.len();
        self.values.reserve(count * self.dimension.unwrap_or(2));
        for (index, point) in points.enumerate() {
            let before = self.values.len();
            append_point(&point, &mut self.values)?;
            self.check_dimension(index, self.values.len() - before)?;
        }
        Ok(count)
    }

    fn append_rows(&mut self, rows: &Array<'_>) -> Result<usize, Unpacked> {
        let (&count, row) = rows.shape().split_first().ok_or(Unpacked::NotPlain)?;
        if count > 0 {
            self.check_dimension(0, row.iter().product::<isize>() as usize)?;
            rows.append_to(&mut self.values);
        }
        Ok(count as usize)
    }

    #[inline]
    fn check_dimension(&mut self, index: usize, found: usize) -> Result<(), Unpacked> {
        let expected = *self.dimension.get_or_insert(found);
        if found == 0 {
            Err(Unpacked::NotPlain)
        } else if found != expected {
            Err(Unpacked::Dimension { index, found, expected })
        } else {
            Ok(())
        }
    }
}

/// Appends the coordinates of one point: an array, a list or tuple of numbers, or a number.
#[inline]
fn append_point(point: &Bound<'_, PyAny>, values: &mut Vec<f64>) -> Result<(), Unpacked> {
    if let Some(array) = Array::borrow(point.as_borrowed()) {
        array.append_to(values);
        Ok(())
    } else if let Ok(list) = point.cast_exact::<PyList>() {
        list.iter().try_for_each(|number| append_number(&number, values))
    } else if let Ok(tuple) = point.cast_exact::<PyTuple>() {
        tuple.iter().try_for_each(|number| append_number(&number, values))
    } else {
        append_number(point, values)
    }
}

#[inline]
fn append_number(number: &Bound<'_, PyAny>, values: &mut Vec<f64>) -> Result<(), Unpacked> {
    if let Ok(float) = number.cast::<PyFloat>() {
        values.push(float.value());
    } else if let Ok(integer) = number.cast_exact::<PyInt>() {
        values.push(integer.extract::<i64>().map_err(|_| Unpacked::NotPlain)? as f64);
    } else {
        return Err(Unpacked::NotPlain);
    }
    Ok(())
}
