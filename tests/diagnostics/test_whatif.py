"""Predictions under other noises: against closed forms, a filter that is really run, and truth."""

import math

import numpy as np
import pytest

from trackmetrics.diagnostics import estimate_noise, whatif
from trackmetrics.logs import EstimatorLog


def run(z, q=4.0, r=9.0):
    """A random walk's filter over measurements; columns, and mean NIS."""
    x, P, rows, nis = 0.0, 100.0, [], []
    for value in z:
        P_pred, x_pred = P + q, x
        S, nu = P_pred + r, value - x_pred
        x, P = x_pred + P_pred / S * nu, (1 - P_pred / S) * P_pred
        nis.append(nu**2 / S)
        rows.append(([nu], [[S]], [[P_pred]], [[P]], [[1 - P_pred / S]], [x], [x_pred]))
    names = ("innovation", "S", "P_pred", "P", "A", "x", "x_pred")
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True)), float(np.mean(nis))


def measured(q, r, updates=4000, seed=0):
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(size=updates)) * math.sqrt(q)
    return truth, truth + rng.normal(size=updates) * math.sqrt(r)


def log_of(columns):
    rows = len(columns["x"])
    return EstimatorLog.from_columns(
        states=["level"], observed=[["level"]] * rows, measurement_type=["gauge"] * rows, **columns
    )


def test_the_filter_run_again_is_the_filter_with_other_noises():
    _, z = measured(8.0, 27.0, 500)
    columns, before = run(z)
    _, after = run(z, 8.0, 27.0)
    found = whatif(log_of(columns), process=2.0, measurement={"gauge": 3.0})
    assert found.nis_before == pytest.approx(before, rel=1e-9)
    # The first prediction keeps its claimed covariance, 104 instead of 108.
    assert found.nis_after == pytest.approx(after, rel=1e-4)
    assert found.p_value_before < 1e-6 < 0.001 < found.p_value_after


def test_predictions_are_what_simulation_gives():
    truth, z = measured(8.0, 27.0)
    columns, before = run(z)
    again, _ = run(z, 8.0, 27.0)
    found = whatif(log_of(columns), process=2.0, measurement=3.0)
    claimed, own, new = found.rmse["level"]
    assert found.nis_expected == pytest.approx(before, rel=0.05)
    assert own == pytest.approx(np.sqrt(np.mean((np.ravel(columns["x"]) - truth) ** 2)), rel=0.05)
    assert new == pytest.approx(np.sqrt(np.mean((np.ravel(again["x"]) - truth) ** 2)), rel=0.05)
    assert claimed < new < own
    ((said, expected),) = found.innovation_std["gauge"]
    assert said == pytest.approx(math.sqrt(np.mean(columns["S"])), rel=1e-9)
    assert expected == pytest.approx(np.std(columns["innovation"]), rel=0.05)


def test_claims_that_are_right_change_nothing():
    _, z = measured(4.0, 9.0, 300)
    found = whatif(log_of(run(z)[0]))
    assert found.nis_before == found.nis_after
    assert found.nis_expected == pytest.approx(1, rel=1e-9)
    assert "NIS per degree of freedom" in repr(found)
    assert found.to_dict()["updates"] == 300


def test_an_estimate_is_taken_as_it_is():
    _, z = measured(4.0, 36.0, 60)
    log = log_of(run(z)[0])
    estimate = estimate_noise(log)
    found = whatif(log, process=estimate.process, measurement=estimate.measurement)
    assert found.nis_after == pytest.approx(1, abs=0.1)


def test_wrong_factors_are_named():
    log = log_of(run(measured(4.0, 9.0, 20)[1])[0])
    with pytest.raises(ValueError, match="measurement: no 'radar'; the log has gauge"):
        whatif(log, measurement={"radar": 2.0})
    with pytest.raises(ValueError, match=r"process\['all'\] must be at least 0, got -1.0"):
        whatif(log, process=-1)
