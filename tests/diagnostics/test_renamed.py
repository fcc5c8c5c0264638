"""Old names of parameters and fields of the diagnosis are still read, with a warning."""

import numpy as np
import pytest

from trackmetrics.diagnostics import LiveMonitor, diagnose
from trackmetrics.logs import EstimatorLog

NIS = np.random.default_rng(3).chisquare(2, 40) * np.repeat([1.0, 9.0], [30, 10])
LOG = EstimatorLog.from_columns(
    nis=NIS, nis_dof=2, error=np.ones((40, 2)), P=np.tile(np.eye(2), (40, 1, 1))
)

OF_TRACK = {"tentative": "updates_without_nis"}
OF_QUANTITY = {
    "settle_index": "settling_index",
    "settle_time": "settling_time",
    "inflation": "autocorrelation_time",
}
OF_STATE = {
    "support": "num_direct_updates",
    "supported": "is_observed",
    "share": "nees_share",
    "nees": "shapley_nees",
    "marginal": "marginal_nees",
    "unique": "conditional_nees",
}


def same(a, b):
    return a == b or (a != a and b != b)


@pytest.mark.parametrize(
    ("part", "names"),
    [
        (lambda track: track, OF_TRACK),
        (lambda track: track.nees, OF_QUANTITY),
        (lambda track: track.states[0], OF_STATE),
    ],
)
def test_an_old_field_is_the_new_one(part, names):
    result = part(diagnose(LOG)["track"])
    for old, new in names.items():
        with pytest.warns(DeprecationWarning, match=rf"\.{old} is now .*\.{new}"):
            assert same(getattr(result, old), getattr(result, new))
        assert old not in result.to_dict()


def test_old_parameters_are_read():
    with pytest.warns(DeprecationWarning, match="alpha"):
        old = diagnose(LOG, level=0.01)
    assert old.to_dict() == diagnose(LOG, alpha=0.01).to_dict()
    with pytest.warns(DeprecationWarning, match=r"LiveMonitor\(.*=\) is now") as warned:
        monitor = LiveMonitor(horizon=9, chance=0.02, too_large=3.0, too_small=0.3)  # _deprecated.
    assert len(warned) == 3
    assert monitor.threshold == LiveMonitor(horizon=9, alpha=0.02).threshold
    status = monitor.update(9.0, 2)
    with pytest.warns(DeprecationWarning, match="cusum_high"):
        assert status.too_large == status.cusum_high
