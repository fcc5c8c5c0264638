"""The chi-square test of a mean, and the credibility interval."""

import numpy as np
import pytest

import trackmetrics
from trackmetrics import ConsistencyResult, _native, _numpy


@pytest.mark.parametrize(
    ("runs", "lower", "upper"),
    [(1, 0.166, 2.567), (10, 0.647, 1.428), (25, 0.768, 1.263), (50, 0.832, 1.183)],
)
def test_bounds_of_a_mean_of_five_states(runs, lower, upper):
    """The table of the normalised mean's 95 % interval, to three digits."""
    result = trackmetrics.consistency_test(np.full(runs, 5.0), df=5)
    assert result.lower_bound / 5 == pytest.approx(lower, abs=6e-4)
    assert result.upper_bound / 5 == pytest.approx(upper, abs=6e-4)
    assert result.is_consistent is True
    assert isinstance(result, ConsistencyResult)
    assert [type(x) for x in result] == [bool, float, float, float, float]


def test_the_documented_example_of_the_peer():
    np.random.seed(42)  # noqa: NPY002 - the numbers of that example
    result = trackmetrics.consistency_test(np.random.chisquare(df=4, size=100), df=4)  # noqa: NPY002
    expected = (True, 3.8383650272, 3.4648176537, 4.5730548197, 3.8383650272)
    assert result == pytest.approx(expected, abs=1e-9)


def test_bounds_are_inclusive():
    result = trackmetrics.consistency_test([1.0], df=1)
    assert trackmetrics.consistency_test([result.upper_bound], df=1).is_consistent
    assert trackmetrics.consistency_test([result.lower_bound], df=1).is_consistent
    assert not trackmetrics.consistency_test([result.upper_bound * (1 + 1e-15)], 1).is_consistent


def test_an_consistent_filter_passes_as_often_as_it_says():
    values = np.random.default_rng(3).chisquare(4, (4000, 30))
    passed = sum(trackmetrics.consistency_test(run, 4, 0.9).is_consistent for run in values)
    assert passed / 4000 == pytest.approx(0.9, abs=0.015)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([], 2), "nees_or_nis_values is empty"),
        (([1.0, -1e-9], 2), "nees_or_nis_values[1] must be finite and at least 0, got -1e-09"),
        (([[1.0, 2.0], [np.nan, 1.0]], 2), "nees_or_nis_values[1][0] must be finite and at least"),
        (([np.inf], 2), "nees_or_nis_values[0] must be finite and at least 0, got inf"),
        (([1.0], 0), "df must be positive, got 0.0"),
        (([1.0], np.nan), "df must be positive, got nan"),
        (([1.0], 2, 1.0), "confidence must be between 0 and 1, both excluded, got 1.0"),
        (([1.0], 2, 95), "confidence must be between 0 and 1, both excluded, got 95.0"),
    ],
)
def test_what_is_refused(arguments, message):
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend), pytest.raises(ValueError) as caught:  # noqa: PT011
            trackmetrics.consistency_test(*arguments)
        assert str(caught.value).startswith(message)


@pytest.mark.parametrize("n", [1, 7, 64, 5000])
def test_the_mean_of_kernel_and_reference(n):
    values = np.random.default_rng(n).chisquare(3, n)
    mean, count = _native.mean_statistic(values)
    assert mean == pytest.approx(_numpy.mean_statistic(values)[0], rel=1e-14)
    assert count == n


def test_an_error_on_the_edge_is_inside():
    edge = 5.991464547107979  # the 95 % point of a chi-square of 2: -2 ln 0.05
    errors = np.array([[np.sqrt(edge), 0.0]])
    p = np.eye(2)
    for kernels in (_native, _numpy):
        form = kernels.nis_sequence(errors, p, 1e-8, None, False)[0]
        assert kernels.credibility_interval(errors, p, form, 1e-8) == 1.0
        assert kernels.credibility_interval(errors, p, np.nextafter(form, 0), 1e-8) == 0.0


def test_share_inside_the_region():
    errors = np.random.default_rng(1).multivariate_normal([0, 0], [[2, 1], [1, 3]], 20_000)
    for p in (0.5, 0.95):
        share = trackmetrics.credibility_interval(errors, [[2, 1], [1, 3]], p)
        assert share == pytest.approx(p, abs=0.012)
        assert type(share) is float
    assert trackmetrics.credibility_interval(errors.astype(np.float32), np.eye(2)) < 0.9


def test_what_a_credibility_interval_refuses():
    for interval in (0.0, 1.0, np.nan, 95):
        with pytest.raises(ValueError, match="interval must be between 0 and 1"):
            trackmetrics.credibility_interval([[0.0]], [[1.0]], interval)
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            with pytest.raises(ValueError, match="errors is empty"):
                trackmetrics.credibility_interval(np.empty((0, 2)), np.eye(2))
            with pytest.raises(ValueError, match=r"errors\[0\]\[1\] is not finite: nan"):
                trackmetrics.credibility_interval([[0.0, np.nan]], np.eye(2))
            with pytest.raises(ValueError, match=r"errors has shape \(2,\), expected"):
                trackmetrics.credibility_interval([0.0, 1.0], np.eye(2))
            with pytest.raises(ValueError, match=r"covariances has shape \(3, 2, 2\)"):
                trackmetrics.credibility_interval(np.zeros((2, 2)), np.ones((3, 2, 2)))


@pytest.mark.peers
def test_random_inputs_against_pytcl():
    from pytcl import performance_evaluation as peer

    rng = np.random.default_rng(8)
    for _ in range(1000):
        df, n = int(rng.integers(1, 12)), int(rng.integers(1, 60))
        values = rng.chisquare(df, n) * rng.choice([1.0, 1.4])
        confidence = float(rng.uniform(0.01, 0.999))
        ours = trackmetrics.consistency_test(values, df, confidence)
        theirs = peer.consistency_test(values, df, confidence)
        assert ours.is_consistent == theirs.is_consistent
        assert ours == pytest.approx(tuple(map(float, theirs)), rel=1e-12)
    for d in range(1, 10):
        errors = rng.standard_normal((300, d))
        root = rng.standard_normal((300, d, d)) / 3
        p = root @ root.swapaxes(-1, -2) + np.eye(d)
        p = (p + p.swapaxes(-1, -2)) / 2
        for interval in (0.1, 0.5, 0.95):
            expected = peer.credibility_interval(errors, p, interval)
            assert trackmetrics.credibility_interval(errors, p, interval) == expected
