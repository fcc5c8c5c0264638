"""Distances between finite sets of points: twin of ``point_sets`` in the core."""

import numpy as np

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, finite, plain, positive
from trackmetrics._numpy.assignment import solve


def ospa(x: Floats, y: Floats, c: float, p: float) -> tuple[float, float, float]:
    """The Optimal Sub-Pattern Assignment distance between two finite sets of points."""
    plain(x, y)
    finite("X", x)
    finite("Y", y)
    positive("c", c)
    positive("p", p)
    if len(x) and len(y) and x.shape[1] != y.shape[1]:
        raise errors.dimension("Y", [0], y.shape[1], x.shape[1])
    n, m = max(len(x), len(y)), min(len(x), len(y))
    if n == 0:
        return 0.0, 0.0, 0.0
    if m == 0:
        return c, 0.0, c
    d = np.sqrt(((x[:, None] - y[None]) ** 2).sum(-1))
    costs = np.where(d >= c, c**p, d**p)
    columns = solve(costs)
    matched = columns >= 0
    total = costs[matched, columns[matched]].sum()
    missing = c**p * (n - m)
    root = [float((part / n) ** (1 / p)) for part in (total + missing, total, missing)]
    return root[0], root[1], root[2]
