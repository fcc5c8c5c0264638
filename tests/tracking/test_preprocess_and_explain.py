"""The benchmarks' preprocessing, and explanations of differences."""

import numpy as np
import pytest

from trackmetrics.tracking import evaluate, explain, preprocess_kitti, preprocess_mot_challenge
from trackmetrics.tracks import TrackTable, read_tracks


def rows_of(table):
    corners = np.hstack([table.box[:, :2], table.box[:, :2] + table.box[:, 2:]])
    return sorted(map(tuple, np.column_stack([table.time, corners.round(4)]).tolist()))


@pytest.mark.data
@pytest.mark.parametrize("place", ["0012", "0014"])
def test_kitti_recordings_give_the_rows_of_the_preprocessed_files(data, place):
    folder = data / f"mot/KITTI-{place}"
    truth, tracks = read_tracks(folder / "gt_label_02.txt"), read_tracks(folder / "3DMOT.txt")
    for found, name in zip(preprocess_kitti(truth, tracks), ("gt", "3DMOT"), strict=True):
        expected = np.loadtxt(folder / f"{name}_pp_xyxy.txt", delimiter=",")[:, [0, 2, 3, 4, 5]]
        assert rows_of(found) == sorted(map(tuple, expected.round(4).tolist()))


def mot_tables():
    box = [[0, 0, 10, 20], [50, 0, 10, 20], [100, 0, 10, 20], [150, 0, 10, 20]]
    truth = TrackTable.from_columns(
        time=[1] * 4, id=[1, 2, 3, 4], box=box, score=[1, 0, 1, 0], cls=[1, 8, 6, 1]
    )
    return truth, TrackTable.from_columns(time=[1] * 4, id=[5, 6, 7, 8], box=box)


def test_mot_challenge_leaves_out_tracks_on_distractors():
    truth, tracks = mot_tables()
    for benchmark, kept, followed in (
        ("MOT15", [1, 3], [5, 6, 7, 8]),
        ("MOT17", [1], [5, 7, 8]),
        ("MOT20", [1], [5, 8]),
    ):
        found = preprocess_mot_challenge(truth, tracks, benchmark=benchmark)
        assert [table.id.tolist() for table in found] == [kept, followed]
    with pytest.raises(ValueError, match="truth has no column score"):
        preprocess_mot_challenge(truth.without("score"), tracks)
    with pytest.raises(ValueError, match="benchmark must be one of MOT15"):
        preprocess_mot_challenge(truth, tracks, benchmark="MOT18")


def test_kitti_small_boxes_and_regions():
    box = [[0, 0, 10, 40], [100, 0, 50, 50], [0, 100, 30, 30]]
    truth = TrackTable.from_columns(
        time=[0] * 3,
        id=[1, -1, 2],
        box=box,
        cls=["Car", "DontCare", "Van"],
        other={"truncated": np.zeros(3), "occluded": np.zeros(3)},
    )
    tracks = TrackTable.from_columns(
        time=[0] * 5,
        id=range(5),
        cls=["Car"] * 5,
        box=[[0, 0, 10, 40], [110, 5, 30, 30], [0, 100, 30, 30], [300, 0, 9, 25], [300, 50, 9, 26]],
    )
    found = preprocess_kitti(truth, tracks)
    assert [table.id.tolist() for table in found] == [[1], [0, 4]]


def test_two_trackers_differ_in_named_frames():
    truth = TrackTable.from_columns(time=[1, 2], id=["a", "a"], position=[[0], [1]])
    one = TrackTable.from_columns(time=[1, 2], id=[7, 7], position=[[0], [1]])
    two = TrackTable.from_columns(time=[1, 2], id=[7, 8], position=[[0], [1]])
    results = [evaluate(truth, t, similarity="euclidean", threshold=1) for t in (one, two)]
    found = explain(*results)
    assert found.counts == {"idsw": (0, 1), "idtp": (2, 1), "idfn": (0, 1), "idfp": (0, 1)}
    assert "Frame 2: only b has a switch of object a with track 8 (rule: tracks)." in str(found)
    assert explain(results[0], results[0]).sentences == ()


@pytest.mark.data
def test_protocols_differ_on_a_recording_where_their_counts_do(data):
    folder = data / "mot/TUD-Campus"
    pair = read_tracks(folder / "gt.txt"), read_tracks(folder / "SORT.txt")
    a, b = (evaluate(*pair, protocol=name) for name in ("trackeval", "motmetrics"))
    found = explain(a, b)
    for field, event in (("idsw", "switch"), ("frag", "fragmentation")):
        sides = [sum(e["event"] == event and e["only_in"] == s for e in found.events) for s in "ab"]
        assert sides[0] - sides[1] == getattr(a.clear, field) - getattr(b.clear, field)
