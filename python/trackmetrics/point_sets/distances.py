"""What may stand for the distance between two points, besides the Euclidean one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain


@dataclass(frozen=True, eq=False)
class Mahalanobis:
    """Distance in standard deviations: ``sqrt((y - x)' P^-1 (y - x))``.

    With one covariance of shape (d, d) it is a metric; with one for each point of X, shape
    (n, d, d), the triangle inequality fails, and what is computed with it is a score.

    Examples
    --------
    >>> import trackmetrics
    >>> P = [[4.0, 0.0], [0.0, 9.0]]
    >>> trackmetrics.ospa([[0, 0]], [[2, 0]], c=5, distance=trackmetrics.Mahalanobis(P)).ospa
    1.0
    """

    covariances: Any
    """One covariance (d, d), or one for each point of X (n, d, d); unit: squares of the points'."""


Distance = (
    Literal["euclidean", "manhattan", "haversine"] | Mahalanobis | Callable[[Any, Any], float]
)
NAMES = ("euclidean", "manhattan", "haversine")


def distances(X: Any, Y: Any, distance: Distance) -> NDArray[np.float64]:
    """The matrix of distances between the points of X and those of Y."""
    if isinstance(distance, Mahalanobis):
        return _mahalanobis(X, Y, distance)
    if callable(distance):
        return _called(X, Y, distance)
    if distance not in NAMES:
        raise ValueError(
            f"distance must be one of {', '.join(map(repr, NAMES))}, a Mahalanobis or a callable, "
            f"got {distance!r}"
        )
    kernel = _backend.kernels.point_distances
    try:
        matrix: NDArray[np.float64] = kernel(X, Y, distance)
    except NotPlain:
        matrix = kernel(_check.points("X", X), _check.points("Y", Y), distance)
    return matrix


def _mahalanobis(X: Any, Y: Any, distance: Mahalanobis) -> NDArray[np.float64]:
    covariances = _check.floats("covariances", distance.covariances)
    if covariances.ndim == 2:
        covariances = covariances[None]
    x, y = _check.points("X", X), _check.points("Y", Y)
    if covariances.ndim != 3:
        raise ValueError(
            f"covariances has shape {covariances.shape}, "
            "expected (d, d) or one such for each point of X"
        )
    matrix: NDArray[np.float64] = _backend.kernels.mahalanobis_distances(x, y, covariances)
    return matrix


def _called(X: Any, Y: Any, distance: Callable[[Any, Any], float]) -> NDArray[np.float64]:
    rows = [[float(distance(x, y)) for y in Y] for x in X]
    return np.array(rows, dtype=np.float64).reshape(len(X), len(Y))
