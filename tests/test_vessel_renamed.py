"""Old names of the arguments and fields of the vessel estimator and of sweeps are still read."""

import pickle

import numpy as np
import pytest

from trackmetrics import vessel
from trackmetrics.monte_carlo import ScoreAccumulator

OLD_SETTINGS = {  # old name: new name, a value
    "tentative": ("num_tentative", 3),  # _deprecated.
    "placeholders": ("trust_missing_values", True),  # _deprecated.
    "gate": ("gate_probability", 0.9),  # _deprecated.
}
OLD_FLEET = {
    "interval": ("report_interval", 30.0),
    "shares": ("type_shares", (1.0, 0.0, 0.0)),
    "outages": ("outage_rate", 1.0),
    "outage": ("outage_duration", 600.0),
    "rate": ("turn_rate", 0.2),
    "spread": ("start_std", 1000.0),
}


@pytest.mark.parametrize("old", OLD_SETTINGS)
def test_old_settings(old):
    new, value = OLD_SETTINGS[old]
    with pytest.warns(DeprecationWarning, match=rf"Settings\({old}=\) is now Settings\({new}=\)"):
        settings = vessel.Settings(**{old: value})
    assert settings == vessel.Settings(**{new: value})
    with pytest.warns(DeprecationWarning, match=rf"Settings\.{old} is now Settings\.{new}"):
        assert getattr(settings, old) == value
    assert pickle.loads(pickle.dumps(settings)) == settings


@pytest.mark.parametrize("old", OLD_FLEET)
def test_old_arguments_of_a_fleet(old):
    new, value = OLD_FLEET[old]
    others = {"duration": 1200.0, "manoeuvres": 1.0, "seed": 3}
    with pytest.warns(DeprecationWarning, match=rf"fleet\({old}=\) is now fleet\({new}=\)"):
        found = vessel.fleet(2, **{old: value}, **others)
    expected = vessel.fleet(2, **{new: value}, **others)
    for ship in expected.ships:
        np.testing.assert_array_equal(found.truth[ship], expected.truth[ship])


def test_old_fields_of_a_recording():
    row = {"time": 0, "vessel": "1", "lat": 50, "lon": 1, "sog": 9.0, "cog": 90.0}
    recording = vessel.screen_rows([row, row])
    with pytest.warns(DeprecationWarning, match="rejected"):
        assert recording.set_aside == recording.rejected
    with pytest.warns(DeprecationWarning, match="duplicate_mmsi"):
        assert recording.shared == recording.duplicate_mmsi == ()
    with pytest.warns(DeprecationWarning, match="duplicate_mmsi"):
        assert vessel.Tracker().shared == ()


def test_old_methods_of_accumulators():
    accumulator = ScoreAccumulator()
    with pytest.warns(DeprecationWarning, match="add_empty_runs"):
        accumulator.skip(0, 2)
    with pytest.warns(DeprecationWarning, match="intervals"):
        assert accumulator.covered == accumulator.intervals == [(0, 2)]
