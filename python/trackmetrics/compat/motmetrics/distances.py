"""Distances between the objects and hypotheses of a frame; NaN is a pair that may not be."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.compat.motmetrics.math_util import quiet_divide

Floats = NDArray[np.float64]


def norm2squared_matrix(objs: Any, hyps: Any, max_d2: float = float("inf")) -> Floats:
    """Squared Euclidean distance of every pair, shape (N, K), 0 at best.

    Parameters
    ----------
    objs, hyps : array_like of shape (N, M) and (K, M)
        Points in rows, in any unit.
    max_d2 : float
        Larger squared distances become NaN.

    Raises
    ------
    AssertionError
        Where the points differ in dimension (py-motmetrics' type of error).
    """
    points = np.atleast_2d(np.asarray(objs, dtype=np.float64))
    others = np.atleast_2d(np.asarray(hyps, dtype=np.float64))
    if points.size == 0 or others.size == 0:
        return np.empty((0, 0))
    if points.shape[1] != others.shape[1]:
        raise AssertionError(
            f"objs has points of dimension {points.shape[1]}, hyps of {others.shape[1]}"
        )
    squared: Floats = np.square(points[:, None] - others[None]).sum(axis=-1)
    squared[squared > max_d2] = np.nan
    return squared


def rect_min_max(r: Any) -> tuple[Any, Any]:
    """Lowest and highest corner of boxes (x, y, width, height) along the last axis."""
    low, size = r[..., :2], r[..., 2:]
    return low, low + size


def boxiou(a: Any, b: Any) -> Floats:
    """Intersection over union of boxes (x, y, width, height) in [0, 1], 1 at best.

    The axes before the last are broadcast against each other.
    """
    (low, high), (other_low, other_high) = rect_min_max(a), rect_min_max(b)
    shared = _volume(np.maximum(low, other_low), np.minimum(high, other_high))
    union = _volume(low, high) + _volume(other_low, other_high) - shared
    iou: Floats = np.where(shared == 0, 0.0, quiet_divide(shared, union))
    return iou


def _volume(low: Any, high: Any) -> Any:
    return np.prod(np.maximum(high - low, 0), axis=-1)


def iou_matrix(objs: Any, hyps: Any, max_iou: float = 1.0) -> Floats:
    """One minus the intersection over union of every pair of boxes, shape (N, K), 0 at best.

    Parameters
    ----------
    objs, hyps : array_like of shape (N, 4) and (K, 4)
        Boxes (x, y, width, height) in rows, in any unit.
    max_iou : float
        Larger distances become NaN.

    Raises
    ------
    AssertionError
        Where a side does not have four columns (py-motmetrics' type of error).
    """
    if np.size(objs) == 0 or np.size(hyps) == 0:
        return np.empty((0, 0))
    boxes, others = np.asarray(objs, dtype=np.float64), np.asarray(hyps, dtype=np.float64)
    for name, array in (("objs", boxes), ("hyps", others)):
        if array.ndim != 2 or array.shape[1] != 4:
            raise AssertionError(f"{name} must have shape (N, 4), got {array.shape}")
    distances = 1 - boxiou(boxes[:, None], others[None])
    return np.where(distances > max_iou, np.nan, distances)
