"""VACE against TrackEval: recordings, corner cases, random scenes; and the definition."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics.tracking import TrackFrames, vace
from trackmetrics.tracking.similarity import pair_measure
from trackmetrics.tracks import read_mot_challenge

NAMES = {
    **{"STDA": "stda", "ATA": "ata", "FDA": "fda", "SFDA": "sfda"},
    **{"VACE_IDs": "track_ids", "VACE_GT_IDs": "truth_ids", "num_non_empty_timesteps": "frames"},
}
RECORDINGS = (
    ("TUD-Campus/gt.txt", "TUD-Campus/CEM.txt"),
    ("TUD-Campus/gt.txt", "TUD-Campus/SORT.txt"),
    ("KITTI-17/gt.txt", "KITTI-17/SORT.txt"),
    ("MOT17-09/gt_pp.txt", "MOT17-09/MoTT_pp.txt"),
)
LEVELS = (0.0, 0.2, 0.5 - 2**-53, 0.5, 0.5 + 2**-53, 0.75, 1.0)


def trackeval_values(frames, matrices):
    from trackeval.metrics import VACE

    truth, tracks = frames.truth, frames.tracks
    with np.errstate(divide="ignore"):
        return VACE().eval_sequence(
            {
                "num_gt_ids": len(truth.names),
                "num_tracker_ids": len(tracks.names),
                "gt_ids": np.split(truth.ids, truth.starts[1:-1]),
                "tracker_ids": np.split(tracks.ids, tracks.starts[1:-1]),
                "similarity_scores": matrices,
            }
        )


def assert_same(found, expected):
    for theirs, ours in NAMES.items():
        value = getattr(found, ours)
        if isinstance(value, int):
            assert value == expected[theirs], theirs
        else:
            np.testing.assert_allclose(value, expected[theirs], rtol=1e-12, atol=1e-12)


@pytest.mark.data
@pytest.mark.peers
@pytest.mark.parametrize(("truth", "tracks"), RECORDINGS)
@pytest.mark.parametrize("measure", [("iou", 0.5), ("euclidean", 50.0)])
def test_recordings_have_trackevals_numbers(data, truth, tracks, measure):
    sides = (read_mot_challenge(data / "mot" / name) for name in (truth, tracks))
    frames = TrackFrames.from_boxes(*sides)
    pairs = pair_measure(frames, *measure)
    sizes = zip(np.diff(frames.truth.starts), np.diff(frames.tracks.starts), strict=True)
    matrices = [np.zeros(size) for size in sizes]
    for t, rows, columns in frames.slices():
        matrices[t] = pairs.similarities(t, rows, columns)
    found = vace(frames, similarity=measure[0], threshold=measure[1])
    assert 0.2 < found.ata < found.sfda < 1
    assert_same(found, trackeval_values(frames, matrices))


def scene(listed):
    columns = [[], [], [], []]
    matrices = []
    for t, (truth, tracks, similarity) in enumerate(listed):
        columns[0] += [t] * len(truth)
        columns[1] += list(truth)
        columns[2] += [t] * len(tracks)
        columns[3] += list(tracks)
        matrices.append(np.array(similarity, dtype=float).reshape(len(truth), len(tracks)))
    return TrackFrames.from_columns(*columns, times=range(len(listed))), matrices


@st.composite
def scenes(draw):
    size = st.integers(0, 4)
    level = st.one_of(st.sampled_from(LEVELS), st.floats(0, 1))
    listed = []
    for _ in range(draw(st.integers(1, 8))):
        truth = draw(st.permutations(range(4)))[: draw(size)]
        tracks = draw(st.permutations(range(10, 15)))[: draw(size)]
        count = len(truth) * len(tracks)
        listed.append((truth, tracks, draw(st.lists(level, min_size=count, max_size=count))))
    return listed


@pytest.mark.peers
@given(scenes())
def test_random_scenes_have_trackevals_numbers(listed):
    frames, matrices = scene(listed)
    if len(frames.truth.names) + len(frames.tracks.names) == 0:
        return  # TrackEval divides two whole numbers 0; the next test holds ours
    assert_same(vace(frames, similarity=matrices), trackeval_values(frames, matrices))


@pytest.mark.data
@pytest.mark.peers
def test_corner_cases_have_trackevals_numbers(data):
    cases = json.loads((data / "mot/values/micro_cases.json").read_text())
    for case in cases.values():
        frames, matrices = scene([(f["gt"], f["tracker"], f["similarity"]) for f in case])
        if len(frames.truth.names) + len(frames.tracks.names):
            assert_same(vace(frames, similarity=matrices), trackeval_values(frames, matrices))


def test_nothing_has_no_score():
    found = vace(scene([([], [], [])])[0], similarity=[np.empty((0, 0))])
    assert math.isnan(found.ata)
    assert math.isnan(found.sfda)
    assert (found.stda, found.fda, found.frames) == (0, 0, 0)


@given(scenes())
def test_the_definition_by_all_assignments(listed):
    frames, matrices = scene(listed)
    present = {}
    near = {}
    for t, ((truth, tracks, _), matrix) in enumerate(zip(listed, matrices, strict=True)):
        for name in (*truth, *tracks):
            present.setdefault(name, set()).add(t)
        for i, j in np.argwhere(matrix >= 0.5):
            near[truth[i], tracks[j]] = near.get((truth[i], tracks[j]), 0) + 1
    few, many = sorted((frames.truth.names, frames.tracks.names), key=len)

    def share(a, b):
        pair = (a, b) if a < 10 else (b, a)
        return near.get(pair, 0) / len(present[a] | present[b])

    best = max(
        sum(share(a, b) for a, b in zip(few, chosen, strict=True))
        for chosen in itertools.permutations(many, len(few))
    )
    assert vace(frames, similarity=matrices).stda == pytest.approx(best, abs=1e-12)
