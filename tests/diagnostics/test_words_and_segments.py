"""Verdicts, sentences and segments never contradict each other, whatever the scales are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics.diagnostics import diagnose
from trackmetrics.diagnostics.results import FAILING_VERDICTS
from trackmetrics.logs import EstimatorLog

ENDS = ("start test", "end test")
SEVEREST = ("late_divergence", "startup_then_consistent", "startup_then_pessimistic")


@st.composite
def tracks(draw):
    """NIS of one to five segments, with outliers and, at times, NEES of other scales."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    lengths = draw(st.lists(st.integers(1, 40), min_size=1, max_size=5))
    scale = st.sampled_from([0.05, 0.2, 0.5, 1.0, 1.0, 1.0, 2.0, 4.0, 20.0, 90.0])
    n, dof = sum(lengths), draw(st.sampled_from([1, 2, 4]))

    def values(dof):
        scales = [draw(scale) for _ in lengths]
        return np.repeat(scales, lengths) * rng.chisquare(dof, n)

    columns = {"nis": values(dof), "nis_dof": dof, "time": 10.0 * np.arange(n)}
    columns["nis"][rng.integers(0, n, draw(st.integers(0, 3)))] += 60.0
    if draw(st.booleans()):
        columns |= {"nees": values(3), "state_dim": 3}
    return EstimatorLog.from_columns(**columns)


@st.composite
def innovation_tracks(draw):
    """Innovations and errors with a bias, a correlation in time and changes of scale."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, bias = draw(st.integers(8, 80)), draw(st.sampled_from([0.0, 0.0, 0.8, 2.0]))

    def values():
        x = rng.normal(size=(n, 2))
        x[1:] += draw(st.sampled_from([-0.6, 0.0, 0.0, 0.5])) * x[:-1]
        x[draw(st.integers(0, n)) :] *= draw(st.sampled_from([0.5, 1.0, 1.0, 3.0]))
        x[: draw(st.integers(0, 4))] *= draw(st.sampled_from([1.0, 5.0]))
        return x * draw(st.sampled_from([0.6, 0.85, 1.0, 1.2, 2.0])) + bias

    unit = np.tile(np.eye(2), (n, 1, 1))
    columns = {"innovation": values(), "S": unit}
    if draw(st.booleans()):
        columns |= {"error": values(), "P": unit}
    return EstimatorLog.from_columns(**columns)


def check(track):
    quantities = [q for q in (track.nis, track.nees) if q is not None]
    for quantity in quantities:
        check_quantity(quantity)
    labels = [s.label for q in quantities for s in q.segments]
    if track.verdict in SEVEREST:
        assert "optimistic" in labels
    if "consistent at first" in track.text:
        assert any(q.segments[0].label == "consistent" for q in quantities if q.segments)
    for outlier in track.outliers:
        assert outlier.nis > 0
    if track.verdict == "outliers":
        assert track.outliers


def check_quantity(quantity):
    segments = quantity.segments
    labels = [s.label for s in segments]
    assert [a.stop for a in segments[:-1]] <= [b.start for b in segments[1:]]
    for segment in segments:
        assert (segment.scale > 1) or segment.label != "optimistic"
        assert (segment.scale < 1) or segment.label != "pessimistic"
        assert segment.interval[0] <= segment.scale <= segment.interval[1]
    if quantity.verdict in SEVEREST:
        assert "optimistic" in labels
        if quantity.decided_by in ENDS:
            assert labels[-1 if quantity.decided_by == "end test" else 0] == "optimistic"
    if quantity.verdict == "startup_then_consistent":
        assert labels[0] == "optimistic"
        assert labels[-1] != "optimistic"
        assert "consistent" in labels
    if quantity.verdict == "startup_then_pessimistic":
        assert labels[0] == "optimistic"
        assert "pessimistic" in labels
    if quantity.decided_by == "segments":
        check_by_segments(quantity, labels)
    if quantity.onset_time is not None and quantity.alarm_time is not None:
        assert quantity.alarm_time >= quantity.onset_time


def check_by_segments(quantity, labels):
    if quantity.verdict in ("consistent", "outliers"):
        assert set(labels) == {"consistent"}
    if quantity.verdict in ("optimistic", "transient", "late_divergence"):
        assert "optimistic" in labels
    if quantity.verdict in ("pessimistic", "partly_pessimistic"):
        assert "pessimistic" in labels
        assert "optimistic" not in labels
    if quantity.verdict in FAILING_VERDICTS:
        assert quantity.verdict in ("biased",) or "optimistic" in labels


@given(tracks())
def test_words_agree_with_segments(log):
    check(diagnose(log)["track"])


@given(tracks(), st.floats(1e-4, 0.05))
def test_words_agree_with_segments_at_every_alpha(log, alpha):
    check(diagnose(log, alpha=alpha)["track"])


@given(innovation_tracks())
def test_words_agree_with_segments_where_innovations_decide(log):
    check(diagnose(log)["track"])


def text_of(nis):
    return diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2))["track"]


def test_a_track_without_a_consistent_segment_is_not_called_consistent_at_first():
    rng = np.random.default_rng(0)
    scales = np.repeat([6.0, 0.05, 90.0, 4.0], [30, 20, 10, 30])
    track = text_of(scales * rng.chisquare(2, 90))
    assert track.verdict == "late_divergence"
    assert "consistent" not in {s.label for s in track.nis.segments}
    assert "consistent" not in track.text
    assert "optimistic, then pessimistic, then optimistic until the end" in track.text


def test_a_verdict_by_an_end_test_says_so_and_shows_the_end_as_a_segment():
    found = 0
    for seed in range(1500):
        track = text_of(np.random.default_rng(seed).chisquare(2, 200))
        if track.nis.decided_by in ENDS:
            found += 1
            at_end = track.nis.decided_by == "end test"
            segment = track.nis.segments[-1 if at_end else 0]
            assert segment.label == "optimistic"
            assert segment.p_value < 0.004
            assert (track.nis.onset_index if at_end else track.nis.settling_index) == (
                segment.start if at_end else segment.stop
            )
            assert f"the test of the {'last' if at_end else 'first'} updates" in track.text
    assert found > 0


def test_an_alarm_before_the_fault_is_not_that_faults_alarm():
    before = 0
    for seed in range(100):
        nis = np.random.default_rng(seed).chisquare(2, 100)
        nis[:30] *= 0.2
        nis[70:] *= 5
        nis[40:42] = 25.0
        track = text_of(nis)
        if track.nis.onset_time is not None and track.nis.alarm_time is not None:
            before += track.nis.onset_time > 45
            assert track.nis.alarm_time >= track.nis.onset_time
    assert before > 50


@pytest.mark.parametrize(("z", "text"), [(1.0, "p = 0.96"), (4000.0, "p < 1e-300")])
def test_a_p_value_too_small_for_a_float_is_bounded(z, text):
    assert text in text_of(np.full(40, 2.0 * z)).text
