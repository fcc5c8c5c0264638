"""Matrices of distances between two sets: reference of ``point_sets::distances`` in the core."""

import numpy as np

from trackmetrics import errors
from trackmetrics._covariance_rule import SYMMETRY
from trackmetrics._numpy.arguments import Floats, finite, plain, plain_points

EARTH_RADIUS = 6_371_008.8
LARGEST = 1 << 24
"""Most pairs of points that the reference takes: it computes the matrix of all of them."""


def squares(x: Floats, y: Floats) -> Floats:
    """Squared Euclidean distances, axis after axis as in the core."""
    if len(x) * len(y) > LARGEST:
        raise errors.too_many_pairs(len(x) * len(y), 8 * len(x) * len(y))
    sums = np.zeros((len(x), len(y)))
    if sums.size:
        with np.errstate(over="ignore", under="ignore"):
            for a, b in zip(x.T, y.T, strict=True):
                sums += (a[:, None] - b) ** 2
    return sums


def euclidean(x: Floats, y: Floats) -> Floats:
    """Euclidean distances, at any scale."""
    sums = squares(x, y)
    if ((sums > 1e-280) & (sums < 1e280)).all():
        return np.sqrt(sums)
    # In units of the largest component: no square leaves the range of floats.
    with np.errstate(over="ignore", under="ignore"):
        differences = np.abs(x[:, None] - y[None])
        largest = differences.max(axis=-1)
        unit = np.where((largest > 0) & (largest < np.inf), largest, 1.0)
        scaled = unit * np.sqrt(((differences / unit[..., None]) ** 2).sum(-1))
        return np.where((sums > 1e-280) & (sums < 1e280), np.sqrt(sums), scaled)


def point_distances(x: Floats, y: Floats, metric: str) -> Floats:
    """Distances between all pairs of points by "manhattan" or "haversine"."""
    if metric not in ("manhattan", "haversine"):
        raise ValueError("metric must be 'manhattan' or 'haversine'")
    _check_points(x, y)
    if metric == "haversine":
        _require_dimension(x, y, 2)
        return _haversine(x, y) if len(x) and len(y) else np.empty((len(x), len(y)))
    same_dimension(x, y)
    if not len(x) or not len(y):
        return np.empty((len(x), len(y)))
    distances: Floats = np.abs(x[:, None] - y[None]).sum(-1)
    return distances


def _haversine(x: Floats, y: Floats) -> Floats:
    """Great-circle distances in metres of (latitude, longitude) in degrees."""
    half = np.sin(np.radians(y[None] - x[:, None]) / 2)
    parallel = np.cos(np.radians(x[:, None, 0])) * np.cos(np.radians(y[None, :, 0]))
    h = np.clip(half[..., 0] ** 2 + parallel * half[..., 1] ** 2, 0.0, 1.0)
    distances: Floats = 2 * EARTH_RADIUS * np.arcsin(np.sqrt(h))
    return distances


def mahalanobis_distances(x: Floats, y: Floats, covariances: Floats) -> Floats:
    """Mahalanobis distances between all pairs of points."""
    plain(covariances)
    if covariances.ndim != 3:
        raise errors.NotPlain
    _check_points(x, y)
    count, d, columns = covariances.shape
    if columns != d or d == 0 or count not in (1, len(x)):
        raise errors.shape(
            "covariances", covariances.shape, "(d, d) or one such for each point of X"
        )
    _require_dimension(x, y, d)
    factors = [_factor(p, [] if count == 1 else [k]) for k, p in enumerate(covariances)]
    distances = np.empty((len(x), len(y)))
    for i, point in enumerate(x if len(y) else []):
        whitened = np.linalg.solve(factors[0 if count == 1 else i], (y - point).T)
        distances[i] = np.sqrt((whitened**2).sum(0))
    return distances


def _factor(p: Floats, index: list[int]) -> Floats:
    """The lower triangular L with L L' = P."""
    if not np.isfinite(p).all():
        i, j = np.argwhere(~np.isfinite(p))[0]
        raise errors.not_finite("covariances", [*index, int(i), int(j)], p[i, j])
    lower = np.zeros_like(p)
    for i in range(len(p)):
        for j in range(i + 1):
            if abs(p[i, j] - p[j, i]) > SYMMETRY * np.sqrt(abs(p[i, i] * p[j, j])):
                raise errors.not_symmetric("covariances", index, j, i)
            rest = (p[i, j] + p[j, i]) / 2 - lower[i, :j] @ lower[j, :j]
            if i != j:
                lower[i, j] = rest / lower[j, j]
            elif rest > 0:
                lower[i, i] = np.sqrt(rest)
            else:
                raise errors.not_positive_definite("covariances", index, i + 1)
    return lower


def same_dimension(x: Floats, y: Floats) -> None:
    """Refuse points of different dimensions."""
    if len(x) and len(y) and x.shape[1] != y.shape[1]:
        raise errors.dimension("Y", [0], y.shape[1], x.shape[1])


def _check_points(x: Floats, y: Floats) -> None:
    plain_points(x, y)
    finite("X", x)
    finite("Y", y)


def _require_dimension(x: Floats, y: Floats, expected: int) -> None:
    for name, points in (("X", x), ("Y", y)):
        if len(points) and points.shape[1] != expected:
            raise errors.dimension(name, [0], points.shape[1], expected)
