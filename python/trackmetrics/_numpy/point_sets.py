"""Distances between finite sets of points: twin of ``point_sets`` in the core."""

import math

import numpy as np

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, Frames, finite, frames, plain_points, positive
from trackmetrics._numpy.assignment import solve, solve_bottleneck
from trackmetrics.results import OSPAResult

Parts = tuple[float, float, float]


def ospa(x: Floats, y: Floats, c: float, p: float) -> OSPAResult:
    """OSPA of one frame."""
    plain_points(x, y)
    finite("X", x)
    finite("Y", y)
    positive("c", c)
    positive("p", p)
    if len(x) and len(y) and x.shape[1] != y.shape[1]:
        raise errors.dimension("Y", [0], y.shape[1], x.shape[1])
    return OSPAResult(*_ospa(x, y, c, p))


def ospa_over_time(x: Frames, y: Frames, c: float, p: float) -> Floats:
    """OSPA of every frame of two sequences."""
    truth, estimates = frames("X_sequence", x), frames("Y_sequence", y)
    positive("c", c)
    positive("p", p)
    if len(truth) != len(estimates):
        raise errors.length("Y_sequence", len(estimates), "X_sequence", len(truth), "time steps")
    if len(x[0]) and len(y[0]) and x[0].shape[1] != y[0].shape[1]:
        raise errors.dimension("Y_sequence", [], y[0].shape[1], x[0].shape[1])
    pairs = zip(truth, estimates, strict=True)
    return np.array([_ospa(a, b, c, p)[0] for a, b in pairs], dtype=np.float64)


def _ospa(x: Floats, y: Floats, c: float, p: float) -> Parts:
    """The Optimal Sub-Pattern Assignment distance between two sets of points."""
    if len(x) > len(y):
        x, y = y, x
    m, n = len(x), len(y)
    if n == 0:
        return 0.0, 0.0, 0.0
    if m == 0:
        return float(c), 0.0, float(c)
    # In units of the bottleneck distance the least total is at least 1: no power that matters
    # leaves the range of floats, whatever the order and the scale.
    distances = np.minimum(_distances(x, y), min(c, np.finfo(float).max))
    unit = solve_bottleneck(distances)[0]
    if unit == 0 or p == np.inf:
        return _combine(unit, float(unit > 0), m, n, c, p)
    with np.errstate(over="ignore", under="ignore"):
        costs = np.minimum((distances / unit) ** p, 2.0 * n)
    return _combine(unit, float(costs[np.arange(m), solve(costs)].sum()), m, n, c, p)


def _combine(unit: float, total: float, m: int, n: int, c: float, p: float) -> Parts:
    """The three results from a total in units of ``unit ** p``."""
    localization = unit * (total / n) ** (1 / p) if unit else 0.0
    if m == n:
        return localization, localization, 0.0
    alone = float(n - m)
    both = alone if math.isinf(c) else alone + (unit / c) ** p * total
    return c * (both / n) ** (1 / p), localization, c * (alone / n) ** (1 / p)


def _distances(x: Floats, y: Floats) -> Floats:
    """Euclidean distances, each in units of its largest component: no square overflows."""
    with np.errstate(over="ignore", under="ignore"):
        differences = np.abs(x[:, None] - y[None])
        largest = differences.max(axis=-1)
        unit = np.where((largest > 0) & (largest < np.inf), largest, 1.0)
        squares: Floats = ((differences / unit[..., None]) ** 2).sum(-1)
        return unit * np.sqrt(squares)
