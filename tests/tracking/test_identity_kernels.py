"""The kernels over identities: Rust, reference and brute force give the same."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics import _backend, use_backend
from trackmetrics.tracking import PROTOCOLS, TrackFrames, clear_mot
from trackmetrics.tracking.matches import Event, match
from trackmetrics.tracking.similarity import pair_measure

BACKENDS = ("native", "numpy")
ALPHAS = np.arange(0.05, 0.99, 0.05) - np.finfo(float).eps


@st.composite
def box_scenes(draw):
    """Boxes on a coarse grid, so that areas and similarities tie; ids come, go and swap."""
    columns = [[], [], [], []]
    boxes = [[], []]
    corner = st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(0, 3), st.integers(1, 3))
    frames = draw(st.integers(1, 7))
    for t in range(frames):
        for side, most in ((0, 5), (1, 6)):
            ids = draw(st.permutations(range(most)))[: draw(st.integers(0, most))]
            columns[2 * side] += [t] * len(ids)
            columns[2 * side + 1] += ids
            boxes[side] += [list(draw(corner)) for _ in ids]
    return TrackFrames.from_columns(
        *columns,
        truth_boxes=np.reshape(boxes[0], (-1, 4)),
        track_boxes=np.reshape(boxes[1], (-1, 4)),
        times=range(frames),
    )


def crowd(seed, frames=40, targets=25, places=np.inf):
    """Boxes that move and jitter, with misses, false alarms and tracks that change their ids."""
    rng = np.random.default_rng(seed)
    where = rng.uniform(0, 60, (targets, 2)) + rng.normal(0, 1, (frames, targets, 2)).cumsum(0)
    boxes = np.concatenate(
        [where, np.broadcast_to(rng.uniform(5, 25, (targets, 2)), where.shape)], 2
    )
    names = (rng.random((frames, targets)) < 0.1).cumsum(0) * targets + np.arange(targets)
    there, found = rng.random((frames, targets)) < 0.9, rng.random((frames, targets)) < 0.8
    jitter = rng.normal(0, 2, boxes.shape)
    t, i = np.nonzero(there)
    s, j = np.nonzero(found)
    tracks = boxes + jitter
    tracks[..., 2:] = np.abs(tracks[..., 2:])
    if np.isfinite(places):
        boxes, tracks = np.round(boxes, places), np.round(tracks, places)
    return TrackFrames.from_columns(
        t, i, s, names[s, j], truth_boxes=boxes[t, i], track_boxes=tracks[s, j], times=range(frames)
    )


def arguments(frames, similarity, threshold):
    with use_backend("numpy"):
        measure = pair_measure(frames, similarity, threshold)
        return frames.truth.coded(), frames.tracks.coded(), measure.pairs


def both(name, *args):
    found = []
    for backend in BACKENDS:
        with use_backend(backend):
            found.append(getattr(_backend.kernels, name)(*args))
    return found


def assert_kernels_agree(frames, similarity="iou", threshold=0.5):
    """Decisions exactly; sums that are added in another order nearly."""
    args = arguments(frames, similarity, threshold)
    with use_backend("native"):
        for one, other in zip(
            pair_measure(frames, similarity, threshold).pairs, args[2], strict=True
        ):
            np.testing.assert_array_equal(one, other)
    for rules in itertools.product([True, False], repeat=3):
        limit = threshold if rules[1] or similarity == "euclidean" else 1 - threshold
        limit = 0.5 if rules[1] and similarity == "euclidean" else limit
        native, reference = both("clear_mot", *args, rules, float(limit))
        for one, other in zip(native[:4], reference[:4], strict=True):
            np.testing.assert_array_equal(one, other, err_msg=str(rules))
        np.testing.assert_allclose(native[4], reference[4], rtol=1e-12)
        assert np.isfinite(native[1]).sum() == native[3].sum() == (native[0] >= 0).sum()
    for by_distance in (False, True):
        native, reference = both("identities", *args, by_distance, 0.5)
        assert native[4] == reference[4]
        assert sorted(zip(*native[:3], strict=True)) == sorted(zip(*reference[:3], strict=True))
        counts = {(i, j): n for i, j, n in zip(*native[:3], strict=True)}
        for assigned in (native[3], reference[3]):
            chosen = [(i, j) for i, j in enumerate(assigned.tolist()) if j >= 0]
            assert len({j for _, j in chosen}) == len(chosen)
            assert sum(counts[pair] for pair in chosen) == native[4]
    native, reference = both("hota", *args, ALPHAS)
    np.testing.assert_array_equal(native[0], reference[0])
    for one, other in zip(native[1:], reference[1:], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15)


@given(box_scenes())
def test_kernels_agree_on_boxes_that_tie(frames):
    assert_kernels_agree(frames)
    assert_kernels_agree(frames, threshold=0.25)


@given(box_scenes())
def test_kernels_agree_on_distances_that_tie(frames):
    assert_kernels_agree(frames, "euclidean", 1.0)
    assert_kernels_agree(frames, "euclidean", 2.5)


@given(box_scenes(), st.randoms(use_true_random=False))
def test_kernels_agree_on_matrices(frames, random):
    levels = (0.0, 0.3, 0.5, np.nextafter(0.5, 0), 0.5 - 2**-40, 0.75, 1.0, np.nan)
    sizes = zip(np.diff(frames.truth.starts), np.diff(frames.tracks.starts), strict=True)
    matrices = [np.reshape(random.choices(levels, k=int(n * m)), (n, m)) for n, m in sizes]
    assert_kernels_agree(frames, matrices)
    assert_kernels_agree(frames, matrices, threshold=1e-17)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("places", [0, 1, np.inf])
def test_kernels_agree_in_a_crowd(seed, places):
    """Rows of more than eight similar pairs: sums in NumPy's order decide the ties."""
    assert_kernels_agree(crowd(seed, places=places))
    assert_kernels_agree(crowd(seed, frames=4, targets=150, places=places))


def best_totals(values, listed):
    """The largest total over all matchings of the listed pairs, by trying them all."""
    n, m = values.shape
    if not n:
        return 0.0
    rest = best_totals(values[1:], listed[1:])
    for j in range(m):
        if listed[0, j]:
            others = np.delete(values[1:], j, 1), np.delete(listed[1:], j, 1)
            rest = max(rest, values[0, j] + best_totals(*others))
    return rest


@given(box_scenes())
def test_the_first_frame_has_the_best_of_all_matchings(frames):
    measure = pair_measure(frames, "iou", 0.25)
    rows, columns = (slice(0, int(side.starts[1])) for side in (frames.truth, frames.tracks))
    if not (rows.stop and columns.stop):
        return
    similarity, distance = (
        measure.similarities(0, rows, columns),
        measure.distances(0, rows, columns),
    )
    found = match(measure, PROTOCOLS["trackeval"]).values[rows]
    best = best_totals(similarity, similarity >= 0.25 - np.finfo(float).eps)
    assert np.nansum(found) == pytest.approx(best, abs=1e-12)
    found = match(measure, PROTOCOLS["bernardin"]).values[rows]
    gain = 100 - np.where(np.isnan(distance), 0, distance)
    best = best_totals(gain, np.isfinite(distance))
    assert np.nansum(100 - found) == pytest.approx(best, abs=1e-9)


@given(box_scenes())
def test_events_count_what_a_log_would(frames):
    """Switches, transfers and their kinds from the pairs in the order of time, one by one."""
    for rules in PROTOCOLS.values():
        found = match(pair_measure(frames, "iou", 0.25), rules)
        last, assigned, seen = {}, {}, set()
        for row, column in enumerate(found.partners.tolist()):
            event = Event(int(found.events[row]))
            if column < 0:
                assert not event
                continue
            target, track = int(frames.truth.ids[row]), int(frames.tracks.ids[column])
            assert bool(event & Event.SWITCH) == (last.get(target, track) != track)
            is_new = not event & Event.CONTINUED
            moved = is_new and assigned.get(track, target) != target
            assert bool(event & Event.TRANSFER) == moved
            assert bool(event & Event.MIGRATE) == (moved and target not in last)
            assert bool(event & Event.ASCEND) == (bool(event & Event.SWITCH) and track not in seen)
            last[target] = track
            seen.add(track)
            if is_new:
                assigned[track] = target


def rows(times, ids, x):
    return np.array(times), np.array(ids), np.array(x, dtype=float)[:, None]


def test_the_paper_keeps_a_valid_pair_though_another_is_nearer():
    """Figure 4 of the paper: the mapping of the frame before is kept within the threshold."""
    truth, tracks = rows([0, 1], [0, 0], [0, 0]), rows([0, 1, 1], [1, 1, 2], [0, 0.9, 0.1])
    frames = TrackFrames.from_columns(
        *truth[:2], *tracks[:2], truth_positions=truth[2], track_positions=tracks[2]
    )
    scores = clear_mot(frames, similarity="euclidean", threshold=1.0, protocol="bernardin")
    assert (scores.idsw, scores.tp, scores.fp, scores.motp) == (0, 2, 1, 0.45)
    assert np.isnan(scores.transfers)


def test_the_paper_remembers_a_mapping_over_frames_without_a_pair():
    truth = rows([0, 1, 2], [0, 0, 0], [0, 0, 0])
    tracks = rows([0, 2, 2], [1, 2, 1], [0, 0.1, 0.9])
    frames = TrackFrames.from_columns(
        *truth[:2], *tracks[:2], truth_positions=truth[2], track_positions=tracks[2]
    )
    found = {
        name: clear_mot(frames, similarity="euclidean", threshold=1.0, protocol=name)
        for name in PROTOCOLS
    }
    assert found["bernardin"].idsw == found["motmetrics"].idsw == 0
    assert found["bernardin"].frag == 1
    assert (found["bernardin"].mt, found["bernardin"].pt) == (0, 1)


def test_every_rule_has_its_source():
    for protocol in PROTOCOLS.values():
        fields = set(type(protocol).__dataclass_fields__) - {"name", "source", "sources"}
        assert set(protocol.sources) == fields


SIDE = np.array([0, 1]), np.array([0, 2]), 2
NO_PAIRS = np.zeros(3, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0), np.empty(0)


@pytest.mark.parametrize(
    ("side", "pairs", "message"),
    [
        ((SIDE[0], np.array([0, 1]), 2), NO_PAIRS, "truth: starts must rise from 0 to 2"),
        ((SIDE[0], SIDE[1], 1), NO_PAIRS, r"truth\[1\] must be at least 0 and below the number"),
        (
            SIDE,
            (np.array([0, 1, 1]), np.array([2]), np.ones(1), np.ones(1)),
            r"columns\[0\] must be a track row of the frame, in rising order, got 2.0",
        ),
        (
            SIDE,
            (np.array([0, 1, 1]), np.array([1]), np.ones(2), np.ones(1)),
            "similarities has 2 pairs, columns has 1",
        ),
    ],
)
def test_arrays_that_do_not_fit_are_refused(side, pairs, message):
    for backend in BACKENDS:
        with use_backend(backend), pytest.raises(ValueError, match=message):
            _backend.kernels.hota(side, SIDE, pairs, ALPHAS)
