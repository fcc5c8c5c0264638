//! Reading NumPy arrays, and lists of small ones, without copying through NumPy.
//!
//! The documented API takes lists of small arrays. Packing such a list through NumPy costs hundreds
//! of nanoseconds an element; walking it and reading each array's fields costs about five. What is
//! not an exact `ndarray` of native `float64` or `int64` is left to the public function, which has NumPy
//! convert it.
//!
//! This is the only file of the crate with `unsafe` code. All of it rests on two facts: the
//! interpreter is attached (a [`Bound`] proves it), so that no Python code runs while a field is
//! read; and the layout of an exact `ndarray` is part of NumPy's ABI.

#![allow(unsafe_code)]

use numpy::npyffi::{self, PyArrayObject};
use numpy::{Element, PyUntypedArray};
use pyo3::PyTypeInfo;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple, PyType};

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
        let types = Types::get(object.py());
        let pointer = object.as_ptr();
        // SAFETY: `pointer` is a live object and the interpreter is attached.
        if unsafe { pyo3::ffi::Py_TYPE(pointer) }.cast_const() != types.array {
            return None;
        }
        // SAFETY: an exact ndarray starts with the fields of `PyArrayObject`; they are written by
        // NumPy only, under the interpreter, which is attached for the lifetime of `object`.
        let fields = unsafe { &(*pointer.cast::<PyArrayObject>()).fields };
        let plain = npyffi::NPY_ARRAY_C_CONTIGUOUS | npyffi::NPY_ARRAY_ALIGNED;
        if fields.flags & plain != plain {
            return None;
        }
        let kind = types.kind(fields.descr.cast())?;
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
            // Lengths known to the compiler spare a call of memcpy, which is half the time.
            Kind::Float64 => match self.floats().unwrap_or_default() {
                &[a, b] => values.extend_from_slice(&[a, b]),
                &[a, b, c] => values.extend_from_slice(&[a, b, c]),
                floats => values.extend_from_slice(floats),
            },
            Kind::Int64 => {
                values.extend(self.integers().unwrap_or_default().iter().map(|&i| i as f64));
            }
        }
    }
}

/// The objects by which plain arrays are known: comparisons of pointers, since NumPy has one object
/// for its array type and one for each native number type.
struct Types {
    array: *const pyo3::ffi::PyTypeObject,
    float64: *const pyo3::ffi::PyObject,
    int64: *const pyo3::ffi::PyObject,
}

// SAFETY: the pointers are compared and never followed.
unsafe impl Send for Types {}
// SAFETY: as above.
unsafe impl Sync for Types {}

impl Types {
    #[inline]
    fn get(py: Python<'_>) -> &'static Self {
        static TYPES: PyOnceLock<Types> = PyOnceLock::new();
        TYPES.get_or_init(py, || Self {
            array: PyUntypedArray::type_object_raw(py),
            // NumPy keeps its descriptors of native types for ever.
            float64: f64::get_dtype(py).as_ptr(),
            int64: i64::get_dtype(py).as_ptr(),
        })
    }

    #[inline]
    fn kind(&self, descr: *const pyo3::ffi::PyObject) -> Option<Kind> {
        if descr == self.float64 {
            Some(Kind::Float64)
        } else if descr == self.int64 {
            Some(Kind::Int64)
        } else {
            None
        }
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
    pub(crate) fn append_set(&mut self, set: Borrowed<'_, '_, PyAny>) -> Result<usize, Unpacked> {
        match Items::of(set) {
            Some(points) => self.append_points(points),
            None => self.append_rows(&Array::borrow(set).ok_or(Unpacked::NotPlain)?),
        }
    }

    #[inline]
    fn append_points(&mut self, points: Items<'_, '_>) -> Result<usize, Unpacked> {
        let count = points.len();
        self.values.reserve(count * self.dimension.unwrap_or(2));
        for (index, point) in points.enumerate() {
            let before = self.values.len();
            append_point(point, &mut self.values)?;
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
fn append_point(point: Borrowed<'_, '_, PyAny>, values: &mut Vec<f64>) -> Result<(), Unpacked> {
    if let Some(array) = Array::borrow(point) {
        array.append_to(values);
        Ok(())
    } else if let Some(mut numbers) = Items::of(point) {
        numbers.try_for_each(|number| append_number(number, values))
    } else {
        append_number(point, values)
    }
}

#[inline]
fn append_number(number: Borrowed<'_, '_, PyAny>, values: &mut Vec<f64>) -> Result<(), Unpacked> {
    if let Ok(float) = number.cast::<PyFloat>() {
        values.push(float.value());
    } else if let Ok(integer) = number.cast_exact::<PyInt>() {
        values.push(integer.extract::<i64>().map_err(|_| Unpacked::NotPlain)? as f64);
    } else {
        return Err(Unpacked::NotPlain);
    }
    Ok(())
}

/// The items of an exact list or tuple, borrowed: nothing that runs between two of them may call
/// Python, and nothing here does.
pub(crate) struct Items<'a, 'py> {
    object: Borrowed<'a, 'py, PyAny>,
    is_list: bool,
    next: usize,
    end: usize,
}

impl<'a, 'py> Items<'a, 'py> {
    /// The items of `object`, where it is a list or a tuple.
    #[inline]
    pub(crate) fn of(object: Borrowed<'a, 'py, PyAny>) -> Option<Self> {
        let list = object.cast_exact::<PyList>().map(|list| list.len());
        let is_list = list.is_ok();
        let end = list.or_else(|_| object.cast_exact::<PyTuple>().map(|tuple| tuple.len())).ok()?;
        Some(Self { object, is_list, next: 0, end })
    }
}

impl<'a, 'py> Iterator for Items<'a, 'py> {
    type Item = Borrowed<'a, 'py, PyAny>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.end {
            return None;
        }
        let (pointer, index) = (self.object.as_ptr(), self.next as isize);
        self.next += 1;
        // SAFETY: the object is a live list or tuple, as `is_list` says; both functions check the
        // index. The reference that they lend holds as long as the container is not changed, and
        // only Python code, which does not run here, could change it.
        unsafe {
            let item = if self.is_list {
                pyo3::ffi::PyList_GetItem(pointer, index)
            } else {
                pyo3::ffi::PyTuple_GetItem(pointer, index)
            };
            Borrowed::from_ptr_or_opt(self.object.py(), item)
        }
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.end - self.next, Some(self.end - self.next))
    }
}

impl ExactSizeIterator for Items<'_, '_> {}

/// A named tuple of floats: the class's own `__new__` takes longer than a small kernel.
///
/// `class` must be a subclass of `tuple` that adds nothing to an object's layout, as named tuples
/// are; anything else is a `TypeError`.
pub(crate) fn named_tuple<'py>(
    class: &Bound<'py, PyType>,
    values: [f64; 3],
) -> PyResult<Bound<'py, PyAny>> {
    let py = class.py();
    if !class.is_subclass_of::<PyTuple>()? {
        return Err(PyTypeError::new_err("expected a named tuple"));
    }
    let class = class.as_type_ptr();
    // SAFETY: `class` is a live type, checked to be a tuple's, and so has this slot; it makes an
    // object of three empty places, which no one else knows of yet. `PyTuple_SetItem` checks the
    // object and the index, and takes over each float.
    unsafe {
        let slot = pyo3::ffi::PyType_GetSlot(class, pyo3::ffi::Py_tp_alloc);
        let alloc = std::mem::transmute::<*mut std::ffi::c_void, pyo3::ffi::allocfunc>(slot);
        let tuple = Bound::from_owned_ptr_or_err(py, alloc(class, values.len() as isize))?;
        for (index, value) in values.into_iter().enumerate() {
            let value = PyFloat::new(py, value).into_ptr();
            if pyo3::ffi::PyTuple_SetItem(tuple.as_ptr(), index as isize, value) != 0 {
                return Err(PyErr::fetch(py));
            }
        }
        Ok(tuple)
    }
}
