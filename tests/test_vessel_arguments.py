"""Settings, noise and reports refuse what they cannot use, and name it."""

import numpy as np
import pytest

from trackmetrics._angles import wrap
from trackmetrics.vessel import Noise, Reports, Settings, Tracker, simulate, three_ships
from trackmetrics.vessel.simulation import Ship

BASE = {
    "time": [0.0, 60.0, 120.0],
    "lat": [50.0, 50.003, 50.006],
    "lon": [1.0, 1.0, 1.0],
    "sog": [10.8] * 3,
    "cog": [0.0] * 3,
    "vessel": ["T"] * 3,
}
DENSITIES = ("acceleration_density", "turn_density", "course_density")
POSITIVE = (
    "turn_rate_decay",
    "coast_after",
    "delete_after",
    "turn_rate_std",
    "max_speed",
    "gate_probability",
)
BAD = [np.nan, -1.0, True, np.True_, "10", None, [1.0], 1j]


@pytest.mark.parametrize("given", [*BAD, 0.0, np.inf])
@pytest.mark.parametrize("name", ["position", "speed", "course"])
def test_noise(name, given):
    with pytest.raises((TypeError, ValueError), match=f"^{name} must be "):
        Noise(**{"position": 10.0, name: given})


@pytest.mark.parametrize("given", BAD)
@pytest.mark.parametrize("name", [*DENSITIES, *POSITIVE, "num_tentative"])
def test_settings(name, given):
    with pytest.raises((TypeError, ValueError), match=f"^{name} must be "):
        Settings(**{name: given})


@pytest.mark.parametrize(
    ("name", "given"),
    [
        *(
            (name, np.inf)
            for name in (*DENSITIES, "turn_rate_std", "max_speed", "gate_probability")
        ),
        *((name, 0.0) for name in (*POSITIVE, "num_tentative")),
        ("gate_probability", 1.0),
        ("num_tentative", 1.5),
        ("trust_missing_values", "no"),
        ("trust_missing_values", 1),
        ("ais", 10.0),
        ("position", (10.0, 1.0)),
    ],
)
def test_settings_outside_their_range(name, given):
    with pytest.raises((TypeError, ValueError), match=f"^{name} must be "):
        Settings(**{name: given})


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("time", [0.0, np.nan, 2.0], r"time\[1\] must be finite, got nan"),
        ("time", ["a", "b", "c"], "time must hold real numbers, got 'a'"),
        ("lat", [91.0, 50.0, 50.0], r"lat\[0\] must be finite and between -90 and 90, got 91"),
        ("lat", [50.0, np.nan, 50.0], r"lat\[1\] must be finite and between -90 and 90, got nan"),
        ("lon", [1.0, 1e6, 1.0], r"lon\[1\] must be finite and between -360 and 360"),
        ("lon", [True] * 3, "lon must hold real numbers, got True"),
        ("sog", [1.0, np.inf, 1.0], r"sog\[1\] must be finite, or NaN where it is not available"),
        ("sog", ["1", "2", "3"], "sog must hold real numbers, got '1'"),
        ("cog", [1.0, "x", None], "cog must hold real numbers, got"),
        ("lat", 50.0, r"lat has shape \(\), expected \(n,\)"),
        ("vessel", "T", "vessel has 1 reports, time has 3"),
        ("lat", np.ma.masked_array(BASE["lat"], [0, 1, 0]), r"lat\[1\] must be finite"),
    ],
)
def test_columns_of_reports(name, given, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        Reports.from_columns(**BASE | {name: given})


def test_what_is_not_available_stays_allowed():
    reports = Reports.from_columns(**BASE | {"sog": [None, 102.3, -1.0], "cog": None})
    assert reports.kinds == ("truncated AIS",) * 3
    dates = np.array([0, 60, 120], "M8[s]").astype("M8[ns]")
    assert Reports.from_columns(**BASE | {"time": dates}).time.tolist() == BASE["time"]
    nameless = Reports.from_columns(**BASE | {"vessel": ["", None, np.nan]})
    assert nameless.vessel.tolist() == [None] * 3


@pytest.mark.parametrize("column", range(4))
def test_the_message_about_a_report_names_the_field(column):
    reports = Reports.from_columns(**BASE)
    reports.z[1, column] = np.nan
    name = ("lat", "lon", "sog", "cog")[column]
    tracker = Tracker()
    with pytest.raises(ValueError, match=f"^{name} of the report at time 60.0 is not finite: nan$"):
        tracker.add(reports)
    assert tracker.tracks() == ()


def test_half_a_turn_stays_positive():
    assert wrap(np.array([180.0, -180.0, 190.0]), 360.0).tolist() == [180.0, 180.0, -170.0]


def test_a_simulated_ship_is_checked():
    ship = Ship("a", (50.0, 1.0, 10.0, 90.0), (0.0, 60.0), (0, 0))
    run = simulate([ship], Settings(), {"a": Settings()}, begin=0.0, end=100.0, seed=0)
    assert len(run.reports["a"]) == 2


def test_the_old_names_of_the_noise_are_read():
    with pytest.warns(DeprecationWarning, match=r"is now three_ships\(noise='published'\)"):
        old = three_ships(1, "article")
    new = three_ships(1, "published")
    ship = "MV Iron Falcon2"
    assert np.array_equal(old.reports[ship].z, new.reports[ship].z, equal_nan=True)
