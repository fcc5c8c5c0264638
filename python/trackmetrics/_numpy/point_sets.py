"""Distances between finite sets of points: reference of ``point_sets`` in the core."""

import math

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import (
    Floats,
    Frames,
    finite,
    frames,
    plain,
    plain_numbers,
    plain_points,
    positive,
)
from trackmetrics._numpy.assignment import solve, solve_bottleneck
from trackmetrics._numpy.distances import euclidean, same_dimension, squares
from trackmetrics.results import OSPAResult

Parts = tuple[float, float, float]
Pairs = NDArray[np.int64]
GospaParts = tuple[float, float, float, float, int, int]
LEAST_ORDER = 1e-3
"""Below it the root of a mean of powers keeps too few digits."""
_POWERS = (1e-250, 1e250)  # where powers keep their digits


def ospa(x: Floats, y: Floats, c: float, p: float) -> OSPAResult:
    """OSPA of one frame."""
    plain_numbers(c, p)
    _check_sets(x, y)
    _check_cutoff(c, p)
    same_dimension(x, y)
    return OSPAResult(*_ospa(euclidean(x, y), c, p))


def ospa_over_time(x: Frames, y: Frames, c: float, p: float) -> Floats:
    """OSPA of every frame of two sequences."""
    plain_numbers(c, p)
    truth, estimates = frames("X_sequence", x), frames("Y_sequence", y)
    _check_cutoff(c, p)
    _check_sequences(x, y)
    pairs = zip(truth, estimates, strict=True)
    return np.array([_ospa(euclidean(a, b), c, p)[0] for a, b in pairs], dtype=np.float64)


def ospa_from_distances(distances: Floats, c: float, p: float) -> OSPAResult:
    """OSPA of one frame whose distances are given."""
    plain_numbers(c, p)
    _check_distances(distances)
    _check_cutoff(c, p)
    return OSPAResult(*_ospa(distances, c, p))


def ospa_assignment(x: Floats, y: Floats, c: float, p: float) -> Pairs:
    """The pairs of OSPA closer than the cutoff."""
    plain_numbers(c, p)
    _check_sets(x, y)
    _check_cutoff(c, p)
    same_dimension(x, y)
    distances = euclidean(x, y)
    if p == np.inf and distances.size:
        columns = solve_bottleneck(np.minimum(distances, min(c, np.finfo(float).max)))[1]
        return _near_pairs(distances, columns, c)
    return _pairs(distances, squares(x, y), c, p)


def gospa(x: Floats, y: Floats, c: float, p: float, alpha: float) -> tuple[GospaParts, Pairs]:
    """GOSPA of one frame: (distance, localization, missed, false, the two counts), pairs."""
    plain_numbers(c, p, alpha)
    _check_sets(x, y)
    _check_setting(c, p, alpha)
    same_dimension(x, y)
    return _gospa(euclidean(x, y), squares(x, y), c, p, alpha)


def gospa_from_distances(
    distances: Floats, c: float, p: float, alpha: float
) -> tuple[GospaParts, Pairs]:
    """GOSPA of one frame whose distances are given."""
    plain_numbers(c, p, alpha)
    _check_distances(distances)
    _check_setting(c, p, alpha)
    return _gospa(distances, distances**2, c, p, alpha)


def gospa_over_time(
    x: Frames, y: Frames, c: float, p: float, alpha: float
) -> tuple[list[Floats], list[NDArray[np.int64]]]:
    """GOSPA of every frame of two sequences: the fields as columns, the counts as integers."""
    plain_numbers(c, p, alpha)
    truth, estimates = frames("X_sequence", x), frames("Y_sequence", y)
    _check_setting(c, p, alpha)
    _check_sequences(x, y)
    rows = [
        _gospa(euclidean(a, b), squares(a, b), c, p, alpha)[0]
        for a, b in zip(truth, estimates, strict=True)
    ]
    columns = list(zip(*rows, strict=True)) if rows else [()] * 6
    return (
        [np.array(column, dtype=np.float64) for column in columns[:4]],
        [np.array(column, dtype=np.int64) for column in columns[4:]],
    )


def _ospa(distances: Floats, c: float, p: float) -> Parts:
    """The Optimal Sub-Pattern Assignment distance between two sets of points."""
    if len(distances) > distances.shape[1]:
        distances = np.ascontiguousarray(distances.T)
    m, n = distances.shape
    if n == 0:
        return 0.0, 0.0, 0.0
    if m == 0:
        return float(c), 0.0, float(c)
    # In units of the bottleneck distance the least total is at least 1: no power that matters
    # leaves the range of floats, whatever the order and the scale.
    distances = np.minimum(distances, min(c, np.finfo(float).max))
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


def _gospa(
    distances: Floats, squared: Floats, c: float, p: float, alpha: float
) -> tuple[GospaParts, Pairs]:
    """The Generalised Optimal Sub-Pattern Assignment metric between two sets of points."""
    pairs = _pairs(distances, squared, c, p)
    m, n = distances.shape
    matched = distances[pairs[:, 0], pairs[:, 1]]
    missed, false = m - len(pairs), n - len(pairs)
    alone = min(m, n) - len(pairs) + abs(m - n) / alpha
    # In units of the largest distance that counts.
    unit = max(c if alone else 0.0, float(matched.max(initial=0.0)))
    distance = 0.0
    if unit:
        with np.errstate(under="ignore"):
            total = ((matched / unit) ** p).sum()
            if alone:
                total += alone * (c / unit) ** p
        distance = float(unit * total ** (1 / p))
    if alpha != 2:
        return (distance, np.nan, np.nan, np.nan, missed, false), pairs
    with np.errstate(over="ignore", under="ignore"):
        localization, most = float((matched**p).sum()), float(np.float64(c) ** p)
    parts = (missed * (most / 2) if missed else 0.0, false * (most / 2) if false else 0.0)
    return (distance, localization, *parts, missed, false), pairs


def _pairs(distances: Floats, squared: Floats, c: float, p: float) -> Pairs:
    """The pairs closer than the cutoff in the matching of least total, with SciPy's ties."""
    if not distances.size:
        return np.empty((0, 2), dtype=np.int64)
    return _near_pairs(distances, solve(_costs(distances, squared, c, p)), c)


def _near_pairs(distances: Floats, columns: NDArray[np.int64], c: float) -> Pairs:
    pairs = np.stack([np.arange(len(columns)), columns], axis=1)[columns >= 0]
    return pairs[distances[pairs[:, 0], pairs[:, 1]] < c]


def _costs(distances: Floats, squared: Floats, c: float, p: float) -> Floats:
    """``min(d, c) ** p``, from squares for even orders: whole numbers stay whole."""
    m, n = distances.shape
    near = distances < c
    with np.errstate(over="ignore", under="ignore"):
        most = np.float64(c) ** p
        raised = squared ** (p / 2) if p % 2 == 0 and p <= 64 else distances**p
        costs: Floats = np.where(near, raised, most)
        if _POWERS[0] <= most <= _POWERS[1] or (math.isinf(c) and costs.max() <= _POWERS[1]):
            return costs
        # In units of the bottleneck distance what is above the number of points is never chosen.
        capped = np.minimum(distances, min(c, np.finfo(float).max))
        unit = solve_bottleneck(capped)[0]
        if not unit < c:
            unit = float(distances[near].max(initial=0.0))
        ratios: Floats = np.minimum((capped / max(unit, np.finfo(float).tiny)) ** p, 2.0 * (m + n))
        return ratios


def _check_sets(x: Floats, y: Floats) -> None:
    plain_points(x, y)
    finite("X", x)
    finite("Y", y)


def _check_sequences(x: Frames, y: Frames) -> None:
    """Refuse sequences that are not equally long, or whose points differ in dimension."""
    lengths = len(x[1]) - 1, len(y[1]) - 1
    if lengths[0] != lengths[1]:
        raise errors.length("Y_sequence", lengths[1], "X_sequence", lengths[0], "frames")
    if len(x[0]) and len(y[0]) and x[0].shape[1] != y[0].shape[1]:
        raise errors.dimension("Y_sequence", [], y[0].shape[1], x[0].shape[1])


def _check_distances(distances: Floats) -> None:
    plain(distances)
    if distances.ndim != 2:
        raise errors.NotPlain
    wrong = np.argwhere(~(distances >= 0))
    if len(wrong):
        i, j = wrong[0]
        raise errors.element("distances", [int(i), int(j)], "at least 0", distances[i, j])


def _check_cutoff(c: float, p: float) -> None:
    positive("c", c)
    positive("p", p)
    if p < LEAST_ORDER:
        raise errors.parameter("p", "at least 0.001", p)


def _check_setting(c: float, p: float, alpha: float) -> None:
    """Refuse what GOSPA is not defined for."""
    if not 0 < c < np.inf:
        raise errors.parameter("c", "positive and finite", c)
    if not 1 <= p < np.inf:
        raise errors.parameter("p", "at least 1 and finite", p)
    if not 0 < alpha <= 2:
        raise errors.parameter("alpha", "above 0 and at most 2", alpha)
