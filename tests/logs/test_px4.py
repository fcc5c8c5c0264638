"""Flight logs of PX4: every figure of a log recomputed from the raw topics."""

import numpy as np
import pytest

from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import px4, read_log

pyulog = pytest.importorskip("pyulog")


def topic(path, name):
    return next(t.data for t in pyulog.ULog(str(path)).data_list if t.name == name)


def expected(innovation, variance):
    """Innovations and variances without repeats and without variances that are not positive."""
    kept, last = [], None
    for v, s in zip(np.asarray(innovation, float), np.asarray(variance, float), strict=True):
        if (v, s) != last and s > 0:
            kept.append((v, s))
        last = v, s
    return np.array(kept)


@pytest.mark.data
def test_the_first_generation_without_time_stamps(data):
    path = data / "px4" / "sample.ulg"
    log = read_log(path)
    raw = topic(path, "ekf2_innovations")
    pairs = expected(raw["hagl_innov"], raw["hagl_innov_var"])
    assert log.tracks == ("height above ground (m)",)
    np.testing.assert_array_equal(log.columns.innovation[:, 0], pairs[:, 0])
    np.testing.assert_allclose(log.columns.nis, pairs[:, 0] ** 2 / pairs[:, 1], rtol=1e-12)
    assert (np.diff(log.columns.time) >= 1).all()


def nearest(one, other):
    """The row of another topic nearest in time to each row of one."""
    key = "timestamp_sample" if "timestamp_sample" in one else "timestamp"
    apart = np.abs(one[key].astype(float)[:, None] - other[key].astype(float))
    assert (apart.min(axis=1) <= 50_000).all()
    return apart.argmin(axis=1)


@pytest.mark.data
@pytest.mark.parametrize("name", ["sample_log_small", "sample_px4_events"])
def test_the_second_generation(data, name):
    path = data / "px4" / f"{name}.ulg"
    log = read_log(path)
    innovations = topic(path, "estimator_innovations")
    variances = topic(path, "estimator_innovation_variances")
    ratios = topic(path, "estimator_innovation_test_ratios")
    place, tested = (nearest(innovations, other) for other in (variances, ratios))
    variances = {name: values[place] for name, values in variances.items()}
    fused = [f for f in innovations if f in variances and not f.startswith("timestamp")]
    fused = [f for f in fused if len(expected(innovations[f], variances[f]))]
    assert set(log.tracks) == {px4.full_name(f) for f in fused}
    for field in fused:
        own = log[px4.full_name(field)]
        pairs = expected(innovations[field], variances[field])
        np.testing.assert_array_equal(own.innovation[:, 0], pairs[:, 0])
        np.testing.assert_array_equal(own.S[:, 0, 0], pairs[:, 1])
        assert set(own.nis_dof) == {1.0}
        many = np.abs(ratios[field][tested]) > 1
        assert ((own.status == "rejected").sum() > 0) == bool(many.any())


@pytest.mark.data
def test_every_sensor_has_a_verdict(data):
    log = read_log(data / "px4" / "sample_px4_events.ulg")
    found = diagnose(log)
    assert found["barometer position down (m)"].verdict == "pessimistic"


class Topic:
    def __init__(self, name, multi_id=0, **fields):
        self.name, self.multi_id = name, multi_id
        self.data = {key: np.array(values) for key, values in fields.items()}


class Log:
    start_timestamp = 1_000_000

    def __init__(self, *topics):
        self.data_list = list(topics)


def test_the_third_generation_and_several_filters(monkeypatch, tmp_path):
    fields = {
        "timestamp": [1_000_000, 1_100_000, 1_200_000, 1_300_000],
        "innovation[0]": [0.5, 0.5, -2.0, 0.1],
        "innovation[1]": [0.1, 0.1, 0.2, 0.0],
        "innovation_variance[0]": [1.0, 1.0, 1.0, 1.0],
        "innovation_variance[1]": [1.0, 1.0, 1.0, 0.0],
        "innovation_rejected": [0, 0, 1, 0],
    }
    made = Log(
        Topic("estimator_aid_src_gnss_pos", 0, **fields),
        Topic("estimator_aid_src_gnss_pos", 1, **fields),
        Topic("estimator_innovations", 0, timestamp=[1], gps_vpos=[1.0]),
    )
    monkeypatch.setattr(pyulog, "ULog", lambda path: made)
    (tmp_path / "flight.ulg").write_bytes(b"ULog")
    log = read_log(tmp_path / "flight.ulg")
    assert len(log.tracks) == 4
    own = log["GNSS position north (m), filter 1"]
    assert own.time.tolist() == pytest.approx([0.0, 0.2, 0.3])
    assert own.innovation[:, 0].tolist() == [0.5, -2.0, 0.1]
    assert own.status.tolist() == ["active", "rejected", "active"]
    assert own.measurement_type[0] == "GNSS position north (m)"
    assert len(log["GNSS position east (m), filter 0"]) == 2


def test_a_log_without_innovations_says_what_it_lacks(monkeypatch, tmp_path):
    monkeypatch.setattr(pyulog, "ULog", lambda path: Log(Topic("vehicle_status", timestamp=[1])))
    (tmp_path / "flight.ulg").write_bytes(b"ULog")
    with pytest.raises(ValueError, match=r"flight.ulg: no innovations; expected a topic ekf2"):
        read_log(tmp_path / "flight.ulg")


def test_names_say_sensor_axis_and_unit():
    assert px4.full_name("mag_field[2]") == "magnetometer field z (gauss)"
    assert px4.full_name("ev_hpos[0]") == "external vision position north (m)"
    assert px4.full_name("rng_vpos") == "range finder position down (m)"
    assert px4.full_name("unheard_of[1]") == "unheard_of[1]"
