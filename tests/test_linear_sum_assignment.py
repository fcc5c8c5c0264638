"""The linear sum assignment against brute force, its reference and SciPy, pair for pair."""

import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment as scipy_assignment

import trackmetrics
from trackmetrics import _native, _numpy, linear_sum_assignment

INF = math.inf
SHAPES = [
    (1, 1),
    (1, 7),
    (7, 1),
    (2, 9),
    (9, 2),
    (5, 5),
    (6, 8),
    (8, 6),
    (17, 17),
    (13, 40),
    (40, 13),
]


def brute_force(costs):
    """The least total over every matching of the shorter side."""
    n, m = costs.shape
    if n > m:
        costs, n, m = costs.T, m, n
    chosen = itertools.permutations(range(m), n)
    return min(math.fsum(costs[i, j] for i, j in enumerate(columns)) for columns in chosen)


def same_pairs(ours, theirs):
    for a, b in zip(ours, theirs, strict=True):
        assert a.dtype == b.dtype == np.int64
        np.testing.assert_array_equal(a, b)


@st.composite
def matrices(draw, largest=6):
    n, m = draw(st.tuples(st.integers(0, largest), st.integers(0, largest)))
    entries = draw(
        st.sampled_from(
            [
                st.integers(-3, 3).map(float),
                st.sampled_from([0.0, 1.0]),
                st.sampled_from([0.1, 0.2, 0.3, 0.7, 1.1]),
                st.floats(-1e12, 1e12),
                st.floats(1e-12, 1e-11),
                st.sampled_from([1e-12, 1.0, 1e12]),
            ]
        )
    )
    return np.array(draw(st.lists(entries, min_size=n * m, max_size=n * m))).reshape(n, m)


@given(matrices(largest=5))
def test_the_total_is_the_least_of_all(costs):
    for solve in (_native.linear_sum_assignment, _numpy.linear_sum_assignment):
        rows, columns = solve(costs, False)
        assert len(rows) == min(costs.shape)
        assert len(set(columns.tolist())) == len(columns)
        scale = np.abs(costs).max(initial=0.0)
        total = math.fsum(costs[rows, columns])
        assert total == pytest.approx(brute_force(costs), abs=1e-13 * scale, rel=0)


@given(matrices(largest=9), st.booleans())
def test_pairs_are_those_of_scipy(costs, maximize):
    expected = scipy_assignment(costs, maximize)
    same_pairs(_native.linear_sum_assignment(costs, maximize), expected)
    same_pairs(_numpy.linear_sum_assignment(costs, maximize), expected)


def tie_rich(rng, kind, shape):
    n, m = shape
    if kind == "integers":
        return rng.integers(0, rng.integers(2, 102), shape).astype(float)
    if kind == "decimals":
        return rng.integers(0, 10, shape) / 10
    if kind == "duplicated rows":
        return rng.random(shape)[rng.integers(0, n, n)]
    if kind == "duplicated columns":
        return np.ascontiguousarray(rng.random(shape)[:, rng.integers(0, m, m)])
    if kind == "truncated":
        x, y = rng.random((n, 2)), rng.random((m, 2))
        return np.minimum(((x[:, None] - y[None]) ** 2).sum(-1), 1 / max(shape))
    if kind == "grid":
        x, y = rng.integers(0, 6, (n, 2)), rng.integers(0, 6, (m, 2))
        return np.sqrt(((x[:, None] - y[None]) ** 2).sum(-1))
    if kind == "sum of a row and a column":
        return rng.random((n, 1)) + rng.random(m)
    if kind == "product of a row and a column":
        return np.arange(1.0, n + 1)[:, None] * np.arange(1.0, m + 1)
    if kind == "forbidden":
        return np.where(rng.random(shape) < 0.3, INF, rng.integers(0, 5, shape))
    return rng.random(shape)


KINDS = [
    "integers",
    "decimals",
    "duplicated rows",
    "duplicated columns",
    "truncated",
    "grid",
    "sum of a row and a column",
    "product of a row and a column",
    "forbidden",
    "real",
]


def outcome(solve, costs, maximize=False):
    try:
        return [indices.tolist() for indices in solve(costs, maximize)]
    except ValueError as error:
        return str(error)


@pytest.mark.parametrize("kind", KINDS)
def test_ties_fall_as_in_scipy(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    for shape in SHAPES:
        for _ in range(25):
            costs = tie_rich(rng, kind, shape)
            expected = outcome(scipy_assignment, costs)
            assert outcome(_native.linear_sum_assignment, costs) == expected
            if max(shape) < 20:
                assert outcome(_numpy.linear_sum_assignment, costs) == expected


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", [(64, 64), (100, 80), (80, 100), (150, 150), (20, 300)])
def test_ties_fall_as_in_scipy_for_larger_matrices(kind, shape):
    rng = np.random.default_rng(99 + KINDS.index(kind))
    for maximize in (False, True):
        costs = tie_rich(rng, kind, shape)
        expected = outcome(scipy_assignment, costs, maximize)
        assert outcome(_native.linear_sum_assignment, costs, maximize) == expected


def forms():
    costs = np.array([[4, 1, 3, 9], [2, 0, 5, 1], [3, 2, 2, 7]])
    wide = np.zeros((6, 8))
    wide[::2, ::2] = costs
    yield costs
    yield costs.tolist()
    yield tuple(map(tuple, costs.tolist()))
    yield costs.T
    yield wide[::2, ::2]
    yield costs[::-1, ::-1].astype(float)
    yield np.asfortranarray(costs, dtype=float)
    for kind in (bool, np.int8, np.uint64, np.float16, np.float32, ">f8", ">i4"):
        yield costs.astype(kind)
    yield np.ma.masked_array(costs, mask=False)
    yield [["4", "1"], ["3", "9"]]
    yield [[2**64, 1], [1, 2]]
    yield [[]]
    yield [[], []]
    yield np.zeros((0, 3))
    yield np.zeros((3, 0), dtype=int)
    yield np.full((0, 0), np.nan)
    yield -costs
    yield costs + 1e308
    yield costs * 1e-320
    yield costs * 1.9e307
    yield -costs * 1.9e307


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_whatever_scipy_takes(backend):
    with trackmetrics.use_backend(backend):
        for costs in forms():
            for maximize in (False, True, 0, "yes", np.True_):
                ours = linear_sum_assignment(costs, maximize=maximize)
                same_pairs(ours, scipy_assignment(costs, maximize=maximize))


WRONG = [
    [1, 2, 3],
    3,
    [],
    None,
    np.zeros((2, 2, 2)),
    [[1, 2], [3]],
    [[1j, 2], [3, 4]],
    np.array([[1j]]),
    [["a", "b"], ["c", "d"]],
    np.array([[1, 2], [3, 4]], dtype=object),
    np.zeros((2, 2), dtype=np.longdouble),
    np.array([["2020-01-01"]], dtype="M8[D]"),
    {},
    [[10**400, 1], [1, 2]],
    [[INF, INF], [1, 2]],
    [[INF, 1, INF], [1, 2, INF], [3, 4, INF]],
    [[INF, 1], [INF, 2], [INF, 5]],
    [[-INF, -INF], [1, 2]],
    [[np.nan, 1], [1, 2]],
    [[1, INF], [1, INF], [INF, np.nan]],
    np.full((70, 70), INF),
]


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("costs", WRONG, ids=[str(i) for i in range(len(WRONG))])
@pytest.mark.parametrize("maximize", [False, True])
def test_whatever_scipy_refuses(costs, maximize, backend):
    with trackmetrics.use_backend(backend):
        try:
            expected = scipy_assignment(costs, maximize)
        except Exception as error:
            with pytest.raises(type(error), match="^" + re.escape(str(error)) + "$"):
                linear_sum_assignment(costs, maximize)
        else:
            same_pairs(linear_sum_assignment(costs, maximize), expected)


def test_the_matrix_is_left_as_it_was():
    costs = np.random.default_rng(1).random((30, 20))
    before = costs.copy()
    linear_sum_assignment(costs)
    linear_sum_assignment(costs, maximize=True)
    np.testing.assert_array_equal(costs, before)


@pytest.mark.parametrize("difference", [0.0, 1e-15, 1e-13, 1e-11, 1e-6])
def test_two_optima_that_are_nearly_equal(difference):
    """A swap of two rows costs next to nothing; which matching is taken is for SciPy to say."""
    rng = np.random.default_rng(7)
    for shape in [(60, 60), (450, 500)]:
        for _ in range(3):
            costs = rng.random(shape)
            i, k = rng.choice(shape[0], 2, replace=False)
            costs[k] = costs[i] + difference * rng.random(shape[1])
            for goal in (False, True):
                expected = scipy_assignment(costs, goal)
                same_pairs(_native.linear_sum_assignment(costs, goal), expected)


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1e12, 1e150, 1e304])
@pytest.mark.parametrize("shape", [(70, 70), (420, 450)])
def test_scales(scale, shape):
    rng = np.random.default_rng(3)
    points = rng.random((shape[0] + shape[1], 2))
    costs = np.linalg.norm(points[: shape[0], None] - points[None, shape[0] :], axis=-1) * scale
    expected = scipy_assignment(costs)
    same_pairs(_native.linear_sum_assignment(costs, False), expected)
    same_pairs(
        _native.linear_sum_assignment(np.ascontiguousarray(costs.T), False)[::-1],
        tuple(part[np.argsort(expected[1])] for part in expected),
    )
    costs[rng.random(shape) < 0.5] = INF
    same_pairs(_native.linear_sum_assignment(costs, False), scipy_assignment(costs))
    costs[0, 0] = 1e3 * scale
    same_pairs(_native.linear_sum_assignment(costs, False), scipy_assignment(costs))


def test_an_error_leaves_nothing_behind():
    rng = np.random.default_rng(5)
    for n in (5, 60):
        costs = rng.integers(0, 9, (n, n)).astype(float)
        blocked = costs.copy()
        blocked[-2:, 1:] = INF
        for _ in range(3):
            with pytest.raises(ValueError, match=r"^cost matrix is infeasible$"):
                _native.linear_sum_assignment(blocked, False)
            same_pairs(_native.linear_sum_assignment(costs, False), scipy_assignment(costs))


@pytest.mark.parametrize("shape", [(7, 7), (64, 64), (410, 420)])
def test_sums_that_overflow(shape):
    rng = np.random.default_rng(11)
    for _ in range(5 if max(shape) < 100 else 1):
        costs = rng.uniform(-1.0, 1.0, shape) * 1.7e308
        assert outcome(_native.linear_sum_assignment, costs) == outcome(scipy_assignment, costs)


@pytest.mark.parametrize("width", ["scalar", "avx2", "widest"])
@pytest.mark.parametrize("kind", KINDS)
def test_every_width_gives_the_same_pairs(width, kind):
    rng = np.random.default_rng(KINDS.index(kind))
    _native.set_simd(width)
    try:
        for shape in [(3, 3), (9, 10), (10, 9), (33, 33), (60, 60), (401, 405)]:
            costs = tie_rich(rng, kind, shape)
            expected = outcome(scipy_assignment, costs)
            assert outcome(_native.linear_sum_assignment, costs) == expected
    finally:
        _native.set_simd("widest")


@pytest.mark.parametrize("shape", [(31, 33), (33, 31), (32, 31), (32, 32), (1, 1023), (1024, 1)])
@pytest.mark.parametrize("values", [3, 1000])
def test_about_the_size_from_which_the_interpreter_is_let_go(shape, values):
    """Up to 32 pairs leave the kernel without a list; more, through one."""
    costs = np.random.default_rng(values).integers(0, values, shape).astype(float)
    same_pairs(linear_sum_assignment(costs), scipy_assignment(costs))
    same_pairs(linear_sum_assignment(costs, True), scipy_assignment(costs, True))
