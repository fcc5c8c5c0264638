"""The differences from pytcl in labels, frames and mean OSPA, with both values."""

import math
import warnings

import numpy as np
import pytest

import trackmetrics

pytestmark = pytest.mark.peers

LABELS = ("track_purity", "track_fragmentation", "identity_switches")
NAN = math.nan


def theirs(function, *arguments):
    """What pytcl gives, its warnings aside."""
    from pytcl import performance_evaluation as peer

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return getattr(peer, function)(*arguments)


def ours_is_refused(function, *arguments, kind=ValueError, match):
    with pytest.raises(kind, match=match):
        getattr(trackmetrics, function)(*arguments)


def test_equal_times():
    labels = [0, 1] * 50
    assert theirs("track_fragmentation", [0] * 100, labels, [0] * 100) <= 99
    assert trackmetrics.track_fragmentation([0] * 100, labels, [0] * 100) == 99


def test_lists_of_different_lengths():
    for name in LABELS[1:]:
        assert theirs(name, [1, 1], [1, 2], [0]) == 0
        ours_is_refused(name, [1, 1], [1, 2], [0], match="time_indices has 1 times")
        with pytest.raises(IndexError):
            theirs(name, [1, 1], [1])
        ours_is_refused(name, [1, 1], [1], match="estimated_labels has 1 labels")


def test_what_is_no_label():
    assert theirs("track_fragmentation", [1, 1, 1], [NAN, NAN, NAN]) == 2
    ours_is_refused("track_fragmentation", [1, 1, 1], [NAN, NAN, NAN], match=r"\[0\] is nan")
    square = np.zeros((2, 2))
    assert theirs("track_purity", square, square) == 2.0
    ours_is_refused("track_purity", square, square, match="true_labels has shape")


def test_labels_of_several_kinds():
    assert theirs("track_fragmentation", [0, 0], [1, "1"]) == 0
    assert trackmetrics.track_fragmentation([0, 0], [1, "1"]) == 1
    with pytest.raises(TypeError):
        theirs("track_purity", [1, 1], [None, 1])
    assert trackmetrics.track_purity([1, 1], [None, 1]) == 1.0


def test_frames():
    one, two = [[[0.0, 0.0]]], [[[0.0, 0.0]], [[9.0, 9.0]]]
    assert theirs("mot_metrics", one, two).mota == 1.0
    ours_is_refused("mot_metrics", one, two, match="estimates has 2 frames")
    assert theirs("mot_metrics", [[np.array([3.0, 3.0])]], [[np.zeros(1)]]).motp == math.sqrt(18)
    ours_is_refused("mot_metrics", [[[3.0, 3.0]]], [[[0.0]]], match="has 1 coordinates")
    for threshold in (NAN, -1.0):
        assert theirs("mot_metrics", one, one, threshold).num_misses == 1
        ours_is_refused("mot_metrics", one, one, threshold, match="threshold must be at least 0")
    named = [{1.0: [0.0, 0.0]}]
    assert theirs("mot_metrics", named, named).mota == 1.0
    ours_is_refused("mot_metrics", named, named, kind=TypeError, match=r"ground_truth\[0\]")


def test_coordinates_that_are_not_finite():
    for bad in (NAN, math.inf):
        frames = [[[bad, 0.0]]]
        with pytest.raises(ValueError, match=r"matrix|infeasible"):
            theirs("mot_metrics", frames, [[[0.0, 0.0]]])
        ours_is_refused("mot_metrics", frames, frames, match=r"ground_truth\[0\]\[0\] is not")


def test_mean_ospa():
    x, w = np.zeros((2, 2, 1)), [1.0, 5.0]
    assert theirs("calc_mospa_error", x[..., 0], x, w) == 0.0
    ours_is_refused("calc_mospa_error", x[..., 0], x, w, match="w has 2 hypotheses, x has 1")
    assert theirs("mmospa_approx", x, w)[0].shape == (2, 2)
    ours_is_refused("mmospa_approx", x, w, match="w has 2 hypotheses, x has 1")
    assert np.isnan(theirs("mmospa2tar_2d", np.empty((4, 0)))).all()
    ours_is_refused("mmospa2tar_2d", np.empty((4, 0)), match="N at least 1")
