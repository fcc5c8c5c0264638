"""The axioms of a metric, for every distance that claims them.

A metric is declared in ``METRICS``: how to compute it, how to draw its points, and the rounding
that its scale brings.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics import Mahalanobis, gospa, ospa


@dataclass
class Metric:
    """A distance between sets that claims identity, symmetry and the triangle inequality."""

    compute: Any
    points: Any
    rounding: float


def grid(d):
    return st.lists(st.integers(-4, 4).map(float), min_size=d, max_size=d)


PLANE = st.lists(grid(2), max_size=4)
SPACE = st.lists(grid(3), max_size=4)
LATITUDE, LONGITUDE = st.integers(-89, 89).map(float), st.integers(-179, 180).map(float)
GLOBE = st.lists(st.tuples(LATITUDE, LONGITUDE).map(list), max_size=4)
COVARIANCE = [[4.0, 1.0], [1.0, 0.5]]


def _gospa(X, Y, c, p, alpha=2.0, distance="euclidean"):
    return gospa(X, Y, c, p, alpha, distance=distance).distance


def _ospa(X, Y, c, p, distance="euclidean"):
    return ospa(X, Y, c, p, distance=distance).ospa


METRICS = {
    f"{name} {extra}": Metric(partial(compute, c=c, p=p, **arguments), points, 1e-12 * c)
    for name, compute, orders in (
        ("ospa", _ospa, (1.0, 2.0, np.inf)),
        ("gospa", _gospa, (1.0, 3.0)),
    )
    for p in orders
    for extra, points, c, arguments in (
        (f"euclidean p={p}", PLANE, 3.0, {}),
        (f"euclidean 3-D p={p}", SPACE, 5.0, {}),
        (f"manhattan p={p}", PLANE, 4.0, {"distance": "manhattan"}),
        (f"haversine p={p}", GLOBE, 5e6, {"distance": "haversine"}),
        (f"mahalanobis p={p}", PLANE, 2.5, {"distance": Mahalanobis(COVARIANCE)}),
    )
} | {"gospa alpha=1": Metric(partial(_gospa, c=3.0, p=2.0, alpha=1.0), PLANE, 3e-12)}


@pytest.mark.parametrize("metric", METRICS.values(), ids=METRICS)
@given(data=st.data())
def test_axioms(metric, data):
    a, b, c = (data.draw(metric.points) for _ in range(3))
    ab, ba = metric.compute(a, b), metric.compute(b, a)
    bc, ac = metric.compute(b, c), metric.compute(a, c)
    assert metric.compute(a, a[::-1]) == pytest.approx(0.0, abs=metric.rounding)
    assert ab == pytest.approx(ba, rel=1e-12, abs=metric.rounding)
    assert (ab <= metric.rounding) == (sorted(a) == sorted(b))
    assert ac <= ab + bc + metric.rounding
