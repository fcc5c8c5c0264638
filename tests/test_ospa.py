"""OSPA against brute force, its reference implementation and its peer."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import _native, _numpy, ospa, ospa_over_time

INF = math.inf
ORDERS = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 7.0, INF]


def brute_force(x, y, c, p):
    """The definition, over every assignment of the smaller set."""
    if len(x) > len(y):
        x, y = y, x
    n, m = len(y), len(x)
    if n == 0:
        return 0.0
    if n > m and p == INF:
        return c
    d = np.minimum(np.linalg.norm(x[:, None] - y[None], axis=-1), c)
    chosen = [d[np.arange(m), list(j)] for j in itertools.permutations(range(n), m)]
    if p == INF:
        return min(pairs.max() for pairs in chosen)
    if n > m and c == INF:
        return INF
    total = min((pairs**p).sum() for pairs in chosen)
    return ((total + (c**p * (n - m) if n > m else 0.0)) / n) ** (1 / p)


@st.composite
def pairs_of_sets(draw, largest=5, d=None):
    """Two sets on a grid that is full of ties, at any scale."""
    d = d or draw(st.integers(1, 6))
    grid = st.integers(-3, 3).map(float)
    point = st.lists(grid, min_size=d, max_size=d)
    scale = draw(st.sampled_from([1.0, 1.0, 0.1, 1e-12, 1e12, 1e-140, 1e140]))
    sizes = draw(st.tuples(st.integers(0, largest), st.integers(0, largest)))
    sets = [draw(st.lists(point, min_size=n, max_size=n)) for n in sizes]
    return [scale * np.array(s).reshape(len(s), d) for s in sets], scale


def parts_add_up(parts, p, rel=1e-12):
    distance, localization, cardinality = parts
    if distance == 0 or distance == INF:
        return distance == max(localization, cardinality)
    if p == INF:
        return distance == max(localization, cardinality)
    total = (localization / distance) ** p + (cardinality / distance) ** p
    return total == pytest.approx(1.0, rel=rel * max(p, 1))


@given(pairs_of_sets(), st.sampled_from([0.5, 1.0, 2.0, 3.5, INF]), st.sampled_from(ORDERS))
def test_kernel_reference_and_definition_agree(sets, c, p):
    (x, y), scale = sets
    unit = brute_force(x / scale, y / scale, c, p)
    native, reference = _native.ospa(x, y, c * scale, p), _numpy.ospa(x, y, c * scale, p)
    assert native[0] == pytest.approx(unit * scale, rel=1e-11, abs=1e-15 * scale)
    assert reference == pytest.approx(native, rel=1e-11, abs=1e-15 * scale)
    assert parts_add_up(native, p)
    assert parts_add_up(reference, p)


@given(st.integers(0, 2**32), st.integers(1, 40), st.integers(1, 40), st.integers(1, 12))
def test_kernel_and_reference_agree_on_larger_sets(seed, m, n, d):
    rng = np.random.default_rng(seed)
    whole = rng.random() < 0.5
    x, y = (rng.uniform(0, 10, (k, d)) for k in (m, n))
    if whole:
        x, y = np.round(x), np.round(y)
    for p in (1.0, 2.0, 3.0, 4.0):
        native, reference = _native.ospa(x, y, 6.0, p), _numpy.ospa(x, y, 6.0, p)
        assert reference == pytest.approx(native, rel=1e-12)
        assert _native.ospa(y, x, 6.0, p) == pytest.approx(native, rel=1e-12)


@given(pairs_of_sets(largest=12), st.sampled_from(ORDERS))
def test_a_set_is_at_distance_zero_from_itself(sets, p):
    (x, _), scale = sets
    assert _native.ospa(x, x[::-1].copy(), 2.0 * scale, p) == (0.0, 0.0, 0.0)
    assert _numpy.ospa(x, x[::-1].copy(), 2.0 * scale, p) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("p", [2.0, 50.0, 300.0, 1e4])
@pytest.mark.parametrize("scale", [1e-200, 1e-12, 1.0, 1e12, 1e200])
def test_powers_that_leave_the_range_of_floats(p, scale):
    x = scale * np.array([[0.0, 0.0], [50.0, 0.0]])
    y = scale * np.array([[3e-3, 4e-3], [50.0, 5e-3]])
    assert ospa(x, y, c=100 * scale, p=p).ospa == pytest.approx(5e-3 * scale, rel=1e-12)
    more = scale * np.array([[0.0, 0.0], [50.0, 0.0], [900.0, 0.0]])
    far = ospa(more, y, c=100 * scale, p=p)
    assert far.cardinality == pytest.approx(100 * scale * (1 / 3) ** (1 / p), rel=1e-12)
    assert far.localization == pytest.approx(5e-3 * scale * (2 / 3) ** (1 / p), rel=1e-12)


def test_each_part_where_orders_and_cutoffs_are_infinite():
    one, two = [[0.0]], [[3.0], [7.0]]
    assert ospa(one, two, c=5.0, p=INF) == (5.0, 3.0, 5.0)
    assert ospa([[0.0], [9.0]], two, c=5.0, p=INF) == (3.0, 3.0, 0.0)
    assert ospa([[0.0], [90.0]], two, c=5.0, p=INF) == (5.0, 5.0, 0.0)
    assert ospa(one, two, c=INF, p=2.0) == pytest.approx((INF, math.sqrt(4.5), INF), rel=1e-15)
    assert ospa([[0.0], [90.0]], two, c=INF, p=1.0) == (43.0, 43.0, 0.0)
    assert ospa([], two, c=INF) == (INF, 0.0, INF)


def test_one_empty_set_is_exactly_at_the_cutoff():
    for result in (ospa([], [[1.0, 2.0]], c=7), ospa(np.empty((3, 2)) * 0, np.empty((0, 2)), c=7)):
        assert result == (7.0, 0.0, 7.0)
        assert [type(part) for part in result] == [float] * 3
    assert ospa([], []) == (0.0, 0.0, 0.0)
    assert ospa([], np.empty((0, 3)), c=0.1) == (0.0, 0.0, 0.0)


def test_the_cutoff_is_decided_before_powers():
    """0.1 ** 2 and the square of a distance of 0.1 round differently; OSPA is c either way."""
    for c in (0.1, 0.3, 0.7, 1.1, 123.4):
        assert ospa([[0.0, 0.0]], [[c, 0.0]], c=c, p=2).ospa == pytest.approx(c, rel=1e-15)
        assert ospa([[0.0, 0.0]], [[1e300, -1e300]], c=c, p=3).ospa == pytest.approx(c, rel=1e-15)


FORMS = {
    "lists": lambda x: x.tolist(),
    "tuples": lambda x: tuple(map(tuple, x.tolist())),
    "arrays": list,
    "integers": lambda x: [row.astype(int) for row in x],
    "int32": lambda x: x.astype(np.int32),
    "float32": lambda x: x.astype(np.float32),
    "columns": lambda x: [row[:, None] for row in x],
    "views": lambda x: np.repeat(x, 2, axis=1)[:, ::2],
    "fortran": np.asfortranarray,
    "mixed": lambda x: [row.tolist() if i % 2 else row for i, row in enumerate(x)],
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_every_form_of_input(form):
    rng = np.random.default_rng(5)
    for n in (0, 1, 2, 6):
        x, y = (np.round(rng.uniform(0, 9, (k, 2))) for k in (n, 5))
        expected = ospa(x, y, c=4.0)
        assert ospa(form(x), form(y), c=4.0) == expected
        assert ospa(x, form(y), 4) == expected
        assert list(ospa_over_time([form(x)] * 3, (y, form(y), y), 4)) == [expected.ospa] * 3


def test_numbers_are_points_of_one_dimension():
    assert ospa([0.0, 5], [1, np.float64(5.0)], p=1).ospa == 0.5
    assert ospa(np.array([0, 5]), np.array([1.0, 5.0]), p=1).ospa == 0.5
    assert list(ospa_over_time([[0.0, 5], []], [[1, 5.0], [2.0]], c=9, p=1)) == [0.5, 9.0]
    assert list(ospa_over_time(np.zeros((2, 3)), np.ones((2, 3)), p=1)) == [1.0, 1.0]


def test_a_sequence_may_be_stacked_or_packed():
    rng = np.random.default_rng(1)
    sizes_x, sizes_y = [3, 0, 5, 9, 1], [2, 2, 0, 11, 1]
    x, y = ([rng.uniform(0, 9, (n, 3)) for n in sizes] for sizes in (sizes_x, sizes_y))
    packed = [(np.concatenate(s), np.cumsum([0, *map(len, s)])) for s in (x, y)]
    expected = [ospa(a, b, 5).ospa for a, b in zip(x, y, strict=True)]
    got = ospa_over_time(*packed, 5)
    assert got.dtype == np.float64
    assert list(got) == expected
    assert list(ospa_over_time(x, packed[1], 5)) == expected
    narrow = (packed[0][0].astype(np.float32), packed[0][1].astype(np.int32))
    assert ospa_over_time(narrow, y, 5) == pytest.approx(expected, rel=1e-6)
    stack = rng.uniform(0, 9, (4, 6, 2))
    assert list(ospa_over_time(stack, list(stack[::-1]), 5)) == [
        ospa(a, b, 5).ospa for a, b in zip(stack, stack[::-1], strict=True)
    ]
    assert ospa_over_time([], []).shape == (0,)
    assert ospa_over_time(np.empty((0, 3, 2)), []).shape == (0,)
    assert list(ospa_over_time(np.empty((2, 0, 2)), [[], [[1.0, 1.0]]], 3)) == [0.0, 3.0]


NAN = math.nan
WRONG = [
    (([[0.0, NAN]], [[1.0, 1.0]]), {}, "X[0] is not finite: nan"),
    (([[0.0, 1.0]], [[1.0, 1.0], [-INF, 2.0]]), {}, "Y[1] is not finite: -inf"),
    (([], [[1.0, INF]]), {}, "Y[0] is not finite: inf"),
    (([[0.0]], [[1.0]]), {"c": 0}, "c must be positive, got 0.0"),
    (([[0.0]], [[1.0]]), {"c": -1.5}, "c must be positive, got -1.5"),
    (([], []), {"c": NAN}, "c must be positive, got nan"),
    (([[0.0]], [[1.0]]), {"p": 0}, "p must be positive, got 0.0"),
    (([[0.0]], [[1.0]]), {"p": -2}, "p must be positive, got -2.0"),
    (([[0.0]], [[1.0]]), {"p": NAN}, "p must be positive, got nan"),
    (([[0.0, 0.0]], [[1.0]]), {}, "Y[0] has 1 coordinates, expected 2"),
    (([np.zeros(2), np.zeros(3)], [[1.0]]), {}, "X[1] has 3 coordinates, expected 2"),
    (([[1.0]], [[1.0], 2.0, (3.0, 4.0)]), {}, "Y[2] has 2 coordinates, expected 1"),
    (([[]], [[1.0]]), {}, "X[0] has no coordinates"),
    ((np.empty((2, 0)), [[1.0]]), {}, "X[0] has no coordinates"),
    (([[[1.0], [2.0, 3.0]]], []), {}, "X[0] is ragged: expected an array of numbers"),
    ((np.float64(3.0), [[1.0]]), {}, "X must be a list, tuple or array of points, got float64"),
    ((np.array(3.0), [[1.0]]), {}, "X has shape (), expected (n, d)"),
    (((p for p in []), [[1.0]]), {}, "X must be a list, tuple or array of points, got generator"),
    (([["a"]], [[1.0]]), {}, "X[0] must hold real numbers, got dtype <U1"),
    (([[1j]], [[1.0]]), {}, "X[0] must hold real numbers, got dtype complex128"),
]


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize(("sets", "parameters", "text"), WRONG, ids=[w[2] for w in WRONG])
def test_what_is_wrong_is_named(backend, sets, parameters, text):
    with trackmetrics.use_backend(backend), pytest.raises((ValueError, TypeError)) as caught:
        ospa(*sets, **parameters)
    assert str(caught.value) == text


FRAMES = [[[0.0, 0.0]], [], [[1.0, 1.0], [2.0, 2.0]]]
PACKED = np.zeros((3, 2))
WRONG_SEQUENCES = [
    (FRAMES[:2], FRAMES, "Y_sequence has 3 frames, X_sequence has 2"),
    (FRAMES, [*FRAMES[:2], [[1.0, 1.0], [NAN, 2.0]]], "Y_sequence[2][1] is not finite: nan"),
    ([[], [], [[INF]]], [[], [], []], "X_sequence[2][0] is not finite: inf"),
    (FRAMES, [[], [], [[1.0]]], "Y_sequence has 1 coordinates, expected 2"),
    ([*FRAMES, [[1.0, 2.0], [3.0]]], FRAMES, "X_sequence[3][1] has 1 coordinates, expected 2"),
    ([*FRAMES, np.zeros((2, 3))], FRAMES, "X_sequence[3][0] has 3 coordinates, expected 2"),
    ([*FRAMES, [[1.0], [2.0, 1.0]]], FRAMES, "X_sequence[3][0] has 1 coordinates, expected 2"),
    (
        (PACKED, np.array([0, 2, 4])),
        FRAMES,
        "X_sequence: starts must rise from 0 to 3, the number of points",
    ),
    (
        FRAMES,
        (PACKED, np.array([0, 3, 2, 3])),
        "Y_sequence: starts must rise from 0 to 3, the number of points",
    ),
    (
        FRAMES,
        (PACKED, np.array([], dtype=int)),
        "Y_sequence: starts must rise from 0 to 3, the number of points",
    ),
    (np.zeros(3), FRAMES, "X_sequence has shape (3,), expected (T, n, d)"),
    (
        {},
        FRAMES,
        "X_sequence must be a list, tuple or array of sets of points, got dict",
    ),
    (
        FRAMES,
        [None],
        "Y_sequence[0] must be a list, tuple or array of points, got NoneType",
    ),
]


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize(("x", "y", "text"), WRONG_SEQUENCES)
def test_what_is_wrong_in_a_sequence_is_named(backend, x, y, text):
    with trackmetrics.use_backend(backend), pytest.raises((ValueError, TypeError)) as caught:
        ospa_over_time(x, y)
    assert str(caught.value) == text


@pytest.mark.peers
@pytest.mark.parametrize("d", [1, 2, 3, 5])
def test_the_same_as_pytcl(d):
    from pytcl.performance_evaluation import ospa as peer
    from pytcl.performance_evaluation import ospa_over_time as peer_over_time

    rng = np.random.default_rng(d)
    truth, estimates = [], []
    for t in range(600):
        whole = t % 2 == 0
        sets = [rng.uniform(0, 20, (rng.integers(0, 9), d)) for _ in range(2)]
        x, y = ([np.round(row) if whole else row for row in s] for s in sets)
        truth.append(x)
        estimates.append(y)
        for c, p in ((5.0, 2.0), (7.0, 1.0), (5.0, 3.0), (6.0, 4.0), (4.0, 0.5)):
            got, expected = ospa(x, y, c, p), peer(x, y, c, p)
            assert got == pytest.approx(tuple(expected), rel=1e-12, abs=1e-14), (t, c, p)
    assert ospa_over_time(truth, estimates, 5.0, 2.0) == pytest.approx(
        peer_over_time(truth, estimates, 5.0, 2.0), rel=1e-12, abs=1e-14
    )


@given(st.data())
def test_a_sequence_is_its_frames(data):
    count = data.draw(st.integers(0, 6))
    frames = [data.draw(pairs_of_sets(7, 2))[0] for _ in range(count)]
    x, y = [f[0] for f in frames], [f[1] for f in frames]
    assume(all(np.abs(np.concatenate([a.ravel(), b.ravel(), [0]])).max() < 1e20 for a, b in frames))
    single = [ospa(a, b, 2.5, 2.0).ospa for a, b in frames]
    assert list(ospa_over_time(x, y, 2.5, 2.0)) == single
