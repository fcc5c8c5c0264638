"""Sets of hundreds of points and more, where only near pairs are looked at."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

import trackmetrics
from trackmetrics import _native, _numpy, gospa, ospa, ospa_assignment


@pytest.fixture(autouse=True)
def _native_backend():
    """The references are the dense definition and refuse what is large."""
    with trackmetrics.use_backend("native"):
        yield


def dense(x, y, c, p):
    """Costs and near pairs of the least total, over the matrix of all pairs."""
    squares = sum((a[:, None] - b) ** 2 for a, b in zip(x.T, y.T, strict=True))
    costs = np.where(squares < c * c, squares ** (p / 2), c**p)
    rows, columns = linear_sum_assignment(costs)
    return costs[rows, columns].sum(), int((squares[rows, columns] < c * c).sum())


@pytest.mark.parametrize("d", [1, 2, 3, 4])
@pytest.mark.parametrize("p", [2.0, 4.0])
def test_whole_numbers_are_exact(d, p):
    """Ties, duplicates and pairs at the cutoff itself, few points and many in a cell."""
    rng = np.random.default_rng(d)
    for _ in range(12):
        m, n = rng.integers(100, 320), rng.integers(200, 420)
        span = int(rng.integers(4, 40)) * (25 if d == 1 else 1)
        x, y = (rng.integers(-span, span, (k, d)).astype(float) for k in (m, n))
        c = float(rng.integers(1, 5))
        total, _ = dense(x, y, c, p)
        larger = max(m, n)
        expected = ((total + c**p * abs(m - n)) / larger) ** (1 / p)
        assert ospa(x, y, c, p).ospa == pytest.approx(expected, rel=1e-15)
        assert ospa(y, x, c, p) == ospa(x, y, c, p)
        result = gospa(x, y, c, p)
        parts = result.localization + result.missed + result.false
        # In units of c^p / 2, as whole numbers: OSPA and GOSPA have the same least total.
        assert parts == total + c**p * (m + n - 2 * min(m, n)) / 2


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 3.0])
def test_real_numbers_agree_with_the_reference(order):
    rng = np.random.default_rng(7)
    for n in (250, 400):
        x = rng.uniform(0, 100, (n, 2))
        y = x[rng.permutation(n)[: n - 30]] + rng.normal(0, 2, (n - 30, 2))
        expected = _numpy.ospa(x, y, 5.0, order)
        assert _native.ospa(x, y, 5.0, order) == pytest.approx(expected, rel=1e-13)
        if order >= 1:
            (parts, pairs), (reference, same) = (k.gospa(x, y, 5.0, order, 2.0) for k in KERNELS)
            assert parts == pytest.approx(reference, rel=1e-12)
            assert pairs.tolist() == same.tolist() == ospa_assignment(x, y, 5.0, order).tolist()


KERNELS = (_native, _numpy)


def test_clusters_and_outliers_far_away():
    rng = np.random.default_rng(2)
    centres = rng.uniform(-1e7, 1e7, (30, 3))
    x = (centres[:, None] + rng.uniform(0, 20, (30, 20, 3))).reshape(-1, 3)
    y = (centres[:, None] + rng.uniform(0, 20, (30, 20, 3))).reshape(-1, 3)
    x[0] = 1e15
    assert ospa(x, y, 6.0) == pytest.approx(_numpy.ospa(x, y, 6.0, 2.0), rel=1e-12)


def test_a_hundred_thousand_points():
    """Shuffled and moved by less than half the distance of neighbours: the pairs are known."""
    side = 316
    x = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) * 10.0
    rng = np.random.default_rng(0)
    order = rng.permutation(len(x))
    moves = rng.uniform(-1, 1, x.shape)
    y = (x + moves)[order]
    expected = np.sqrt((moves**2).sum() / len(x))
    assert ospa(x, y, c=25.0).ospa == pytest.approx(expected, rel=1e-12)
    pairs = gospa(x, y, c=25.0).assignment
    assert (order[pairs[:, 1]] == pairs[:, 0]).all()
    assert ospa(x, x[::-1].copy(), c=25.0) == (0.0, 0.0, 0.0)


def test_what_does_not_fit_is_refused_before_it_is_tried():
    """Every point within the cutoff of every other one."""
    x = np.random.default_rng(0).uniform(0, 1, (40_000, 2))
    with pytest.raises(ValueError, match=r"^1600000000 pairs of points would take \d+ bytes"):
        ospa(x, x + 0.1, c=100.0)
    with pytest.raises(ValueError, match="take a smaller c or fewer points"):
        ospa(x, x, p=np.inf)
    with (
        trackmetrics.use_backend("numpy"),
        pytest.raises(ValueError, match="take a smaller c or fewer points"),
    ):
        ospa(x, x)


def test_ctrl_c_stops_a_large_matching():
    x, y = (np.random.default_rng(k).uniform(0, 1, (7_000, 2)) for k in (0, 1))
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        ospa(x, y, c=0.3)
    timer.join()
    assert time.perf_counter() - begin < 0.3 + 2


def test_near_pairs_are_those_of_a_tree():
    """Every near pair counts: with all others beyond the cutoff each point has one partner."""
    rng = np.random.default_rng(5)
    x = rng.permutation(900)[:500, None] // [[30, 1]] % 30 * 7.0
    y = x + rng.uniform(-3, 3, x.shape)
    found = cKDTree(x).query(y, distance_upper_bound=5)[1]
    pairs = ospa_assignment(x, y, c=5.0)
    assert (found[pairs[:, 1]] == pairs[:, 0]).all()


@pytest.mark.parametrize("d", [1, 2, 3])
def test_pairs_fall_as_in_scipy(d):
    """On a grid full of ties, and where there are none."""
    rng = np.random.default_rng(d)
    for whole in (True, False) * 3:
        span = {1: 900.0, 2: 40.0, 3: 14.0}[d]
        x, y = (rng.uniform(0, span, (k, d)) for k in rng.integers(110, 260, 2))
        if whole:
            x, y = np.round(x), np.round(y)
        squares = sum((a[:, None] - b) ** 2 for a, b in zip(x.T, y.T, strict=True))
        rows, columns = linear_sum_assignment(np.minimum(squares, 9.0))
        near = squares[rows, columns] < 9.0
        expected = np.stack([rows, columns], axis=1)[near]
        assert ospa_assignment(x, y, 3.0).tolist() == expected.tolist()
        assert gospa(x, y, 3.0).assignment.tolist() == expected.tolist()
