"""The diagnosis of filters with known faults, simulated with truth: a small table of rates."""

import numpy as np
import pytest

from trackmetrics import use_backend
from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog, State

F = np.kron(np.eye(2), [[1.0, 5.0], [0.0, 1.0]])
Q = np.kron(np.eye(2), 0.5 * np.array([[125 / 3, 12.5], [12.5, 5.0]]))
H = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0]])
STATES = [State("x", "m"), State("vx", "m/s"), State("y", "m"), State("vy", "m/s")]


def simulate(runs=50, updates=80, q=1.0, r=1.0, bias=0.0, push=0.0, seed=0):
    """Constant velocity, two position sensors in turn; the filter claims q Q and r R."""
    rng = np.random.default_rng(seed)
    P = np.diag([100.0, 25.0, 100.0, 25.0])
    truth = np.zeros((runs, 4))
    x = rng.normal(size=(runs, 4)) * [10.0, 5.0, 10.0, 5.0]
    columns = {name: [] for name in ("innovation", "S", "error", "P", "P_pred", "A")}
    for k in range(updates):
        std = (10.0, 15.0)[k % 2]
        truth = truth @ F.T + rng.normal(size=(runs, 4)) @ np.linalg.cholesky(Q).T
        if k >= 0.7 * updates:
            truth = truth + push * np.array([12.5, 5.0, -12.5, -5.0])
        z = truth @ H.T + std * rng.normal(size=(runs, 2)) + [bias * std * (k % 2), 0.0]
        predicted, P_pred = x @ F.T, F @ P @ F.T + q * Q
        S = H @ P_pred @ H.T + r * std**2 * np.eye(2)
        K = np.linalg.solve(S, H @ P_pred).T
        innovation = z - predicted @ H.T
        x, P = predicted + innovation @ K.T, P_pred - K @ S @ K.T
        row = (innovation, S, x - truth, (P + P.T) / 2, P_pred, (np.eye(4) - K @ H) @ F)
        for name, value in zip(columns, row, strict=True):
            full = (runs, *np.shape(value)[-2 if np.shape(value)[0] != runs else 1 :])
            columns[name].append(np.broadcast_to(value, full))
    return EstimatorLog.from_columns(
        track=np.repeat([f"run {i}" for i in range(runs)], updates),
        time=np.tile(5.0 * np.arange(updates), runs),
        measurement_type=["near", "far"] * (runs * updates // 2),
        observed=[["x", "y"]] * (runs * updates),
        states=STATES,
        **{
            name: np.stack(v, axis=1).reshape(runs * updates, *v[0].shape[1:])
            for name, v in columns.items()
        },
    )


def share(found, verdict):
    return np.mean([track.verdict == verdict for track in found.values()])


def test_well_tuned_filters_are_consistent():
    found = diagnose(simulate(runs=150))
    assert share(found, "consistent") >= 0.92
    first = found["run 0"]
    assert first.nees.autocorrelation_time == pytest.approx(1.98, abs=0.1)
    assert [s.observed_by for s in first.states] == [("near", "far"), (), ("near", "far"), ()]
    assert first.states[0].num_direct_updates == 80
    assert 0 < first.states[0].information_gain < 1


CAUSES = {
    "process noise too small": ({"q": 0.1}, "optimistic"),
    "measurement noise too small": ({"r": 0.25}, "optimistic"),
    "process noise too large": ({"q": 10.0}, "pessimistic"),
    "measurement noise too large": ({"r": 4.0}, "pessimistic"),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_a_noise_that_is_wrong_is_found_and_no_wrong_cause_named(cause):
    fault, verdict = CAUSES[cause]
    found = diagnose(simulate(**fault))
    assert share(found, verdict) >= 0.94
    causes = [track.cause for track in found.values()]
    assert causes.count(cause) >= 25
    assert set(causes) <= {cause, None}


def test_a_biased_sensor_is_named_with_its_offset():
    found = diagnose(simulate(bias=1.5))
    assert share(found, "biased") >= 0.9
    values = [b.value for t in found.values() for b in t.biases if b.kind == "innovation"]
    named = {
        (b.measurement_type, b.component, b.unit) for t in found.values() for b in t.biases[:1]
    }
    assert ("far", "x", "m") in named
    # The filter follows the bias in part, so that the innovation shows less than all of it.
    assert 8.0 < np.median(np.abs(values)) < 22.5


def test_a_late_manoeuvre_is_late_and_in_the_velocities():
    found = diagnose(simulate(push=1.5))
    assert share(found, "late_divergence") >= 0.98
    onsets = [track.nis.onset_index for track in found.values()]
    assert 55 <= np.median(onsets) <= 59
    assert {track.weakest_state for track in found.values()} <= {"vx", "vy"}
    states = found["run 0"].states
    assert sum(s.nees_share for s in states) == pytest.approx(1.0)
    assert found["run 0"].text.count("The weakest state is v") == 1


def test_both_backends_say_the_same_of_full_rows():
    log = simulate(runs=5, updates=40, push=1.5)
    with use_backend("numpy"):
        reference = diagnose(log)
    for name, track in diagnose(log).items():
        assert reference[name].verdict == track.verdict
        assert reference[name].weakest_state == track.weakest_state
        assert reference[name].states[1].nees_share == pytest.approx(
            track.states[1].nees_share, rel=1e-9
        )


def test_many_states_are_split_by_drawn_orders():
    rng = np.random.default_rng(0)
    error = rng.normal(size=(30, 12))
    error[20:, 7] += 10
    log = EstimatorLog.from_columns(error=error, P=np.tile(np.eye(12), (30, 1, 1)))
    track = diagnose(log)["track"]
    assert track.verdict == track.nees.verdict == "late_divergence"
    assert track.nis.verdict == "insufficient"
    assert track.weakest_state == "x[7]"
    assert track.states[7].shapley_nees == pytest.approx((error[20:, 7] ** 2).mean(), rel=1e-6)


def test_a_bias_of_the_state_needs_truth():
    rng = np.random.default_rng(3)
    error = rng.normal([0.0, 1.2], size=(80, 2))
    log = EstimatorLog.from_columns(
        error=error, P=np.tile(np.eye(2), (80, 1, 1)), nis=rng.chisquare(2, 80), nis_dof=2
    )
    track = diagnose(log)["track"]
    assert (track.nis.verdict, track.nees.verdict, track.verdict) == (
        "consistent",
        "biased",
        "biased",
    )
    assert [(b.kind, b.component) for b in track.biases] == [("state", "x[1]")]
    assert track.biases[0].value == pytest.approx(1.2, abs=0.3)


# -- correlation in time, and size and correlation at once


def innovations(values):
    from trackmetrics.diagnostics.innovations import Innovations

    n, m = values.shape
    return Innovations(values, np.tile(np.eye(m), (n, 1, 1)), np.full(n, "", object))


@pytest.mark.parametrize("skewness", [0.05, 0.4, 1.2])
def test_a_skewed_value_becomes_a_normal_one(skewness):
    from scipy import stats

    from trackmetrics import _distributions

    distribution = stats.pearson3(skewness)
    for value in (-1.5, -0.3, 0.0, 0.8, 2.5, 6.0):
        expected = stats.norm.isf(distribution.sf(value))
        found = _distributions.pearson3_to_z(value, skewness)
        assert found == pytest.approx(expected, abs=1e-7)
    assert _distributions.pearson3_to_z(1.7, 0.0) == 1.7
    assert np.isfinite(_distributions.pearson3_to_z(-50.0, skewness))
    assert np.isfinite(_distributions.pearson3_to_z(1e9, skewness))


@pytest.mark.parametrize("alternating", [True, False])
def test_the_correlation_is_the_weighted_sum_over_lags(alternating):
    from scipy import stats

    from trackmetrics.diagnostics.whiteness import (
        NEGATIVE_WEIGHTS,
        POSITIVE_WEIGHTS,
        innovation_correlation,
    )

    rng = np.random.default_rng(1)
    x = rng.normal(size=(41, 2))
    x[1:] += (-0.5 if alternating else 0.5) * x[:-1]
    x = np.clip(x, -2.0, 2.0)
    weights = NEGATIVE_WEIGHTS if alternating else POSITIVE_WEIGHTS
    total = third = 0.0
    for lag, w in enumerate(weights, 1):
        shared = sum(x[k, j] * x[k + lag, j] for k in range(41 - lag) for j in range(2))
        power = sum(x[k, j] ** 2 + x[k + lag, j] ** 2 for k in range(41 - lag) for j in range(2))
        total += w * 2 * shared / power * np.sqrt(2 * (41 - lag))
        for other, v in enumerate(weights, 1):
            if lag + other <= len(weights):
                third += w * v * weights[lag + other - 1]
    size = np.sqrt(sum(w**2 for w in weights))
    distribution = stats.pearson3(6 * third / size**3 / np.sqrt(2 * 40))
    found = innovation_correlation(innovations(x))
    assert found.z == pytest.approx(stats.norm.isf(distribution.sf(total / size)), rel=1e-6)
    assert (found.z < 0) == alternating


def test_white_innovations_pass_as_often_as_they_should():
    from trackmetrics.diagnostics.whiteness import innovation_correlation

    rng = np.random.default_rng(2)
    p = np.array(
        [innovation_correlation(innovations(rng.normal(size=(60, 2)))).p_value for _ in range(3000)]
    )
    # Binomial bounds of four standard deviations above 5 % and 0.4 %.
    assert (p < 0.05).mean() < 0.066
    assert (p < 0.004).mean() < 0.009
    assert (p < 0.05).mean() > 0.03


def small_and_alternating(n=100, scale=0.68, lag1=-0.25, seed=0):
    """Innovations of exactly this size and correlation, neither of which says enough alone."""
    noise = np.random.default_rng(seed).normal(size=n + 1)
    x = noise[1:] + lag1 * noise[:-1]
    return x[:, None] * np.sqrt(scale / np.mean(x**2))


def test_size_and_correlation_together_say_what_neither_does_alone():
    from trackmetrics.diagnostics.thresholds import ALPHA

    found = []
    for seed in range(40):
        x = small_and_alternating(seed=seed)
        log = EstimatorLog.from_columns(innovation=x, S=np.ones((len(x), 1, 1)))
        track = diagnose(log)["track"]
        alone = track.whiteness.p_value < ALPHA or track.nis.segments[0].p_value < ALPHA
        if not alone:
            found.append(track.verdict)
    assert len(found) >= 10
    # Neither test by itself says a word of these.
    assert found.count("pessimistic") >= 0.5 * len(found)
    assert set(found) <= {"pessimistic", "consistent"}


def test_correlated_innovations_are_called_by_the_size_of_the_errors():
    # Of the right size by themselves, but alternating; errors half as large as claimed.
    x = small_and_alternating(n=120, scale=1.0, lag1=-0.6)
    rng = np.random.default_rng(3)
    columns = {"innovation": x, "S": np.ones((120, 1, 1)), "P": np.tile(np.eye(2), (120, 1, 1))}
    alone = diagnose(EstimatorLog.from_columns(**columns, error=rng.normal(size=(120, 2))))
    assert alone["track"].nis.verdict == "non_white"
    errors = np.sqrt(0.81) * rng.normal(size=(120, 2))
    small = diagnose(EstimatorLog.from_columns(**columns, error=errors))["track"]
    assert small.nees.verdict == "consistent"
    assert (small.nis.verdict, small.verdict) == ("pessimistic", "pessimistic")
