"""Turns what users hold into what kernels take.

Only the *form* is settled here: lists of lists, tuples, integers, float32, views that are not
contiguous become C-ordered float64 arrays. What is wrong with the *values* the kernels say.
"""

import math
import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._covariance_rule import SYMMETRY, SYMMETRY_SINGLE
from trackmetrics._tables.errors import value as shortened

Floats = NDArray[np.float64]


def floats(argument: str, values: Any) -> Floats:
    """``values`` as a C-ordered float64 array of any shape."""
    found = array(argument, values)
    if found.dtype.kind not in "biuf":
        raise TypeError(f"{argument} must hold real numbers, got dtype {found.dtype}")
    return plain(found, np.float64)


def array(argument: str, values: Any) -> NDArray[Any]:
    """``values`` as an array of NumPy's own class, of any kind; what is masked has no value."""
    refuse_masked(argument, values)
    try:
        return np.asarray(values)
    except ValueError:
        raise ValueError(f"{argument} is ragged: expected an array of numbers") from None
    except (TypeError, NotImplementedError, BufferError) as error:
        raise TypeError(f"{argument} cannot be read as an array: {error}") from None


def refuse_masked(argument: str, values: Any, index: tuple[int, ...] = ()) -> None:
    """Refuse a masked element, also in lists: NumPy would take the number below the mask."""
    if isinstance(values, np.ma.MaskedArray):
        mask = np.ma.getmaskarray(values)
        if mask.dtype == bool and mask.any():
            where = errors.format_index((*index, *map(int, np.argwhere(mask)[0])))
            raise ValueError(f"{argument}{where} is masked: leave out what has no value")
    elif isinstance(values, list | tuple):
        for i, value in enumerate(values):
            if isinstance(value, list | tuple | np.ma.MaskedArray):
                refuse_masked(argument, value, (*index, i))


def plain(values: NDArray[Any], dtype: Any) -> NDArray[Any]:
    """The form that kernels borrow: C-ordered, aligned and in the machine's byte order."""
    ordered = np.asarray(values, dtype=dtype, order="C")
    aligned = ordered if ordered.flags.aligned else ordered.copy()
    # An unpickled array has a type object of its own; a view has NumPy's, which kernels look for.
    return aligned if aligned.dtype is np.dtype(dtype) else aligned.view(dtype)


def integers(argument: str, values: Any) -> NDArray[np.int64]:
    """``values`` as a C-ordered int64 array of any shape."""
    found = array(argument, values)
    if found.size and found.dtype.kind not in "iu":
        raise TypeError(f"{argument} must hold whole numbers, got dtype {found.dtype}")
    return plain(found, np.int64)


def opened(values: Any) -> Any:
    """An array in place of an object that says how it is read as one; anything else as it is."""
    ways = ("__array__", "__array_interface__", "__array_struct__")
    if isinstance(values, np.ndarray | np.generic) or not (
        isinstance(values, memoryview) or any(hasattr(values, way) for way in ways)
    ):
        return values
    return np.asarray(values)


def cost_matrix(values: Any) -> Floats:
    """``values`` as a C-ordered float64 matrix, by SciPy's rules: an array is cast where that is
    safe, anything else is read as numbers.
    """
    refuse_masked("cost_matrix", values)
    if isinstance(values, np.ndarray):
        costs = np.asarray(values).astype(np.float64, order="C", casting="safe", copy=False)
    else:
        costs = np.asarray(values, dtype=np.float64, order="C")
    if costs.ndim != 2:
        raise errors.not_a_matrix(costs.ndim)
    return plain(costs, np.float64)


def matrix(argument: str, values: Any) -> Floats:
    """``values`` as a C-ordered float64 matrix."""
    found = floats(argument, values)
    if found.ndim != 2:
        raise errors.shape(argument, found.shape, "(m, n)")
    return found


def cost_matrices(values: Any) -> Floats | list[Floats]:
    """Cost matrices as one C-ordered array where they come as an array, else as a list."""
    refuse_masked("costs", values)
    if not isinstance(values, np.ndarray):
        return [_numbered(index, value) for index, value in enumerate(values)]
    costs = np.asarray(values).astype(np.float64, order="C", casting="safe", copy=False)
    if costs.ndim != 3:
        raise errors.shape("costs", costs.shape, "(B, n, m)")
    return plain(costs, np.float64)


def _numbered(index: int, value: Any) -> Floats:
    try:
        return cost_matrix(value)
    except (TypeError, ValueError) as error:
        raise errors.in_matrix(index, error) from None


def points(argument: str, values: Any, dimension: int | None = None) -> Floats:
    """A set of points as an ``(n, d)`` array; each point is flattened.

    Takes a list or tuple of points, each a number, a list or an array of any shape, or an array
    whose rows are points. A one-dimensional array is a set of numbers. ``dimension`` is what the
    points must have, where that is settled already.
    """
    values = opened(values)
    if isinstance(values, np.ndarray):
        rows = floats(argument, values)
        if rows.ndim == 0:
            raise errors.shape(argument, rows.shape, "(n, d)")
    else:
        rows = _stack(argument, values, dimension)
    if len(rows) == 0:
        return np.empty((0, dimension or 0))
    found = rows[0].size
    if found != (dimension or found):
        raise errors.dimension(argument, [0], found, dimension or found)
    if found == 0:
        raise ValueError(f"{argument}[0] has no coordinates")
    return rows.reshape(len(rows), found)


def _stack(argument: str, values: Any, dimension: int | None) -> Floats:
    """A list of points, one after the other, so that the first offender is the one named."""
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise TypeError(
            f"{argument} must be a list, tuple or array of points, got {type(values).__name__}"
        )
    rows: list[Floats] = []
    for i, value in enumerate(values):
        row = floats(f"{argument}[{i}]", value).ravel()
        dimension = row.size if dimension is None else dimension
        if row.size != dimension:
            raise errors.dimension(argument, [i], row.size, dimension)
        rows.append(row)
    return np.stack(rows) if rows else np.empty((0, 0))


def frames(argument: str, values: Any) -> tuple[Floats, NDArray[np.int64]]:
    """A sequence of point sets, packed: ``(N, d)`` points and the ``(T + 1,)`` starts of the sets.

    Takes a list or tuple of sets (see ``points``), an array of shape ``(T, n, d)`` or ``(T, n)``,
    or the packed form itself: a tuple of a two-dimensional array and a one-dimensional array of
    integers.
    """
    values = opened(values)
    if _is_packed(values):
        return points(argument, values[0]), integers(argument, values[1])
    if isinstance(values, np.ndarray):
        values = array(argument, values)
    if isinstance(values, np.ndarray) and values.ndim < 2:
        raise errors.shape(argument, values.shape, "(T, n, d)")
    if not isinstance(values, Sequence | np.ndarray) or isinstance(values, str):
        raise TypeError(
            f"{argument} must be a list, tuple or array of sets of points, "
            f"got {type(values).__name__}"
        )
    sets: list[Floats] = []
    dimension: int | None = None
    for t, value in enumerate(values):
        sets.append(points(f"{argument}[{t}]", value, dimension))
        if dimension is None and len(sets[-1]):
            dimension = sets[-1].shape[1]
    packed = [points for points in sets if len(points)]
    starts = np.cumsum([0, *map(len, sets)], dtype=np.int64)
    return np.concatenate(packed) if packed else np.empty((0, 0)), starts


def _is_packed(values: Any) -> bool:
    return (
        isinstance(values, tuple)
        and len(values) == 2
        and all(isinstance(part, np.ndarray) for part in values)
        and (values[0].ndim, values[1].ndim) == (2, 1)
        and values[1].dtype.kind in "iu"
    )


def states(covariance: tuple[str, Any], *vectors: tuple[str, Any]) -> tuple[Any, ...]:
    """Vectors ``(..., d)``, their covariances ``(..., d, d)``, and the asymmetry these may have.

    A number is a vector of one component, and ``(d, 1)`` a column vector. Where the covariance
    says so by its size, single precision is granted the asymmetry that its rounding leaves.
    """
    name, values = covariance
    symmetry = _symmetry(values)
    matrices = floats(name, values)
    matrices = matrices.reshape(1, 1) if matrices.ndim == 0 else matrices
    if matrices.ndim == 1:
        raise errors.shape(name, matrices.shape, "(..., d, d)")
    return *(_vectors(*vector, matrices) for vector in vectors), matrices, symmetry


def _vectors(argument: str, values: Any, matrices: Floats) -> Floats:
    array = floats(argument, values)
    if array.ndim == 0:
        return array.reshape(1)
    d = matrices.shape[-1]
    if array.ndim > 1 and array.shape[-1] == 1 and d != 1:
        if array.shape[-2] != d:
            raise errors.shape(argument, array.shape, f"(..., {d})")
        return array[..., 0]
    return array


def _symmetry(covariances: Any) -> float:
    dtype = getattr(covariances, "dtype", None)
    return SYMMETRY_SINGLE if dtype in (np.float32, np.float16) else SYMMETRY


def periods(angles: Mapping[int, float] | None, covariance: Any) -> Floats | None:
    """The period of every component, 0 for one that is not an angle."""
    if angles is None:
        return None
    if not isinstance(angles, Mapping):
        raise TypeError(
            "angles must map indices of components to periods, as in {2: 360.0}, "
            f"got {_form(angles)}"
        )
    d = (array("covariance", covariance).shape or (1,))[-1]
    found = np.zeros(d)
    for place, (key, value) in enumerate(angles.items()):
        index = whole("an index in angles", key)
        period = number(f"angles[{index}]", value)
        if not -d <= index < d:
            raise errors.index_out_of_range("angles", place, index, d)
        if not 0 < period < math.inf:
            raise errors.element("angles", [index], "positive and finite", period)
        found[index] = period
    return found


def nan_where_invalid(on_invalid: str) -> bool:
    """What ``on_invalid`` asks for."""
    if on_invalid not in ("raise", "nan"):
        raise ValueError(f"on_invalid must be 'raise' or 'nan', got {shortened(on_invalid)}")
    return on_invalid == "nan"


def number(argument: str, value: Any) -> float:
    """A real number as a float; a word that reads as one is none."""
    refuse_masked(argument, value)
    if isinstance(value, np.ndarray | np.generic):
        readable = value.ndim == 0 and value.dtype.kind in "biuf"
    else:
        readable = not isinstance(value, str | bytes)
    try:
        if readable:
            return float(value)
    except OverflowError:
        raise ValueError(f"{argument} is too large for a float64") from None
    except TypeError:
        pass
    raise TypeError(f"{argument} must be a real number, got {_form(value)}")


def numbers(**values: Any) -> list[float]:
    """Each value as a float, named by its argument."""
    return [number(argument, value) for argument, value in values.items()]


def whole(argument: str, value: Any) -> int:
    """A whole number as an int."""
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{argument} must be a whole number, got {_form(value)}") from None
    if not -(2**63) <= found < 2**63:
        raise ValueError(f"{argument} is too large for an int64")
    return found


def count(argument: str, value: Any, least: int) -> None:
    """Refuse what is no whole number, or less than ``least``."""
    try:
        fits = value == int(value) and value >= least
    except (TypeError, ValueError, OverflowError):
        fits = False
    if not fits:
        raise ValueError(
            f"{argument} must be a whole number, at least {least}, got {shortened(value)}"
        )


def _form(value: Any) -> str:
    """What came, in a few words."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and dtype {value.dtype}"
    return shortened(value) if isinstance(value, str | None | complex) else type(value).__name__


def fraction(argument: str, value: Any) -> None:
    """Refuse what is not between 0 and 1, both excluded."""
    if not 0 < number(argument, value) < 1:
        raise errors.parameter(argument, "between 0 and 1, both excluded", value)


def indices(argument: str, values: Any, length: int) -> list[int]:
    """Indices of components, from a number, a slice, a mask or a sequence of numbers."""
    if isinstance(values, slice):
        return list(range(length))[values]
    found = np.atleast_1d(array(argument, values))
    if found.dtype.kind == "b" and found.shape == (length,):
        return [int(i) for i in np.flatnonzero(found)]
    if (found.size and found.dtype.kind not in "iu") or found.ndim != 1:
        raise TypeError(f"{argument} must be a list of whole numbers, got {_form(values)}")
    return [int(i) for i in found]


def axes(axis: Any) -> list[int] | None:
    """The axes that NumPy would understand by ``axis``."""
    if axis is None:
        return None
    if isinstance(axis, Sequence) and not isinstance(axis, str):
        return [whole("axis", one) for one in axis]
    return [whole("axis", axis)]


def axis_of(array: Floats, axis: Any) -> int:
    """An axis that the array has."""
    found = whole("axis", axis)
    if not -array.ndim <= found < array.ndim:
        raise errors.axis_out_of_range(found, array.ndim)
    return found
