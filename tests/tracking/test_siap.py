"""SIAP metrics against Stone Soup: its own example, a recording, random scenes."""

import json
import math
from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackmetrics.tracking import TrackFrames, associate, siap

NAMES = {
    "SIAP Completeness": "completeness",
    "SIAP Ambiguity": "ambiguity",
    "SIAP Spuriousness": "spuriousness",
    "SIAP Position Accuracy": "position_accuracy",
    "SIAP Velocity Accuracy": "velocity_accuracy",
    "SIAP Rate of Track Number Change": "rate_of_track_number_change",
    "SIAP Longest Track Segment": "longest_track_segment",
    "SIAP ID Completeness": "id_completeness",
    "SIAP ID Correctness": "id_correctness",
    "SIAP ID Ambiguity": "id_ambiguity",
}
SERIES = {f"{theirs} at times": f"{ours}_at" for theirs, ours in NAMES.items()}
COMPONENTS = {"position": [0, 2], "velocity": [1, 3]}


def as_items(paths):
    return paths.items() if isinstance(paths, dict) else enumerate(paths)


def columns(paths):
    """Times, ids and states; of two states at one time the later."""
    rows = {(r["t"], name): r["state"] for name, path in as_items(paths) for r in path}
    return [t for t, _ in rows], [name for _, name in rows], list(rows.values())


def frames_of(truths, tracks):
    truth, track = columns(truths), columns(tracks)
    return TrackFrames.from_columns(
        *truth[:2], *track[:2], truth_positions=truth[2], track_positions=track[2]
    )


def intervals_of(associations, name=lambda value: value):
    return [
        (name(one["truth"]), name(one["track"]), *interval)
        for one in associations
        for interval in one["intervals"]
    ]


def assert_same(found, expected):
    found = found.to_dict()
    for theirs, ours in {**NAMES, **SERIES}.items():
        if theirs in expected:
            np.testing.assert_allclose(
                np.array(found[ours], dtype=float), expected[theirs], rtol=1e-12, atol=1e-12,
                err_msg=theirs,
            )  # fmt: skip


@pytest.fixture
def values(data):
    return json.loads((data / "mot/values/siap_stonesoup.json").read_text())


@pytest.mark.data
def test_example_of_stone_soup(values):
    case = values["A_stonesoup_test_fixture"]
    truth_ids = {i: path[0]["id"] for i, path in enumerate(case["truths"])}
    said = {i: {row["t"]: row["id"] for row in path} for i, path in enumerate(case["tracks"])}
    found = siap(
        frames_of(case["truths"], case["tracks"]),
        intervals_of(case["associations"]),
        **COMPONENTS,
        truth_identities=truth_ids,
        track_identities=said,
    )
    assert len(case["metrics"]) == 18
    assert_same(found, case["metrics"])


@pytest.mark.data
@pytest.mark.parametrize(("confirm", "end"), [(2, 1), (3, 2)])
def test_recording_has_stone_soups_numbers(values, confirm, end):
    case = values[f"B_TUD-Campus_CEM_confirm{confirm}_end{end}"]
    frames = frames_of(values["B_states"]["truths"], values["B_states"]["tracks"])
    intervals = intervals_of(case["associations"], str)
    assert_same(siap(frames, intervals, **COMPONENTS), case["metrics"])


T0 = datetime(2024, 1, 1)
IDENTITIES = (None, "red", "blue")


@st.composite
def scenes(draw):
    """Targets and tracks that are born and die, close enough to be confused, with identities."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    sides = []
    for least, most in ((1, 4), (1, 5)):
        paths = []
        for _ in range(draw(st.integers(least, most))):
            start = int(rng.integers(0, 8))
            steps = range(start, start + int(rng.integers(2, 16)))
            walk = rng.normal(size=(len(steps), 4)).cumsum(axis=0) * 0.3
            paths.append([{"t": float(t), "state": s} for t, s in zip(steps, walk, strict=True)])
        sides.append(paths)
    said = [{row["t"]: IDENTITIES[int(rng.integers(3))] for row in path} for path in sides[1]]
    true = [IDENTITIES[int(rng.integers(3))] for _ in sides[0]]
    return *sides, true, said, float(rng.uniform(0.3, 2)), int(rng.integers(2, 5)), rng


def random_intervals(rng, truths, tracks):
    """Intervals of at least two times in which both are present."""
    found = []
    for i, truth in enumerate(truths):
        for j, track in enumerate(tracks):
            both = sorted({r["t"] for r in truth} & {r["t"] for r in track})
            while len(both) > 1 and rng.random() < 0.6:
                a, b = sorted(rng.choice(len(both), 2, replace=False))
                # Of two that end together Stone Soup takes whichever its set has first.
                if all((i, both[b]) != (k, end) for k, _, _, end in found):
                    found.append((i, j, both[a], both[b]))
    return found


def stone_soup(truths, tracks, true=None, said=None):
    from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
    from stonesoup.types.state import State
    from stonesoup.types.track import Track

    def at(t):
        return T0 + timedelta(seconds=t)

    paths = [
        GroundTruthPath(
            [
                GroundTruthState(r["state"], timestamp=at(r["t"]), metadata={"identity": label})
                for r in path
            ]
        )
        for path, label in zip(truths, true or [None] * len(truths), strict=True)
    ]
    followed = []
    for j, path in enumerate(tracks):
        track = Track([State(r["state"], timestamp=at(r["t"])) for r in path])
        if said:
            track.metadatas = [{"identity": said[j][r["t"]]} for r in path]
        followed.append(track)
    return paths, followed


def stone_soup_values(paths, followed, intervals):
    from stonesoup.measures import Euclidean
    from stonesoup.metricgenerator.manager import MultiManager
    from stonesoup.metricgenerator.tracktotruthmetrics import IDSIAPMetrics
    from stonesoup.types.association import AssociationSet, TimeRangeAssociation
    from stonesoup.types.time import TimeRange

    generator = IDSIAPMetrics(
        position_measure=Euclidean((0, 2)),
        velocity_measure=Euclidean((1, 3)),
        truth_id="identity",
        track_id="identity",
    )
    manager = MultiManager([generator])
    manager.add_data({"groundtruth_paths": paths, "tracks": followed})
    manager.association_set = AssociationSet(
        {
            TimeRangeAssociation(
                [followed[j], paths[i]],
                TimeRange(*(T0 + timedelta(seconds=float(t)) for t in (a, b))),
            )
            for i, j, a, b in intervals
        }
    )
    found = {}
    for metric in generator.compute_metric(manager):
        value = metric.value
        found[metric.title] = [v.value for v in value] if isinstance(value, list) else value
    return found


@pytest.mark.peers
@given(scenes())
@settings(max_examples=100)
def test_random_scenes_have_stone_soups_numbers(scene):
    truths, tracks, true, said, *_, rng = scene
    intervals = random_intervals(rng, truths, tracks)
    expected = stone_soup_values(*stone_soup(truths, tracks, true, said), intervals)
    found = siap(
        frames_of(truths, tracks),
        intervals,
        **COMPONENTS,
        truth_identities=dict(enumerate(true)),
        track_identities=dict(enumerate(said)),
    )
    assert NAMES.keys() <= expected.keys()
    assert_same(found, expected)


@pytest.mark.peers
@given(scenes())
@settings(max_examples=100)
def test_random_scenes_have_stone_soups_associations(scene):
    from stonesoup.dataassociator.tracktotrack import TrackToTruth
    from stonesoup.measures import Euclidean

    truths, tracks, _, _, threshold, count, rng = scene
    end = int(rng.integers(1, 4))
    paths, followed = stone_soup(truths, tracks)
    associator = TrackToTruth(
        association_threshold=threshold,
        consec_pairs_confirm=count,
        consec_misses_end=end,
        measure=Euclidean((0, 1, 2, 3)),
    )
    expected = set()
    for association in associator.associate_tracks(set(followed), set(paths)):
        track, path = association.objects
        ranges = getattr(association.time_range, "time_ranges", [association.time_range])
        for one in ranges:
            limits = ((t - T0).total_seconds() for t in (one.start, one.end))
            expected.add((paths.index(path), followed.index(track), *limits))
    frames = frames_of(truths, tracks)
    assert set(associate(frames, threshold=threshold, confirm=count, end=end)) == expected


ONE = {"truth_positions": np.arange(10.0)[:, None], "track_positions": np.arange(20.0)[:, None]}
STEPS = list(range(10))


def one_target():
    return TrackFrames.from_columns(STEPS, ["a"] * 10, STEPS * 2, [1] * 10 + [2] * 10, **ONE)


def test_definition_counts_on_where_stone_soup_stops():
    intervals = [("a", 1, 0, 5), ("a", 2, 3, 6), ("a", 1, 8, 9)]
    frames = one_target()
    stopped, whole = (
        siap(frames, intervals, protocol=p).rate_of_track_number_change
        for p in ("stonesoup", "definition")
    )
    # Track 1 goes first, to 5; track 2 has one time, 6; then Stone Soup does not look at 8.
    assert (stopped, whole) == (1 / 7, 2 / 7)


def test_definition_takes_the_longest_single_association():
    intervals = [("a", 1, 0, 2), ("a", 1, 5, 9), ("a", 2, 3, 4)]
    frames = one_target()
    assert siap(frames, intervals).longest_track_segment == 6 / 9
    assert siap(frames, intervals, protocol="definition").longest_track_segment == 4 / 9


def test_definition_has_no_value_without_a_denominator():
    found = siap(one_target(), [], protocol="definition")
    assert found.completeness == 0
    assert found.spuriousness == 1
    assert math.isnan(found.ambiguity)
    assert math.isnan(found.position_accuracy)
    zero = siap(one_target(), [])
    assert (zero.ambiguity, zero.position_accuracy) == (1, 0)


def test_dates_count_in_seconds():
    times = np.datetime64("2024-01-01T00:00") + np.arange(10) * np.timedelta64(1, "m")
    both = np.concatenate([times, times])
    frames = TrackFrames.from_columns(times, ["a"] * 10, both, [1] * 10 + [2] * 10, **ONE)
    found = siap(frames, [("a", 1, times[0], times[4]), ("a", 2, times[5], times[9])])
    assert found.rate_of_track_number_change == 1 / 480
    assert found.longest_track_segment == 4 / 9


@pytest.mark.parametrize(
    ("intervals", "message"),
    [
        ([("b", 1, 0, 1)], r"associations\[0\] names the truth 'b', which has no row"),
        ([("a", 9, 0, 1)], r"associations\[0\] names the track 9, which has no row"),
        ([("a", 1, 1, 0)], r"associations\[0\] ends at 0, before it starts"),
        ([("a", 1)], r"associations\[0\] must be \(truth id, track id, first time, last time\)"),
    ],
)
def test_wrong_associations_are_named(intervals, message):
    with pytest.raises(ValueError, match=message):
        siap(one_target(), intervals)


def test_identification_needs_both_sides():
    with pytest.raises(ValueError, match="track_identities is missing"):
        siap(one_target(), [], truth_identities={"a": "red"})
