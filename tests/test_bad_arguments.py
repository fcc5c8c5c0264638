"""Whatever is passed for an argument, the error names it, with the same text from both backends."""

import inspect
import re

import numpy as np
import pytest

import trackmetrics as tm

POINTS = np.array([[0.0, 0.0], [10.0, 10.0]])
ERRORS = np.array([[1.0, 0.5], [-0.5, 1.0], [0.3, -1.2], [0.1, 0.4]])
COVARIANCES = np.stack([np.eye(2)] * 4)
VALUES = np.array([1.0, 2.0, 0.5, 3.0])
LABELS = np.array([1, 1, 2])
TRACKS = [(np.array([0, 1]), POINTS)]

SETS = {"X": POINTS, "Y": POINTS + 1, "c": 10.0, "p": 2.0}
FRAMES = {"X_sequence": [POINTS], "Y_sequence": [POINTS + 1], "c": 10.0, "p": 2.0}
MATRIX = {"distances": POINTS, "c": 10.0, "p": 2.0}
STATES = {"true_states": ERRORS, "estimated_states": ERRORS + 1}
LABELLED = {"true_labels": LABELS, "estimated_labels": LABELS}
CREDIBLE = {"errors": ERRORS, "covariances": COVARIANCES}
TESTED = {"confidence": 0.9}
NIS = {"nis_values": VALUES, "dof": 2.0, **TESTED}
INNOVATIONS = {"innovations": ERRORS, "innovation_covariances": COVARIANCES}
STATE = {"true_state": ERRORS[0], "estimated_state": ERRORS[1], "covariance": np.eye(2)}

GOOD = {
    "update_identity": {
        "nis_values": VALUES,
        "predicted_nees": VALUES,
        "updated_nees": VALUES,
        "measurement_errors": ERRORS,
        "measurement_covariances": COVARIANCES,
        "tolerance": 1e-6,
    },
    "mmospa2tar_2d": {"particles": np.ones((4, 3))},
    "mmospa_approx": {"x": np.ones((2, 2, 3)), "w": np.ones(3) / 3, "num_scans": 1},
    "anees": {"nees_values": VALUES, "dof": 2.0, "axis": 0, **TESTED},
    "auction": {"cost_matrix": POINTS, "epsilon": 0.1},
    "average_nees": {**STATES, "covariances": COVARIANCES},
    "average_nis": {**NIS, "axis": -1},
    "bias_test": {**CREDIBLE, **TESTED},
    "bottleneck_assignment": {"cost_matrix": POINTS},
    "calc_mospa_error": {"x_est": np.ones((2, 2)), "x": np.ones((2, 2, 3)), "w": np.ones(3) / 3},
    "consistency_test": {"nees_or_nis_values": VALUES, "df": 2.0, **TESTED},
    "correlation_time": {"values": VALUES},
    "covariance_scale": {"values": VALUES, "dof": 2.0, "correlation_time": 1.0, **TESTED},
    "covariance_test": {**CREDIBLE, **TESTED},
    "coverage": {"values": VALUES, "dof": 2.0, "probability": 0.9, **TESTED},
    "coverage_curve": {"values": VALUES, "dof": 2.0, **TESTED},
    "credibility_interval": {**CREDIBLE, "interval": 0.9},
    "decorrelated_nees": {**CREDIBLE, "transitions": COVARIANCES / 2},
    "estimation_error_bounds": {"covariances": COVARIANCES, "sigma": 2.0},
    "excess_nll": {"nees_values": VALUES, "dof": 2.0},
    "fading_memory_nis": {**NIS, "factor": 0.5},
    "gaussian_crps": CREDIBLE,
    "gospa": {**SETS, "alpha": 2.0},
    "gospa_from_distances": {**MATRIX, "alpha": 2.0},
    "gospa_over_time": {**FRAMES, "alpha": 2.0},
    "hotelling_test": {"errors": ERRORS, **TESTED},
    "identity_switches": {**LABELLED, "time_indices": LABELS},
    "inclination_index": {**CREDIBLE, **TESTED},
    "marginal_nees": STATE,
    "monte_carlo_rmse": {"errors": ERRORS, "axis": 0},
    "mot_metrics": {"ground_truth": [POINTS], "estimates": [POINTS], "threshold": 3.0},
    "moving_average_nis": {**NIS, "window": 2},
    "nees": STATE,
    "nees_correlation_time": {"transitions": COVARIANCES / 2, "covariances": COVARIANCES},
    "nees_over_time": {"nees_values": VALUES, "dof": 2.0, **TESTED},
    "nees_sequence": {**STATES, "covariances": COVARIANCES},
    "nis": {"innovation": ERRORS[0], "innovation_covariance": np.eye(2)},
    "nis_sequence": INNOVATIONS,
    "noncredibility_index": CREDIBLE,
    "normalized_mean_error": {**CREDIBLE, **TESTED},
    "ospa": SETS,
    "ospa2": {"truth": TRACKS, "tracks": TRACKS, "c": 10.0, "p": 2.0, "q": 1.0, "window": 5.0},
    "ospa_assignment": SETS,
    "ospa_from_distances": MATRIX,
    "ospa_over_time": FRAMES,
    "pit_test": {"values": VALUES, "dof": 2.0, **TESTED},
    "position_rmse": {**STATES, "position_indices": [0]},
    "rmse": STATES,
    "set_threads": {"count": 1},
    "subspace_nees": {**STATE, "indices": [0]},
    "track_fragmentation": {**LABELLED, "time_indices": LABELS},
    "track_purity": LABELLED,
    "trajectory_gospa": {"truth": TRACKS, "tracks": TRACKS, "c": 10.0, "p": 2.0, "gamma": 1.0},
    "use_backend": {"name": "numpy"},
    "velocity_rmse": {**STATES, "velocity_indices": [0]},
    "whiteness": {**INNOVATIONS, "lags": 2, **TESTED},
    "whiteness_across_runs": {
        "innovations": ERRORS.reshape(2, 2, 2),
        "innovation_covariances": COVARIANCES.reshape(2, 2, 2, 2),
        "lag": 1,
        **TESTED,
    },
}
NOT_REAL = {
    "a word": "a",
    "None": None,
    "complex": 1 + 2j,
    "an array": np.array([1.0, 2.0]),
    "a set": {1.0},
    "a mapping": {"a": 1.0},
    "a huge number": 10**400,
    "not a number": np.nan,
    "words": ["a", "b"],
    "ragged": [[1.0, 2.0], [3.0]],
    "complex array": np.array([[1j, 2.0], [0.0, 1.0]]),
    "empty": np.empty((0, 2)),
    "empty list": [],
    "an object": object(),
    "a date": np.datetime64("2020-01-01"),
    "three axes": np.ones((1, 2, 3)),
}
CASES = [
    (name, argument)
    for name, good in GOOD.items()
    for argument in good
    if argument != "cost_matrix"
]


SCIPYS = {"linear_sum_assignment", "linear_sum_assignment_batch"}
"""These say what SciPy says, as do all of a cost matrix; other tests compare them."""
PLAIN = {"backend", "threads", "patch_pytcl", "unpatch_pytcl"}


def said(name, argument, value, backend):
    """The error, or None where the value is taken."""
    function, arguments = getattr(tm, name), {**GOOD[name], argument: value}
    with tm.use_backend(backend):
        try:
            function(**arguments)
        except Exception as error:
            return type(error), str(error)
    return None


def test_every_public_function_is_here():
    functions = {name for name in tm.__all__ if inspect.isfunction(getattr(tm, name))}
    assert functions - SCIPYS - PLAIN == set(GOOD)


@pytest.mark.parametrize("name", GOOD)
def test_what_is_right_is_taken(name):
    argument = next(iter(GOOD[name]))
    for backend in ("native", "numpy"):
        assert said(name, argument, GOOD[name][argument], backend) is None


@pytest.mark.parametrize(("name", "argument"), CASES)
def test_what_is_wrong_is_named(name, argument):
    """A wrong shape may be told by what does not fit it: then that argument, or the axis, is."""
    for what, value in NOT_REAL.items():
        native, reference = (
            said(name, argument, value, backend) for backend in ("native", "numpy")
        )
        assert native == reference, what
        if native is not None:
            kind, text = native
            assert issubclass(kind, TypeError | ValueError), (what, native)
            fits = "has shape" in text or "coordinates, expected" in text
            names = GOOD[name] if fits else [argument, "axis"]
            assert any(re.search(rf"\b{one}\b", text) for one in names), (what, native)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("a", "c must be a real number, got 'a'"),
        ("5", "c must be a real number, got '5'"),
        (None, "c must be a real number, got None"),
        (1 + 2j, "c must be a real number, got (1+2j)"),
        ([5.0], "c must be a real number, got list"),
        (
            np.array([1, 2]),
            "c must be a real number, got an array of shape (2,) and dtype int64",
        ),
    ],
)
@pytest.mark.parametrize("name", ["ospa", "gospa", "ospa_over_time", "ospa_from_distances"])
def test_a_cutoff_that_is_not_a_number(name, value, text):
    for backend in ("native", "numpy"):
        assert said(name, "c", value, backend) == (TypeError, text)


@pytest.mark.parametrize("value", [5, np.float32(5), np.int8(5), np.array(5.0), True + 4])
def test_every_real_number_is_a_cutoff(value):
    for backend in ("native", "numpy"):
        with tm.use_backend(backend):
            assert tm.ospa(POINTS, POINTS + 1, c=value, p=1) == tm.ospa(POINTS, POINTS + 1, 5.0, 1)
