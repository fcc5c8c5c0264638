"""OSPA against brute force, its twin and its peers."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import _native, _numpy


def brute_force(x, y, c, p):
    """The definition, over every assignment of the smaller set."""
    if len(x) > len(y):
        x, y = y, x
    n, m = len(y), len(x)
    if n == 0:
        return 0.0
    total = min(
        sum(min(np.linalg.norm(x[i] - y[j]), c) ** p for i, j in enumerate(chosen))
        for chosen in itertools.permutations(range(n), m)
    )
    return ((total + c**p * (n - m)) / n) ** (1 / p)


@st.composite
def pairs_of_sets(draw):
    d = draw(st.integers(1, 4))
    sizes = draw(st.tuples(st.integers(0, 5), st.integers(0, 5)))
    grid = st.integers(-3, 3).map(float)
    return [
        np.array(
            draw(st.lists(st.lists(grid, min_size=d, max_size=d), min_size=n, max_size=n))
        ).reshape(n, d)
        for n in sizes
    ]


@given(pairs_of_sets(), st.sampled_from([0.5, 1.0, 2.0, 3.0]), st.sampled_from([1.0, 2.0, 3.5]))
def test_kernel_twin_and_definition_agree(sets, c, p):
    x, y = sets
    expected = brute_force(x, y, c, p)
    assert _native.ospa(x, y, c, p)[0] == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert _numpy.ospa(x, y, c, p) == pytest.approx(_native.ospa(x, y, c, p), rel=1e-12)


def test_one_empty_set_is_at_the_cutoff():
    assert trackmetrics.ospa([], [[1.0, 2.0]], c=7.5) == (7.5, 0.0, 7.5)
