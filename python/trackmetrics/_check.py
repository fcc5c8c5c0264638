"""Turns what users hold into what kernels take.

Only the *form* is settled here: lists of lists, tuples, integers, float32, views that are not
contiguous become C-ordered float64 arrays. What is wrong with the *values* the kernels say.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors

Floats = NDArray[np.float64]
Packed = tuple[Floats, NDArray[np.int64]]


def floats(argument: str, values: Any) -> Floats:
    """``values`` as a C-ordered float64 array of any shape."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{argument} is ragged: expected an array of numbers") from None
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{argument} must hold real numbers, got dtype {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)


def cost_matrix(values: Any) -> Floats:
    """``values`` as a C-ordered float64 matrix, by SciPy's rules: an array is cast where that is
    safe, anything else is read as numbers.
    """
    if isinstance(values, np.ndarray):
        array = np.asarray(values).astype(np.float64, order="C", casting="safe", copy=False)
    else:
        array = np.asarray(values, dtype=np.float64, order="C")
    if array.ndim != 2:
        raise errors.not_a_matrix(array.ndim)
    return array


def points(argument: str, values: Any) -> Floats:
    """A set of points as an ``(n, d)`` array; each point is flattened.

    Takes a list or tuple of points, each a number, a list or an array of any shape, or an array
    whose rows are points. A one-dimensional array is a set of numbers.
    """
    if isinstance(values, np.ndarray):
        array = floats(argument, values)
        if array.ndim == 0:
            raise errors.shape(argument, array.shape, "(n, d)")
        return array.reshape(len(array), -1) if array.size else array.reshape(len(array), 0)
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise TypeError(
            f"{argument} must be a list, tuple or array of points, got {type(values).__name__}"
        )
    rows = [floats(f"{argument}[{i}]", value).ravel() for i, value in enumerate(values)]
    for i, row in enumerate(rows):
        if row.size != rows[0].size:
            raise errors.dimension(argument, [i], row.size, rows[0].size)
    return np.stack(rows) if rows else np.empty((0, 0))


def frames(argument: str, values: Any) -> Packed:
    """A sequence of point sets as all points ``(N, d)`` and their offsets ``(T + 1,)``.

    Takes a list or tuple of what `points` takes, an array ``(T, n, d)`` whose points are flattened,
    an array ``(T, n)`` of numbers, or a tuple of points and offsets.
    """
    if isinstance(values, np.ndarray):
        return _cube(argument, values)
    if _is_packed(values):
        return points(argument, values[0]), np.ascontiguousarray(values[1], dtype=np.int64)
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise TypeError(
            f"{argument} must be a list, tuple or array of frames, got {type(values).__name__}"
        )
    sets = [points(f"{argument}[{t}]", value) for t, value in enumerate(values)]
    full = [t for t, rows in enumerate(sets) if len(rows)]
    for t in full:
        if sets[t].shape[1] != sets[full[0]].shape[1]:
            raise errors.dimension(argument, [t, 0], sets[t].shape[1], sets[full[0]].shape[1])
    starts = np.cumsum([0, *map(len, sets)], dtype=np.int64)
    return _with_coordinates(
        argument, np.concatenate([sets[t] for t in full]) if full else np.empty((0, 0)), starts
    )


def _cube(argument: str, values: NDArray[Any]) -> Packed:
    array = floats(argument, values)
    if array.ndim < 2:
        raise errors.shape(argument, array.shape, "(T, n, d)")
    count, n = array.shape[:2]
    size = array[0, 0].size if count and n else 0
    return _with_coordinates(
        argument, array.reshape(count * n, size), np.arange(count + 1, dtype=np.int64) * n
    )


def _is_packed(values: Any) -> bool:
    if not (isinstance(values, tuple) and len(values) == 2):
        return False
    if not all(isinstance(part, np.ndarray) for part in values):
        return False
    rows, starts = values
    return rows.ndim == 2 and starts.ndim == 1 and starts.dtype.kind in "iu"


def _with_coordinates(argument: str, rows: Floats, starts: NDArray[np.int64]) -> Packed:
    if len(rows) and not rows.shape[1]:
        raise ValueError(f"{argument} has points without coordinates")
    return rows, starts
