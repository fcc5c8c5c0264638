"""Segmentation, penalties, attribution and inflation: kernel, reference and definition."""

import itertools
from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics import _native, _numpy

BACKENDS = (_native, _numpy)


def likelihood(values, dof):
    total, m = sum(values), sum(dof)
    return -m * log(max(total / m, 1e-12))


def best_partition(values, dof, least, pieces):
    """The definition: every way of cutting."""
    n = len(values)
    best = (-np.inf, ())
    for cuts in itertools.combinations(range(1, n), pieces - 1):
        edges = [0, *cuts, n]
        if min(b - a for a, b in itertools.pairwise(edges)) >= least:
            total = sum(likelihood(values[a:b], dof[a:b]) for a, b in itertools.pairwise(edges))
            if total > best[0] + 1e-12:
                best = (total, cuts)
    return best[0] - likelihood(values, dof)


@st.composite
def sequences(draw):
    n = draw(st.integers(1, 9))
    scale = draw(st.sampled_from([1e-12, 1.0, 1e12]))
    number = st.one_of(st.integers(0, 5).map(float), st.floats(0, 30))
    values = draw(st.lists(number, min_size=n, max_size=n))
    dof = draw(st.lists(st.integers(1, 4).map(float), min_size=n, max_size=n))
    return np.array(values) * scale, np.array(dof)


@given(sequences(), st.integers(1, 3), st.integers(1, 4))
def test_partitions_are_optimal(sequence, least, most):
    values, dof = sequence
    starts = np.array([0, len(values)])
    results = [m.scale_partitions(values, dof, starts, least, most) for m in BACKENDS]
    for gains, cuts in results:
        assert gains.shape == (1, most)
        assert gains[0, 0] == 0.0
        for s in range(1, most):
            expected = best_partition(values, dof, least, s + 1)
            assert gains[0, s] == pytest.approx(expected, rel=1e-9, abs=1e-9)
            if np.isfinite(expected):
                edges = [0, *cuts[0, s, :s], len(values)]
                assert min(np.diff(edges)) >= least
                reached = sum(
                    likelihood(values[a:b], dof[a:b]) for a, b in itertools.pairwise(edges)
                ) - likelihood(values, dof)
                assert reached == pytest.approx(expected, rel=1e-9, abs=1e-9)
            else:
                assert (cuts[0, s] == -1).all()


def test_many_sequences_are_cut_as_one_by_one():
    rng = np.random.default_rng(0)
    lengths = rng.integers(0, 60, 40)
    starts = np.concatenate([[0], np.cumsum(lengths)])
    values, dof = rng.chisquare(2, starts[-1]), np.full(starts[-1], 2.0)
    gains, cuts = _native.scale_partitions(values, dof, starts, 2, 4)
    for i, (a, b) in enumerate(itertools.pairwise(starts)):
        alone = _native.scale_partitions(values[a:b], dof[a:b], np.array([0, b - a]), 2, 4)
        np.testing.assert_array_equal(gains[i : i + 1], alone[0])
        np.testing.assert_array_equal(cuts[i : i + 1], alone[1])


def test_long_sequences_agree_between_backends():
    rng = np.random.default_rng(1)
    values = rng.chisquare(3, 2600) * np.where(np.arange(2600) < 1733, 1.0, 1.6)
    arguments = values, np.full(2600, 3.0), np.array([0, 2600]), 2, 4
    (gains, cuts), (reference_gains, reference_cuts) = (
        m.scale_partitions(*arguments) for m in BACKENDS
    )
    np.testing.assert_allclose(gains, reference_gains, rtol=1e-9)
    np.testing.assert_array_equal(cuts, reference_cuts)
    assert abs(cuts[0, 1, 0] - 1733) < 30


@given(st.integers(1, 4), st.integers(0, 12), st.integers(0, 2**32))
def test_best_splits_are_the_definition(least, n, seed):
    rng = np.random.default_rng(seed)
    dof = rng.integers(1, 5, n).astype(float)
    draws = rng.chisquare(np.maximum(dof, 1), (3, n))
    expected = [
        max(
            [
                likelihood(row[:k], dof[:k]) + likelihood(row[k:], dof[k:])
                for k in range(least, n - least + 1)
            ],
            default=likelihood(row, dof) if n else 0.0,
        )
        - (likelihood(row, dof) if n else 0.0)
        for row in draws
    ]
    for module in BACKENDS:
        found = module.best_split_gains(draws, dof, least)
        assert found.tolist() == pytest.approx(expected if n else [], rel=1e-9, abs=1e-9)


@given(sequences(), st.sampled_from([0.4, 2.5]), st.sampled_from([0.01, 0.5]))
def test_alarms_are_the_definition(sequence, scale, alpha):
    values, dof = sequence
    n = len(values)
    rises = [
        -m / 2 * log(scale) + c / 2 * (1 - 1 / scale) for c, m in zip(values, dof, strict=True)
    ]
    expected, largest = [-1, -1], np.finfo(float).max
    for k in range(n):
        # The largest sum of values that end here, and the latest beginning of it.
        sums = [sum(rises[j : k + 1]) for j in range(k + 1)]
        largest = max(sums)
        if largest > log(n / alpha):
            expected = [k, max(j for j in range(k + 1) if sums[j] == pytest.approx(largest))]
            break
    starts = np.array([0, n])
    for module in BACKENDS:
        found = module.first_alarms(values, dof, starts, scale, alpha)
        assert found.shape == (1, 2)
        assert found[0, 0] == expected[0]
        if expected[0] >= 0:
            assert sum(rises[found[0, 1] : found[0, 0] + 1]) == pytest.approx(largest)


def shapley(error, covariance):
    """The definition: mean contribution over all orders of joining."""
    d = len(error)

    def worth(members):
        members = list(members)
        p = covariance[np.ix_(members, members)]
        return error[members] @ np.linalg.solve(p, error[members]) if members else 0.0

    shares = np.zeros(d)
    orders = list(itertools.permutations(range(d)))
    for order in orders:
        for k, state in enumerate(order):
            shares[state] += worth(order[: k + 1]) - worth(order[:k])
    return shares / len(orders)


@st.composite
def games(draw):
    d = draw(st.integers(1, 5))
    seed, scale = draw(st.integers(0, 2**32)), draw(st.sampled_from([1e-9, 1.0, 1e9]))
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2, d, d))
    return rng.normal(size=(2, d)), (root @ root.swapaxes(1, 2) + 0.1 * np.eye(d)) * scale


@given(games())
def test_shares_are_the_definition_and_add_up(game):
    errors, covariances = game
    d = errors.shape[1]
    orders = np.array(list(itertools.permutations(range(d))), np.int64).ravel()
    nees = [e @ np.linalg.solve(p, e) for e, p in zip(errors, covariances, strict=True)]
    expected = [shapley(e, p) for e, p in zip(errors, covariances, strict=True)]
    for module in BACKENDS:
        exact = module.shapley_shares(errors, covariances)
        np.testing.assert_allclose(exact, expected, rtol=1e-8, atol=1e-9 * max(nees))
        np.testing.assert_allclose(exact.sum(axis=1), nees, rtol=1e-9)
        sampled = module.sampled_shapley_shares(errors, covariances, orders)
        np.testing.assert_allclose(sampled, exact, rtol=1e-8, atol=1e-9 * max(nees))


@given(st.integers(1, 4), st.booleans(), st.integers(0, 2**32))
def test_inflation_is_the_sum_of_squared_correlations(d, partial, seed):
    rng = np.random.default_rng(seed)
    n = 12
    steps = rng.normal(size=(n, d, d)) * 0.4
    root = rng.normal(size=(n, d, d))
    p = root @ root.swapaxes(1, 2) + np.eye(d)
    starts = np.array([0, 5, 5, n])
    known = rng.random((n, d)) < 0.6 if partial else np.ones((n, d), bool)
    known[np.arange(n), rng.integers(0, d, n)] = True
    whiteners = [np.linalg.inv(np.linalg.cholesky(p[k][np.ix_(i, i)])) for k, i in enumerate(known)]
    expected = np.ones(n)
    for a, b in itertools.pairwise(starts):
        for k in range(a, b):
            for other in range(a, k):
                shared = p[other]
                for step in range(other + 1, k + 1):
                    shared = steps[step] @ shared
                shared = shared[np.ix_(known[k], known[other])]
                shared = ((whiteners[k] @ shared @ whiteners[other].T) ** 2).sum()
                expected[k] += shared / known[k].sum()
                expected[other] += shared / known[other].sum()
    mask = known.astype(np.int64).ravel() if partial else None
    native, reference = (m.nees_inflation(steps, p, starts, mask) for m in BACKENDS)
    np.testing.assert_allclose(native, reference, rtol=1e-9)
    # Memories below 1e-4 are forgotten, and whatever lies behind them.
    np.testing.assert_allclose(native, expected, rtol=0.02)


ONE = np.ones(1)
ZERO_ONE = np.array([0, 1])
EYE = np.eye(2)[None]
BAD = [
    ("scale_partitions", (np.array([np.nan]), ONE, ZERO_ONE, 2, 4)),
    ("scale_partitions", (-ONE, ONE, ZERO_ONE, 2, 4)),
    ("scale_partitions", (ONE, -ONE, ZERO_ONE, 2, 4)),
    ("scale_partitions", (ONE, np.array([np.inf]), ZERO_ONE, 2, 4)),
    ("scale_partitions", (ONE, np.ones(2), ZERO_ONE, 2, 4)),
    ("scale_partitions", (ONE, ONE, np.array([0, 2]), 2, 4)),
    ("scale_partitions", (ONE, ONE, np.empty(0, np.int64), 2, 4)),
    ("scale_partitions", (ONE, ONE, ZERO_ONE, 0, 4)),
    ("scale_partitions", (ONE, ONE, ZERO_ONE, 2, 0)),
    ("first_alarms", (-ONE, ONE, ZERO_ONE, 2.0, 0.1)),
    ("first_alarms", (ONE, np.ones(2), ZERO_ONE, 2.0, 0.1)),
    ("first_alarms", (ONE, ONE, np.array([0, 2]), 2.0, 0.1)),
    ("first_alarms", (ONE, ONE, ZERO_ONE, 0.0, 0.1)),
    ("first_alarms", (ONE, ONE, ZERO_ONE, 2.0, np.inf)),
    ("best_split_gains", (np.full((1, 2), np.inf), np.ones(2), 1)),
    ("best_split_gains", (np.ones((1, 2)), np.zeros(2), 1)),
    ("shapley_shares", (np.ones((1, 2)), -EYE)),
    ("shapley_shares", (np.ones((1, 2)), np.array([[[1.0, 2.0], [2.0, 1.0]]]))),
    ("shapley_shares", (np.full((1, 2), np.nan), EYE)),
    ("shapley_shares", (np.ones((2, 2)), EYE)),
    ("shapley_shares", (np.ones((0, 17)), np.ones((0, 17, 17)))),
    ("sampled_shapley_shares", (np.ones((1, 2)), EYE, np.array([0, 0]))),
    ("sampled_shapley_shares", (np.ones((1, 2)), EYE, np.array([0, 2]))),
    ("sampled_shapley_shares", (np.ones((1, 2)), EYE, np.empty(0, np.int64))),
    ("nees_inflation", (EYE, -EYE, ZERO_ONE, None)),
    ("nees_inflation", (EYE, np.full((1, 2, 2), np.nan), ZERO_ONE, None)),
    ("nees_inflation", (np.ones((2, 2, 2)), EYE, ZERO_ONE, None)),
    ("nees_inflation", (EYE, EYE, np.array([0, 3]), None)),
    ("nees_inflation", (EYE, EYE, ZERO_ONE, ZERO_ONE[:1])),
]


@pytest.mark.parametrize(("name", "arguments"), BAD)
def test_wrong_arguments_have_one_message(name, arguments):
    messages = []
    for module in BACKENDS:
        with pytest.raises(ValueError, match=r".") as caught:
            getattr(module, name)(*arguments)
        messages.append((type(caught.value), str(caught.value)))
    assert messages[0] == messages[1]


def test_what_is_not_plain_is_refused():
    from trackmetrics.errors import NotPlain

    for module in BACKENDS:
        with pytest.raises(NotPlain):
            module.scale_partitions([1.0], ONE, ZERO_ONE, 2, 4)
        with pytest.raises(NotPlain):
            module.best_split_gains(np.ones((2, 2))[:, ::2], ONE, 1)
