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
