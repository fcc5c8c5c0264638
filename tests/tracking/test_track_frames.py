"""What TrackFrames and the scores over identities take, refuse and give back."""

import json

import numpy as np
import pytest

from trackmetrics.tracking import TrackFrames, clear_mot, hota, identity_scores
from trackmetrics.tracks import Boxes


def columns(**changes):
    boxes = [[0, 0, 2, 2], [1, 0, 2, 2]]
    values = {
        **{"truth_times": [1, 2], "truth_ids": ["a", "a"], "track_times": [2, 1]},
        **{"track_ids": [7, 8], "truth_boxes": boxes, "track_boxes": boxes[::-1]},
    }
    return TrackFrames.from_columns(**{**values, **changes})


def test_ids_of_any_hashable_kind_and_rows_in_any_order():
    frames = columns(truth_ids=[("a", 1), None], track_ids=["x", 7])
    assert frames.truth.names == (("a", 1), None)
    scores = clear_mot(frames)
    assert (scores.tp, scores.motp, scores.idsw) == (2, 1.0, 0)
    assert clear_mot(columns()).idsw == 1


def test_boxes_by_corners_are_the_same():
    corners = [[0, 0, 2, 2], [1, 0, 3, 2]]
    frames = columns(truth_boxes=corners, track_boxes=corners[::-1], box_format="ltrb")
    assert clear_mot(frames).to_dict() == clear_mot(columns()).to_dict()
    np.testing.assert_array_equal(frames.truth.boxes, columns().truth.boxes)


def test_boxes_of_files():
    boxes = Boxes(np.array([3, 5]), np.array([1, 1]), np.array([[0.0, 0, 2, 2]] * 2), np.ones(2))
    frames = TrackFrames.from_boxes(boxes, boxes)
    assert (len(frames), clear_mot(frames).tp, hota(frames).hota) == (3, 2, 1.0)
    nothing = Boxes(np.empty(0, int), np.empty(0, int), np.empty((0, 4)), np.empty(0))
    assert clear_mot(TrackFrames.from_boxes(boxes, nothing)).fn == 2
    empty = TrackFrames.from_boxes(nothing, nothing)
    assert clear_mot(empty, protocol="motmetrics").to_dict()["mota"] is None


def test_results_are_ready_for_json():
    frames = columns()
    found = {}
    for function in (clear_mot, identity_scores, hota):
        found |= json.loads(json.dumps(function(frames).to_dict(), allow_nan=False))
    assert {"mota", "motp", "idsw", "frag", "mt", "idf1", "idtp", "hota", "deta", "assa"} <= set(
        found
    )
    assert len(found["hota_alpha"]) == 19


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"truth_times": [2, 2]},
            r"truth rows 0 and 1 both have time 2 and id a",
        ),
        ({"track_times": [1, np.nan]}, r"track_times\[1\] is nan, expected a finite time"),
        ({"track_times": [[1, 2]]}, r"track_times has shape \(1, 2\)"),
        ({"truth_ids": ["a"]}, r"truth_ids has 1 rows, truth_times has 2"),
        ({"truth_boxes": [[0, 0, 1, 1]]}, r"truth_boxes has shape \(1, 4\), expected \(2, 4\)"),
        ({"track_boxes": [[0, 0, 1, 1], [0, np.inf, 1, 1]]}, r"track_boxes\[1\]\[1\] is not fin"),
        ({"box_format": "xywh"}, r"box_format must be 'ltwh' or 'ltrb', got 'xywh'"),
        ({"times": [1]}, r"times lacks 2"),
    ],
)
def test_wrong_columns_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        columns(**changes)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"protocol": "mota"},
            r"protocol must be 'trackeval', 'motmetrics' or 'bernardin', got 'mota'",
        ),
        ({"similarity": "giou"}, r"similarity must be 'iou', 'euclidean' or a matrix"),
        ({"threshold": 1.5}, r"threshold must be above 0 and at most 1, got 1.5"),
        ({"similarity": "euclidean", "threshold": np.inf}, r"threshold must be a finite distance"),
        ({"similarity": [[[1]]]}, r"similarity has 1 frames, frames has 2"),
        ({"similarity": [[[1]], [[1, 1]]]}, r"similarity\[1\] has shape \(1, 2\)"),
        ({"similarity": [[[1]], [[2]]]}, r"similarity\[1\]\[0\]\[0\] must be between 0 and 1"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        clear_mot(columns(), **options)


def test_what_is_missing_is_named():
    with pytest.raises(ValueError, match="truth has no boxes"):
        clear_mot(columns(truth_boxes=None))
    with pytest.raises(ValueError, match="tracks has neither positions nor boxes"):
        clear_mot(columns(track_boxes=None), similarity="euclidean")
    with pytest.raises(TypeError, match="frames must be TrackFrames, got list"):
        hota([])


def test_nan_excludes_a_pair():
    frames = TrackFrames.from_columns([0], [1], [0], [2])
    for protocol in ("trackeval", "motmetrics"):
        options = {"similarity": [[[np.nan]]], "protocol": protocol}
        assert clear_mot(frames, **options).tp == 0
        assert identity_scores(frames, **options).idtp == 0
