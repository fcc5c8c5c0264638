"""Argument checks that every reference shares; the Rust core does the same where it borrows."""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors

Floats = NDArray[np.float64]
Frames = tuple[Floats, NDArray[np.int64]]


def plain(*arrays: Any) -> None:
    """Refuse what is not a C-ordered float64 array: the public function converts it."""
    for array in arrays:
        if (
            type(array) is not np.ndarray
            or array.dtype != np.float64
            or not array.flags.c_contiguous
        ):
            raise errors.NotPlain


def finite(argument: str, points: Floats) -> None:
    """Refuse a point with a coordinate that is NaN or infinite."""
    if not np.isfinite(points).all():
        i, k = np.argwhere(~np.isfinite(points))[0]
        raise errors.not_finite(argument, [i], points[i, k])


def positive(argument: str, value: float) -> None:
    """Refuse NaN and what is not above zero."""
    if not value > 0:
        raise errors.parameter(argument, "positive", value)


def plain_ids(*arrays: Any) -> None:
    """Refuse what is not a C-ordered int64 array of one axis."""
    for array in arrays:
        if (
            type(array) is not np.ndarray
            or array.dtype != np.int64
            or array.ndim != 1
            or not array.flags.c_contiguous
        ):
            raise errors.NotPlain


def plain_numbers(*values: Any) -> None:
    """Refuse what is not a float: the public function converts it."""
    if not all(isinstance(value, float) for value in values):
        raise errors.NotPlain


def plain_points(*arrays: Any) -> None:
    """Refuse what is not a plain ``(n, d)`` array; points have coordinates."""
    plain(*arrays)
    if any(array.ndim != 2 or (len(array) and not array.size) for array in arrays):
        raise errors.NotPlain


def frames(argument: str, packed: Frames) -> list[Floats]:
    """The point sets of a packed sequence: checked, and cut apart."""
    if type(packed) is not tuple or len(packed) != 2:
        raise errors.NotPlain
    points, starts = packed
    plain_points(points)
    plain_ids(starts)
    n = len(points)
    if not (len(starts) and starts[0] == 0 and starts[-1] == n and (np.diff(starts) >= 0).all()):
        raise errors.offsets(argument, n)
    if not np.isfinite(points).all():
        i, k = np.argwhere(~np.isfinite(points))[0]
        t = int(np.searchsorted(starts, i, side="right")) - 1
        raise errors.not_finite(argument, [t, int(i - starts[t])], points[i, k])
    return [points[a:b] for a, b in pairwise(starts)]
