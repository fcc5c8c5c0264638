"""Mean OSPA over hypotheses, against brute force and the peer."""

import itertools
import math

import numpy as np
import pytest

import trackmetrics.mospa
from trackmetrics import calc_mospa_error, mmospa2tar_2d, mmospa_approx, ospa


def orders(n):
    return [list(order) for order in itertools.permutations(range(n))]


def error_by_definition(estimate, x, w):
    total = sum(
        weight * min(((estimate - x[:, order, k]) ** 2).sum() for order in orders(x.shape[1]))
        for k, weight in enumerate(w)
    )
    return math.sqrt(total / x.shape[1])


def random_hypotheses(rng, d, n, count):
    x = rng.normal(size=(d, n, count)) * rng.choice([1e-6, 1.0, 1e6])
    w = rng.random(count)
    return x, w / w.sum()


def test_error_by_definition():
    rng = np.random.default_rng(1)
    for _ in range(200):
        x, w = random_hypotheses(rng, *rng.integers(1, 5, 3))
        estimate = rng.normal(size=x.shape[:2])
        assert calc_mospa_error(estimate, x, w) == pytest.approx(
            error_by_definition(estimate, x, w), rel=1e-12
        )


def test_the_error_over_one_hypothesis_is_ospa():
    rng = np.random.default_rng(2)
    estimate, truth = rng.normal(size=(2, 3, 4))
    expected = ospa(truth.T, estimate.T, c=1e6).ospa
    assert calc_mospa_error(estimate, truth[..., None], [1.0]) == pytest.approx(expected)


def test_two_targets_are_estimated_exactly():
    rng = np.random.default_rng(3)
    for _ in range(30):
        particles = rng.normal(size=(4, 6))
        x = particles.reshape(2, 2, 6).swapaxes(0, 1)
        every = [
            np.mean([x[:, order, k] for k, order in enumerate(chosen)], axis=0)
            for chosen in itertools.product(orders(2), repeat=6)
        ]
        w = np.full(6, 1 / 6)
        least = min(calc_mospa_error(estimate, x, w) for estimate in every)
        found = mmospa2tar_2d(particles).reshape(2, 2).T
        assert calc_mospa_error(found, x, w) == pytest.approx(least, rel=1e-12)


def test_an_approximate_estimate_is_the_mean_of_its_orders():
    rng = np.random.default_rng(4)
    for scans in (1, 2, 5):
        x, w = random_hypotheses(rng, 2, 3, 7)
        estimate, order = mmospa_approx(x, w, scans)
        ordered = np.stack([x[:, order[:, k], k] for k in range(7)], axis=-1)
        np.testing.assert_allclose(estimate, ordered @ w, rtol=1e-12)
        assert (np.sort(order, axis=0) == np.arange(3)[:, None]).all()
        assert (order[:, 0] == np.arange(3)).all()


@pytest.mark.peers
def test_the_peer_agrees_to_the_bit():
    from pytcl.performance_evaluation import mospa as peer

    rng = np.random.default_rng(5)
    for i in range(600):
        d, n, count = rng.integers(1, 5, 3)
        x, w = random_hypotheses(rng, d, n, count)
        particles = rng.normal(size=(4, rng.integers(1, 40)))
        if i % 2:  # ties, and targets that stand together
            x, particles = np.round(x), np.round(particles * 2)
        estimate = rng.integers(-2, 3, (d, n))
        assert calc_mospa_error(estimate, x, w) == peer.calc_mospa_error(estimate, x, w)
        scans = int(rng.integers(1, 4))
        ours, theirs = mmospa_approx(x, w, scans), peer.mmospa_approx(x, w, scans)
        np.testing.assert_array_equal(ours[0], theirs[0])
        np.testing.assert_array_equal(ours[1], theirs[1])
        np.testing.assert_array_equal(mmospa2tar_2d(particles), peer.mmospa2tar_2d(particles))


def test_lists_and_integers():
    assert calc_mospa_error([[0, 1]], [[[1], [0]]], 1) == 0.0
    assert mmospa2tar_2d([[0], [0], [1], [1]]).tolist() == [0.0, 0.0, 1.0, 1.0]
    assert trackmetrics.mospa.calc_mospa_error is calc_mospa_error


X = np.zeros((2, 3, 4))


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (
            lambda: calc_mospa_error(np.zeros((3, 2)), X, np.ones(4)),
            "x_est has shape (3, 2), expected (2, 3)",
        ),
        (lambda: calc_mospa_error(X[..., 0], X, np.ones(5)), "w has 5 hypotheses, x has 4"),
        (
            lambda: calc_mospa_error(X[..., 0], X, [1, 0, -0.5, 1]),
            "w[2] must be at least 0, got -0.5",
        ),
        (
            lambda: calc_mospa_error(X[..., 0] + np.nan, X, np.ones(4)),
            "x_est[0][0] is not finite: nan",
        ),
        (
            lambda: mmospa_approx(X[..., 0], [1]),
            "x has shape (2, 3), expected (d, n, K), each at least 1",
        ),
        (lambda: mmospa_approx(X, np.ones(4), 0), "num_scans must be at least 1, got 0.0"),
        (
            lambda: mmospa2tar_2d(np.zeros((3, 5))),
            "particles has shape (3, 5), expected (4, N), N at least 1",
        ),
        (
            lambda: mmospa2tar_2d(np.zeros((4, 0))),
            "particles has shape (4, 0), expected (4, N), N at least 1",
        ),
    ],
)
def test_bad_arguments_are_named(call, text):
    with pytest.raises(ValueError, match=r"^") as raised:
        call()
    assert str(raised.value) == text
