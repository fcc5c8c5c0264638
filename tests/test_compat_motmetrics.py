"""Our py-motmetrics against the original: its numbers of recordings, itself on random scenes."""

import json
import math
import sys
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackmetrics.compat.motmetrics as mm
from trackmetrics._tables import data_frames

pd = pytest.importorskip("pandas")


def fill(accumulator, scene):
    for frame, (objects, hypotheses, distances) in enumerate(scene):
        accumulator.update(objects, hypotheses, distances, frameid=frame)
    return accumulator


@st.composite
def scenes(draw):
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(draw(st.integers(0, 8))):
        objects = rng.permutation(6)[: rng.integers(0, 6)]
        hypotheses = rng.permutation(7)[: rng.integers(0, 6)] + 10
        distances = rng.random((len(objects), len(hypotheses)))
        distances[rng.random(distances.shape) < 0.4] = np.nan
        frames.append((objects, hypotheses, distances))
    return frames


@pytest.mark.peers
@given(scenes(), st.sampled_from([float("inf"), 1]))
def test_events_and_metrics_are_the_originals(scene, max_switch_time):
    peer = import_module("motmetrics")
    ours = fill(mm.MOTAccumulator(max_switch_time=max_switch_time), scene)
    theirs = fill(peer.MOTAccumulator(max_switch_time=max_switch_time), scene)
    if scene:
        pd.testing.assert_frame_equal(ours.events, theirs.events)
        pd.testing.assert_frame_equal(ours.mot_events, theirs.mot_events)
    names = peer.metrics.motchallenge_metrics
    assert mm.metrics.motchallenge_metrics == names
    host, original = mm.metrics.create(), peer.metrics.create()
    assert host.names == original.names
    arguments = {"metrics": names, "generate_overall": True}
    table = host.compute_many([ours, ours], **arguments)
    expected = original.compute_many([theirs, theirs], **arguments)
    pd.testing.assert_frame_equal(table, expected, check_exact=False, rtol=1e-13)
    assert mm.io.render_summary(table, host.formatters) == peer.io.render_summary(
        expected, original.formatters
    )


@pytest.mark.data
def test_recordings_have_the_originals_numbers(data):
    path = data / "mot" / "values" / "mot15__TUD-Campus__SORT__all.motmetrics.json"
    found = sorted((data / "mot" / "values").glob("*TUD-Campus*all.motmetrics.json"))
    assert found, path
    folder = data / "mot" / "TUD-Campus"
    truth = mm.io.loadtxt(next(folder.glob("gt*.txt")))
    for values in found:
        tracker = values.name.split("__")[2]
        tracks = mm.io.loadtxt(folder / f"{tracker}.txt")
        expected = json.loads(values.read_text(encoding="utf-8"))
        expected = expected.get("iou", expected)
        acc = mm.utils.compare_to_groundtruth(truth, tracks, "iou", distth=0.5)
        host = mm.metrics.create()
        got = host.compute(acc, metrics=mm.metrics.motchallenge_metrics, return_dataframe=False)
        compared = got.keys() & expected.keys()
        assert len(compared) > 10
        for name in compared:
            assert math.isclose(got[name], expected[name], rel_tol=1e-12), name


def test_ids_may_be_text_and_frames_are_built_once():
    acc = mm.MOTAccumulator(auto_id=True)
    acc.update(["a", "b"], ["x"], [[0.1], [np.nan]])
    assert list(acc.mot_events["OId"]) == ["a", "b"]
    assert acc.events is acc.events
    assert mm.metrics.create().compute(acc, metrics="idtp")["idtp"][0] == 1


def test_without_pandas_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"trackmetrics\[pandas\]"):
        data_frames.pandas()


def test_merged_sequences_keep_their_ids_apart():
    acc = mm.MOTAccumulator(auto_id=True)
    acc.update([1, 2], [7], [[0.1], [np.nan]])
    merged, names = mm.MOTAccumulator.merge_event_dataframes([acc, acc], return_mappings=True)
    assert [one["frame_offset"] for one in names] == [0, 1]
    assert [one["oid_map"] for one in names] == [{1.0: "0", 2.0: "1"}, {1.0: "2", 2.0: "3"}]
    assert mm.metrics.create().compute(merged, metrics="num_unique_objects").iloc[0, 0] == 4
