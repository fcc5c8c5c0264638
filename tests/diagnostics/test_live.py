"""The live monitor: its alarms, its rates, its memory."""

import numpy as np
import pytest

from trackmetrics.diagnostics import LiveMonitor, diagnose
from trackmetrics.diagnostics.cusum import first_alarms


def test_the_sums_are_the_definition():
    monitor = LiveMonitor(horizon=50, scale_high=2.0, scale_low=0.5)
    large = small = 0.0
    for nis, dof in zip([1.0, 8.0, 0.5, 9.0, 0.0], [2, 4, 2, 2, 2], strict=True):
        status = monitor.update(nis, dof)
        large = max(0.0, large - dof / 2 * np.log(2.0) + nis / 2 * 0.5)
        small = max(0.0, small + dof / 2 * np.log(2.0) - nis / 2)
        assert status.cusum_high == pytest.approx(large)
        assert status.cusum_low == pytest.approx(small)
    assert status.threshold == pytest.approx(np.log(2 * 50 / 0.01))
    assert status.updates == 5


@pytest.mark.parametrize(("scale", "alarm"), [(5.0, "optimistic"), (0.1, "pessimistic")])
def test_a_change_of_scale_is_called_with_its_onset(scale, alarm):
    rng = np.random.default_rng(0)
    monitor = LiveMonitor(horizon=200)
    for k in range(200):
        status = monitor.update(rng.chisquare(3) * (scale if k >= 100 else 1.0), 3, time=10.0 * k)
        if status.alarm:
            break
    assert status.alarm == alarm
    assert 100 < k < 130
    assert 900.0 <= status.onset <= 1100.0
    monitor.reset()
    assert monitor.status.alarm is None


def test_a_consistent_filter_raises_few_alarms():
    rng = np.random.default_rng(1)
    alarms = 0
    for _ in range(200):
        monitor = LiveMonitor(horizon=100, alpha=0.05)
        alarms += any(monitor.update(nis, 2).alarm for nis in rng.chisquare(2, 100))
    assert alarms <= 10


def test_offline_and_online_agree():
    rng = np.random.default_rng(3)
    values = rng.chisquare(2, 80) * np.where(np.arange(80) < 50, 1.0, 5.0)
    ((alarm, onset),) = first_alarms([(values, np.full(80, 2.0))], alpha=0.01)
    monitor = LiveMonitor(horizon=80, alpha=0.02)
    for k, nis in enumerate(values):
        status = monitor.update(nis, 2)
        if status.alarm:
            assert (k, status.onset) == (alarm, onset)
            return
    pytest.fail("no alarm")


def test_memory_is_bounded():
    monitor = LiveMonitor(horizon=10)
    for _ in range(1000):
        monitor.update(2.0, 2)
    assert all(np.size(v) <= 2 for v in vars(monitor).values())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"horizon": 0}, "horizon must be at least 1 and finite, got 0"),
        ({"horizon": 9, "alpha": 1.0}, "alpha must be between 0 and 1"),
        ({"horizon": 9, "scale_high": 1.0}, "scale_high must be above 1"),
        ({"horizon": 9, "scale_low": 0.0}, "scale_low must be between 0 and 1"),
    ],
)
def test_wrong_parameters_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        LiveMonitor(**arguments)


@pytest.mark.parametrize(("nis", "dof"), [(np.nan, 2), (-1.0, 2), (1.0, 0)])
def test_wrong_values_are_named(nis, dof):
    with pytest.raises(ValueError, match=r"nis must be|dof must be"):
        LiveMonitor(horizon=9).update(nis, dof)


def test_the_diagnosis_says_when_it_would_have_raised_an_alarm():
    from trackmetrics.logs import EstimatorLog

    nis = [2.0] * 40 + [30.0] * 5
    track = diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2))["track"]
    assert (track.nis.alarm_index, track.nis.alarm_onset_time) == (41, 40.0)
