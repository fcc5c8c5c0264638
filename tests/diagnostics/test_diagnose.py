"""The diagnosis: the published run, every verdict, evidence, determinism."""

import json

import numpy as np
import pytest

import trackmetrics
from trackmetrics.diagnostics import VERDICTS, diagnose
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.logs import EstimatorLog, State, read_log

STD = ["std_lat_deg", "std_lon_deg", "std_sog_kts", "std_cog_deg", "std_turn_rate"]
STATES = ["lat", "lon", "sog", "cog", "turn_rate"]


@pytest.fixture
def published(data):
    names = {"time": "t_rel_s", "nis": "nis_recovered", "nis_dof": "nis_df", "std": STD}
    return read_log(data / "published_run" / "updates.csv", columns=names, states=STATES)


@pytest.mark.data
def test_the_published_run(published):
    d = diagnose(published)
    falcon, aurora, northern = (
        d[t] for t in ("MV Iron Falcon2", "SS Iron Aurora1", "SS Northern Star0")
    )
    assert falcon.verdict == falcon.nis.verdict == falcon.nees.verdict == "startup_then_pessimistic"
    assert (falcon.nis.settling_time, falcon.nees.settling_time) == (2160.0, 3900.0)
    first, second = falcon.nis.segments
    assert (first.start_time, first.stop_time, second.start_time) == (780.0, 1980.0, 2160.0)
    assert first.scale == pytest.approx(4.04, abs=0.005)
    assert first.interval == pytest.approx((2.24, 9.36), abs=0.005)
    assert second.scale == pytest.approx(0.355, abs=5e-4)
    assert second.interval == pytest.approx((0.26, 0.52), abs=0.005)
    assert falcon.nees.scale == pytest.approx(0.297, abs=5e-4)

    assert aurora.nis.verdict == "pessimistic"
    assert aurora.nis.scale == pytest.approx(0.207, abs=5e-4)
    assert aurora.nis.interval == pytest.approx((0.15, 0.30), abs=0.005)
    assert len(aurora.nis.segments) == 1

    assert northern.verdict == northern.nis.verdict == northern.nees.verdict == "late_divergence"
    assert (northern.nis.onset_time, northern.nees.onset_time) == (4680.0, 6780.0)
    assert (northern.nis.alarm_time, northern.nis.alarm_onset_time) == (6780.0, 4680.0)
    assert northern.nees.segments[-1].scale == pytest.approx(39.5, abs=0.05)
    assert (northern.updates, northern.updates_without_nis) == (11, 2)
    assert northern.longest_gap == 1920.0
    assert "late divergence" in northern.text
    assert "6780 s" in northern.text


@pytest.mark.data
def test_the_published_run_with_its_support_names_the_turn_rate(data):
    seen = {"AISMeasurement": [0, 1, 2, 3]}
    names = {"time": "t_rel_s", "nis": "nis_recovered", "nis_dof": "nis_df", "std": STD}
    log = read_log(data / "published_run" / "updates.csv", columns=names, states=STATES)
    c = log.columns
    log = EstimatorLog.from_columns(
        track=[log.tracks[t] for t in range(3) for _ in range(log.starts[t], log.starts[t + 1])],
        time=c.time, nis=c.nis, nis_dof=c.nis_dof, nees=c.nees, std=c.std, states=STATES,
        measurement_type=c.measurement_type,
        observed=[seen.get(kind, [0, 1]) for kind in c.measurement_type],
    )  # fmt: skip
    northern = diagnose(log)["SS Northern Star0"]
    assert northern.weakest_state == "turn_rate"
    turn_rate = northern.states[4]
    assert (turn_rate.observed_by, turn_rate.num_direct_updates, turn_rate.is_observed) == (
        (),
        0,
        False,
    )
    cog = northern.states[3]
    assert cog.growth_onset_time == 3000.0
    assert cog.peak_growth == pytest.approx(19.08, abs=0.01)
    assert cog.longest_gap == 4620.0
    assert northern.observed["AISMeasurement"] == ("lat", "lon", "sog", "cog")


@pytest.mark.data
def test_the_repeated_rows_of_the_published_log_are_dropped(data):
    import csv

    with (data / "published_run" / "std.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "lat"]
    log = EstimatorLog.from_columns(
        track=[row["track"] for row in rows],
        time=[float(row["t_rel_s"]) for row in rows],
        std=[[float(row["std"])] for row in rows],
    )
    assert (len(rows), len(log)) == (116, 63)
    assert dict(zip(log.tracks, log.repeated, strict=True))["SS Northern Star0"] == 27


def scaled(scales, seed=0, dof=2):
    scales = np.asarray(scales, float)
    rng = np.random.default_rng(seed)
    return EstimatorLog.from_columns(nis=scales * rng.chisquare(dof, len(scales)), nis_dof=dof)


def steps(*pairs):
    return np.concatenate([np.full(n, s) for s, n in pairs])


PATTERNS = {
    "consistent": steps((1, 80)),
    "optimistic": steps((3, 80)),
    "pessimistic": steps((0.3, 80)),
    "late_divergence": steps((1, 60), (6, 20)),
    "startup_then_consistent": steps((8, 15), (1, 65)),
    "startup_then_pessimistic": steps((8, 15), (0.3, 65)),
    "transient": steps((1, 30), (8, 15), (1, 35)),
    "partly_pessimistic": steps((1, 60), (0.1, 20)),
    "insufficient": steps((1, 3)),
}


@pytest.mark.parametrize("verdict", PATTERNS)
def test_every_pattern_of_scales_has_its_verdict(verdict):
    track = diagnose(scaled(PATTERNS[verdict], seed=3))["track"]
    assert track.verdict == track.nis.verdict == verdict
    assert track.nees is None
    assert track.consistent == (verdict == "consistent")
    assert verdict.replace("_", " ") in track.text


def test_onset_settling_and_segments_are_where_the_scale_changes():
    late = diagnose(scaled(PATTERNS["late_divergence"], seed=3))["track"].nis
    assert abs(late.onset_index - 60) <= 2
    assert late.onset_time == late.onset_index == late.segments[-1].start
    assert [s.label for s in late.segments] == ["consistent", "optimistic"]
    assert late.segments[0].stop == late.segments[1].start
    assert 60 <= late.alarm_index <= 75
    startup = diagnose(scaled(PATTERNS["startup_then_consistent"], seed=3))["track"].nis
    assert abs(startup.settling_index - 15) <= 2


def test_outliers_are_reported_with_their_updates():
    rng = np.random.default_rng(5)
    nis = rng.chisquare(2, 60)
    nis[[20, 41]] = 60.0, 80.0
    track = diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2, time=np.arange(60) * 10.0))
    track = track["track"]
    assert track.verdict == "outliers"
    assert [(o.index, o.time) for o in track.outliers] == [(20, 200.0), (41, 410.0)]
    assert track.text.index("2 outliers (at 200 s, 410 s)") < track.text.index("NIS")


def test_a_diagnosis_is_deterministic_and_the_same_on_both_backends():
    from trackmetrics import use_backend

    rng = np.random.default_rng(7)
    log = EstimatorLog.from_columns(
        track=np.repeat([f"t{i}" for i in range(8)], 40),
        nis=rng.chisquare(2, 320) * np.repeat(rng.choice([0.3, 1.0, 4.0], 32), 10),
        nis_dof=rng.choice([2.0, 4.0], 320),
        nees=rng.chisquare(4, 320),
        state_dim=4,
    )
    with use_backend("native"):
        first, again = diagnose(log).to_dict(), diagnose(log).to_dict()
    with use_backend("numpy"):
        reference = diagnose(log).to_dict()
    assert json.dumps(first) == json.dumps(again)
    for name, track in first["tracks"].items():
        assert track["verdict"] == reference["tracks"][name]["verdict"]
        assert track["nis"]["onset_index"] == reference["tracks"][name]["nis"]["onset_index"]


def test_a_diagnosis_is_a_mapping():
    log = EstimatorLog.from_columns(track=["b"] * 5 + ["a"] * 5, nis=np.ones(10), nis_dof=2)
    d = diagnose(log)
    assert list(d) == ["b", "a"]
    assert len(d) == 2
    assert set(d) <= {t.track for t in d.values()}
    assert repr(d) == "Diagnosis({'b': 'consistent', 'a': 'consistent'})"
    assert json.loads(json.dumps(d.to_dict()))["tracks"]["a"]["nis"]["updates"] == 5
    with pytest.raises(KeyError, match="no track 'c'; the log has 'b', 'a'"):
        d["c"]
    assert all(track.verdict in VERDICTS for track in d.values())


def late(start, unit="s", spacing=10.0):
    """A log of two tracks, of which the second starts later and fails late."""
    rng = np.random.default_rng(3)
    nis = rng.chisquare(2, (2, 80))
    nis[1, 60:] *= 8
    times = start + spacing * np.array([np.arange(80), 5.5 + np.arange(80)])
    return EstimatorLog.from_columns(
        track=["early"] * 80 + ["late"] * 80,
        time=times.ravel(),
        nis=nis.ravel(),
        nis_dof=2,
        time_unit=unit,
    )


def test_sentences_count_times_from_the_start_of_the_log():
    epoch = diagnose(late(1771931555.0154023))
    track = epoch["late"]
    assert track.nis.onset_time == pytest.approx(1771931555.0154023 + 655.0)
    assert "the fault begins at 655 s" in track.text
    assert "55 to 645 s consistent" in track.text
    note = "Times count from the start of the log, 2026-02-24 11:12:35 UTC."
    assert track.text.endswith(note)
    assert track.text == f"{track.findings} {note}"
    assert "177193" not in epoch.text
    assert epoch.text.count(note) == 1
    assert epoch.text.endswith(note)


@pytest.mark.parametrize(
    ("start", "unit", "note"),
    [
        (0.0, "s", ""),
        (300.0, "s", "Times count from the start of the log, at 300 s."),
        (1771931555015.0, "ms", "Times count from the start of the log, 2026-02-24 11:12:35 UTC."),
        (1.8e9, "min", "Times count from the start of the log, at 1800000000 min."),
    ],
)
def test_the_start_is_said_once_and_as_a_moment_where_it_looks_like_one(start, unit, note):
    d = diagnose(late(start, unit))
    assert d["late"].timeline.origin_note == note
    assert f"the fault begins at 655 {unit}" in d.text
    assert d.text.count("Times count") == bool(note)


def test_one_update_is_insufficient():
    track = diagnose(EstimatorLog.from_columns(nis=[1.0], nis_dof=2))["track"]
    assert track.verdict == "insufficient"
    assert track.nis.segments == ()
    assert np.isnan(track.longest_gap)


def test_tentative_updates_are_not_judged():
    rng = np.random.default_rng(1)
    nis = np.concatenate([[500.0, 400.0], rng.chisquare(2, 40)])
    status = ["tentative"] * 2 + ["active"] * 40
    track = diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2, status=status))["track"]
    assert (track.verdict, track.updates_without_nis, track.nis.updates) == ("consistent", 2, 40)


@pytest.mark.parametrize("alpha", [0.0, -1.0, 0.2])
def test_an_alpha_outside_its_range_is_refused(alpha):
    log = EstimatorLog.from_columns(nis=[1.0], nis_dof=2)
    with pytest.raises(ValueError, match="alpha must be"):
        diagnose(log, alpha=alpha)


# -- angles


def course_log(wrapped_nis, logged_nis=True, logged_innovation=True, n=30):
    """A filter of position and course whose course residual passes 180 degrees twice."""
    rng = np.random.default_rng(4)
    S = np.tile(np.diag([4.0, 9.0]), (n, 1, 1))
    proper = rng.normal(size=(n, 2)) * [2.0, 3.0]
    raw = proper.copy()
    raw[[12, 20], 1] += [360.0, -360.0]
    nis = ((proper if wrapped_nis else raw) ** 2 / [4.0, 9.0]).sum(axis=1)
    columns = {"S": S, "observed": [["x", "course"]] * n, "measurement_type": "full"}
    if logged_nis:
        columns["nis"] = nis
    if logged_innovation:
        columns["innovation"] = raw
    else:
        columns |= {"z": raw, "x_pred": np.zeros((n, 2))}
    return EstimatorLog.from_columns(
        states=[State("x", "m"), State("course", "deg", 360.0)], **columns
    )


def test_a_nis_of_unwrapped_residuals_is_a_bug():
    track = diagnose(course_log(wrapped_nis=False))["track"]
    assert track.verdict == track.nis.verdict == "angle_wrap_bug"
    assert any("not wrapped" in note for note in track.notes)


def test_a_nis_of_wrapped_residuals_is_a_note():
    track = diagnose(course_log(wrapped_nis=True))["track"]
    assert track.verdict == "consistent"
    assert any("the NIS is that of the wrapped one" in note for note in track.notes)


def test_without_a_logged_nis_it_is_a_suspicion():
    track = diagnose(course_log(wrapped_nis=True, logged_nis=False))["track"]
    assert track.verdict == "consistent"
    assert any(note.endswith("probably not wrapped.") for note in track.notes)


def test_computed_innovations_are_no_evidence():
    track = diagnose(course_log(wrapped_nis=False, logged_innovation=False))["track"]
    assert track.verdict != "angle_wrap_bug"
    assert track.notes == ()


def course_states(unit_of_course, course_offset=0.0):
    """A ship on a quarter circle, its course in radians or in degrees."""
    course = np.linspace(0.2, 1.6, 40) + course_offset
    north, east = np.cumsum(np.cos(course)), np.cumsum(np.sin(course))
    said = course if unit_of_course == "rad" else np.degrees(course)
    return EstimatorLog.from_columns(
        x=np.column_stack([north, east, said]),
        nis=np.random.default_rng(0).chisquare(2, 40),
        nis_dof=2,
        states=[State("north", "m"), State("east", "m"), State("cog", "deg", 360.0)],
    )


def test_radians_logged_as_degrees_are_a_warning():
    d = diagnose(course_states("rad"))
    assert len(d.warnings) == 1
    assert "cog is declared in degrees, but its values look like radians" in d.warnings[0]
    assert d["track"].notes == d.warnings
    assert diagnose(course_states("deg")).warnings == ()


def test_small_courses_in_degrees_are_no_warning():
    log = course_states("deg")
    x = log.columns.x.copy()
    x[:, 0], x[:, 1], x[:, 2] = np.arange(40.0), 0.0, 0.5
    still = EstimatorLog.from_columns(
        x=x, nis=log.columns.nis, nis_dof=2, states=log.states, time=np.arange(40)
    )
    assert diagnose(still).warnings == ()


def test_spans_have_the_digits_that_were_measured():
    line = Timeline(1_452_556_800.25, "s")
    assert line.at(1_452_556_800.25 + 70.98000002) == "70.98 s"
    assert line.at(1_452_556_860.25) == "60 s"
    assert line.duration(0.0012345) == "0.00123 s"


def test_one_thread_and_several_find_the_same():
    """NIS and NEES are judged at the same time where kernels may use several threads."""
    rng = np.random.default_rng(5)
    columns = {
        "track": np.repeat(["a", "b", "c"], 60),
        "nis": rng.chisquare(2, 180),
        "nis_dof": 2.0,
        "nees": rng.chisquare(4, 180),
        "state_dim": 4,
    }
    columns["nis"][150:] *= 8
    log = EstimatorLog.from_columns(**columns)
    before, found = trackmetrics.threads(), []
    try:
        for count in (1, 2):
            trackmetrics.set_threads(count)
            found.append({name: track.to_dict() for name, track in diagnose(log).items()})
    finally:
        trackmetrics.set_threads(before)
    assert str(found[0]) == str(found[1])
