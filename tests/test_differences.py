"""Every difference from pytcl that docs/differences.md lists, with both values."""

import warnings

import numpy as np
import pytest

import trackmetrics

pytestmark = pytest.mark.peers

EYE = np.eye(2)


def theirs(function, *arguments, **options):
    """What pytcl gives, its warnings aside."""
    from pytcl import performance_evaluation as peer

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return getattr(peer, function)(*arguments, **options)


def ours_is_refused(function, *arguments, kind=ValueError, match="."):
    with pytest.raises(kind, match=match):
        getattr(trackmetrics, function)(*arguments)


def test_integers_overflow_there():
    zero, hundred = np.zeros(3, np.int8), np.full(3, 100, np.int8)
    assert theirs("rmse", zero, hundred) == 4.0
    assert trackmetrics.rmse(zero, hundred) == 100.0
    assert theirs("monte_carlo_rmse", hundred) == 4.0
    assert trackmetrics.monte_carlo_rmse(hundred) == 100.0


def test_states_broadcast_by_accident_there():
    column, row = np.array([[0.0], [1.0], [2.0]]), np.array([0.0, 1.0, 2.0])
    assert theirs("rmse", column, row) == pytest.approx(np.sqrt(4 / 3))
    ours_is_refused("rmse", column, row, match="estimated_states has shape")
    assert theirs("rmse", np.ones((3, 2)), np.zeros(2)) == 1.0
    ours_is_refused("rmse", np.ones((3, 2)), np.zeros(2), match="estimated_states has shape")
    assert theirs("nees", np.ones(3), np.zeros(1), np.eye(3)) == 3.0
    ours_is_refused("nees", np.ones(3), np.zeros(1), np.eye(3), match="estimated_state has shape")


def test_a_mean_of_nothing_is_nan_there():
    none = np.empty((0, 2))
    assert np.isnan(theirs("rmse", none, none))
    ours_is_refused("rmse", none, none, match="is empty")
    assert np.isnan(theirs("monte_carlo_rmse", none)).all()
    ours_is_refused("monte_carlo_rmse", none, match="is empty")
    assert np.isnan(theirs("position_rmse", np.ones((3, 2)), np.ones((3, 2)), []))
    ours_is_refused("position_rmse", np.ones((3, 2)), np.ones((3, 2)), [], match="is empty")
    assert np.isnan(theirs("average_nees", none, none, np.empty((0, 2, 2))))
    ours_is_refused("average_nees", none, none, np.empty((0, 2, 2)), match="is empty")
    assert theirs("consistency_test", [], 2).is_consistent == False  # noqa: E712 - np.bool_
    ours_is_refused("consistency_test", [], 2, match="is empty")
    with pytest.raises(ZeroDivisionError):
        theirs("credibility_interval", none, np.empty((0, 2, 2)))
    ours_is_refused("credibility_interval", none, np.empty((0, 2, 2)), match="is empty")


def test_types_of_numbers():
    x, y = np.float32([1.0, 2.0]), np.float32([1.5, 2.5])
    assert type(theirs("rmse", x, y)) is np.float32
    assert type(trackmetrics.rmse(x, y)) is float
    assert theirs("rmse", np.array([1j]), np.array([0.0])) == 1j
    ours_is_refused("rmse", np.array([1j]), np.array([0.0]), kind=TypeError, match="real")
    assert type(theirs("consistency_test", [2.0], 2).is_consistent) is np.bool_
    assert trackmetrics.consistency_test([2.0], 2).is_consistent is True


def test_components_of_states():
    states = [[0.0, 1.0], [2.0, 3.0]]
    with pytest.raises(TypeError):
        theirs("position_rmse", states, states, [0])
    assert trackmetrics.position_rmse(states, states, [0]) == 0.0
    x = np.zeros((2, 3, 2))
    x[:, 0, :] = 1.0
    x[:, :, 1] = 5.0
    assert theirs("position_rmse", x, np.zeros_like(x), [0]) == np.sqrt((1 + 25) / 2)
    assert trackmetrics.position_rmse(x, np.zeros_like(x), [0]) == np.sqrt(1 / 3)
    with pytest.raises(IndexError):
        theirs("velocity_rmse", np.ones((3, 2)), np.ones((3, 2)), [2])
    ours_is_refused("velocity_rmse", np.ones((3, 2)), np.ones((3, 2)), [2], match="indices")


def test_what_is_no_covariance_is_used_there():
    v = np.array([1.0, 0.0])
    assert theirs("nis", v, -EYE) == -1.0
    ours_is_refused("nis", v, -EYE, kind=np.linalg.LinAlgError, match="leading minor 1")
    skew = np.array([[1.0, 0.5], [0.0, 1.0]])
    assert theirs("nis", v, skew) == 1.0
    ours_is_refused("nis", v, skew, match="not symmetric")
    singular = np.array([[0.1, 0.3], [0.3, 0.9]])
    assert theirs("nis", v, singular) > 1e15
    ours_is_refused("nis", v, singular, kind=np.linalg.LinAlgError, match="leading minor 2")


def test_nan_and_infinity():
    assert np.isnan(theirs("nis", np.array([np.nan, 0.0]), EYE))
    ours_is_refused("nis", np.array([np.nan, 0.0]), EYE, match="not finite")
    assert np.isnan(trackmetrics.nis(np.array([np.nan, 0.0]), EYE, on_invalid="nan"))
    assert theirs("nis", np.array([1.0]), np.array([[np.inf]])) == 0.0
    ours_is_refused("nis", np.array([1.0]), np.array([[np.inf]]), match="not finite")
    errors, p = np.array([[np.nan, 0.0], [0.0, 0.0]]), np.array([EYE, EYE])
    assert theirs("credibility_interval", errors, p) == 0.5
    ours_is_refused("credibility_interval", errors, p, match="not finite")
    assert np.isnan(theirs("estimation_error_bounds", np.array([-EYE]))).any()
    ours_is_refused("estimation_error_bounds", np.array([-EYE]), match="at least 0")


def test_forms_of_input_that_fail_there():
    with pytest.raises((ValueError, np.linalg.LinAlgError)):
        theirs("nees", 1.0, 0.0, 4.0)
    assert trackmetrics.nees(1.0, 0.0, 4.0) == 0.25
    with pytest.raises(ValueError, match="matmul"):
        theirs("nees", np.ones((2, 1)), np.zeros((2, 1)), EYE)
    assert trackmetrics.nees(np.ones((2, 1)), np.zeros((2, 1)), EYE) == 2.0
    with pytest.raises(AttributeError):
        theirs("nees_sequence", [[1.0, 1.0]], [[0.0, 0.0]], [EYE])
    assert trackmetrics.nees_sequence([[1.0, 1.0]], [[0.0, 0.0]], [EYE]).tolist() == [2.0]
    with pytest.raises(np.linalg.LinAlgError):
        theirs("nees_sequence", np.ones((3, 2)), np.zeros((3, 2)), EYE)
    got = trackmetrics.nees_sequence(np.ones((3, 2)), np.zeros((3, 2)), EYE)
    assert got.tolist() == [2.0, 2.0, 2.0]
    with pytest.raises(ValueError):  # noqa: PT011 - numpy's AxisError
        theirs("estimation_error_bounds", EYE)
    assert trackmetrics.estimation_error_bounds(EYE).tolist() == [2.0, 2.0]


def test_unequal_lengths_are_cut_there():
    x, y, p = np.zeros((2, 2)), np.zeros((3, 2)), np.array([EYE] * 3)
    assert theirs("nees_sequence", x, y, p).tolist() == [0.0, 0.0]
    ours_is_refused("nees_sequence", x, y, p, match="estimated_states has shape")


def test_limits_of_the_chi_square_test():
    values = np.full((2, 10), 2.0)
    assert theirs("consistency_test", values, 2).upper_bound > 5
    assert trackmetrics.consistency_test(values, 2).upper_bound < 3
    for arguments in (([2.0], 2, 95), ([2.0], 0)):
        result = theirs("consistency_test", *arguments)
        assert not result.is_consistent
        assert np.isnan(result.upper_bound)
        ours_is_refused("consistency_test", *arguments)
    assert tuple(theirs("consistency_test", [2.0], 2, 1))[:4] == (True, 2.0, 0.0, np.inf)
    ours_is_refused("consistency_test", [2.0], 2, 1, match="confidence")
    for values in ([np.nan], [-1.0]):
        assert not theirs("consistency_test", values, 2).is_consistent
        ours_is_refused("consistency_test", values, 2, match="finite and at least 0")
    assert theirs("credibility_interval", np.zeros((1, 2)), np.array([EYE]), 95) == 0.0
    ours_is_refused("credibility_interval", np.zeros((1, 2)), np.array([EYE]), 95)


def test_infinite_order_and_cutoff_are_not_computed_there():
    near, far = ([[0.0]], [[0.3]]), ([[0.0]], [[5.0]])
    assert theirs("ospa", *near, p=np.inf).ospa == 1.0
    assert trackmetrics.ospa(*near, p=np.inf).ospa == 0.3
    with pytest.raises(ValueError, match="infeasible"):
        theirs("ospa", *far, p=np.inf)
    assert trackmetrics.ospa(*far, p=np.inf).ospa == 5.0
    assert np.isnan(theirs("ospa", *far, c=np.inf).ospa)
    assert trackmetrics.ospa(*far, c=np.inf).ospa == 5.0
    with pytest.raises(OverflowError):
        theirs("ospa", *far, p=200.0)
    assert trackmetrics.ospa(*far, p=200.0).ospa == pytest.approx(5.0, rel=1e-12)


def test_cutoffs_and_orders_that_are_none_are_used_there():
    pair = [[0.0]], [[5.0]]
    assert theirs("ospa", *pair, c=-1.0).ospa == 1.0
    assert theirs("ospa", *pair, p=-1.0).ospa == pytest.approx(5.0)
    assert np.isnan(theirs("ospa", *pair, c=np.nan).ospa)
    with pytest.raises(ZeroDivisionError):
        theirs("ospa", *pair, p=0)
    for wrong in (-1.0, 0.0, np.nan):
        ours_is_refused("ospa", *pair, wrong, match="c must be positive")
        ours_is_refused("ospa", *pair, 1.0, wrong, match="p must be positive")


def test_points_that_are_none_are_used_there():
    nan, infinite = [np.array([np.nan, 0.0])], [np.array([np.inf, 0.0])]
    pair, single = [np.array([3.0, 4.0])], [np.array([0.0])]
    assert theirs("ospa", nan, [], 7.0).ospa == 7.0
    ours_is_refused("ospa", nan, [], 7.0, match=r"X\[0\] is not finite: nan")
    assert theirs("ospa", pair, infinite, 7.0).ospa == 7.0
    ours_is_refused("ospa", pair, infinite, 7.0, match=r"Y\[0\] is not finite: inf")
    assert theirs("ospa", pair, single).ospa == 5.0
    ours_is_refused("ospa", pair, single, match=r"Y\[0\] has 1 coordinates, expected 2")
    assert theirs("ospa", [np.empty(0)], [np.empty(0)]).ospa == 0.0
    ours_is_refused("ospa", [np.empty(0)], [np.empty(0)], match=r"X\[0\] has no coordinates")
    assert type(theirs("ospa", [], pair, 7).ospa) is int
    assert type(trackmetrics.ospa([], pair, 7).ospa) is float
