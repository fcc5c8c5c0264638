"""Purity, fragmentation and switches against brute force, reference, peer and recordings."""

import datetime
import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import _native, _numpy, identity_switches, track_fragmentation, track_purity

BACKENDS = [_native, _numpy]
METRICS = [track_purity, track_fragmentation, identity_switches]


def purity_by_definition(true, estimated):
    if not true:
        return 1.0
    correct = 0
    for track in set(estimated):
        inside = [t for t, e in zip(true, estimated, strict=True) if e == track]
        correct += max(inside.count(t) for t in inside)
    return correct / len(true)


def changes_by_definition(keys, values, times):
    rows = list(zip(keys, values, strict=True))
    if times is not None:
        rows = [rows[i] for i in sorted(range(len(rows)), key=lambda i: times[i])]
    count = 0
    for key in set(keys):
        seen = [v for k, v in rows if k == key]
        count += sum(a != b for a, b in itertools.pairwise(seen))
    return count


FEW = st.integers(-2, 2)
WIDE = st.sampled_from([-(2**63), -(2**62), -1, 0, 2**32, 2**33, 2**63 - 1])


@st.composite
def observations(draw, label=None):
    n = draw(st.integers(0, 12))
    label = draw(st.sampled_from([FEW, WIDE])) if label is None else label
    lists = [draw(st.lists(label, min_size=n, max_size=n)) for _ in range(2)]
    times = draw(st.none() | st.lists(st.integers(-3, 3), min_size=n, max_size=n))
    return *lists, times


def ids(values):
    return None if values is None else np.array(values, dtype=np.int64)


@given(observations())
def test_kernel_reference_and_definition_agree(case):
    true, estimated, times = case
    t, e, when = ids(true), ids(estimated), ids(times)
    for kernels in BACKENDS:
        assert kernels.track_purity(t, e) == purity_by_definition(true, estimated)
        assert kernels.track_fragmentation(t, e, when) == changes_by_definition(
            true, estimated, times
        )
        assert kernels.identity_switches(t, e, when) == changes_by_definition(
            estimated, true, times
        )


ANY = st.sampled_from(["a", "b", "1", 1, 2, 1.5, None, (0, 1), (0, 2), b"a", 2**70])


@given(observations(label=ANY))
def test_any_hashable_is_a_label(case):
    true, estimated, times = case
    assert track_purity(true, estimated) == purity_by_definition(true, estimated)
    assert track_fragmentation(true, estimated, times) == changes_by_definition(
        true, estimated, times
    )
    assert identity_switches(tuple(true), tuple(estimated), times) == changes_by_definition(
        estimated, true, times
    )


TRUE = [3, 3, 1, 1, 3, 1, 2, 2]
ESTIMATED = [0, 1, 1, 0, 0, 0, 2, 1]
TIMES = [5, 1, 2, 2, 4, 3, 1, 0]
EXPECTED = (
    purity_by_definition(TRUE, ESTIMATED),
    changes_by_definition(TRUE, ESTIMATED, TIMES),
    changes_by_definition(ESTIMATED, TRUE, TIMES),
)


@pytest.mark.parametrize(
    "form",
    [
        list,
        tuple,
        np.array,
        lambda v: np.array(v, dtype=np.uint8),
        lambda v: np.array(v, dtype=np.uint64) + np.uint64(2**63),
        lambda v: np.array(v, dtype=np.float32) / 4,
        lambda v: np.array(v, dtype=np.float64),
        lambda v: np.array(v) * 1e300,
        lambda v: np.array([str(x) for x in v]),
        lambda v: np.array(v, dtype=object),
        lambda v: np.array([complex(x, 1) for x in v]),
        lambda v: np.array(v, dtype="M8[D]"),
        lambda v: np.repeat(np.array(v), 2)[::2],
        lambda v: [f"track {x}" for x in v],
        lambda v: [2**70 + x for x in v],
        lambda v: [(x, "a") for x in v],
    ],
)
def test_every_form_of_label(form):
    true, estimated = form(TRUE), form(ESTIMATED)
    assert track_purity(true, estimated) == EXPECTED[0]
    assert track_fragmentation(true, estimated, TIMES) == EXPECTED[1]
    assert identity_switches(true, estimated, TIMES) == EXPECTED[2]


@pytest.mark.parametrize(
    "form",
    [
        tuple,
        lambda v: np.array(v, dtype=np.int8),
        lambda v: np.array(v, dtype=np.uint64) + np.uint64(2**63),
        lambda v: np.array(v) / 4 - 0.5,
        lambda v: np.array(v, dtype="M8[s]"),
        lambda v: [datetime.date(2020, 1, 1 + x) for x in v],
        lambda v: [f"2020-01-0{x}" for x in v],
        lambda v: [2**70 + x for x in v],
    ],
)
def test_every_form_of_time(form):
    assert track_fragmentation(TRUE, ESTIMATED, form(TIMES)) == EXPECTED[1]
    assert identity_switches(TRUE, ESTIMATED, time_indices=form(TIMES)) == EXPECTED[2]


def test_results_are_python_numbers():
    results = [metric(np.array(TRUE), np.array(ESTIMATED)) for metric in METRICS]
    assert [type(result) for result in results] == [float, int, int]


def test_nothing_is_pure_and_does_not_change():
    assert [metric([], []) for metric in METRICS] == [1.0, 0, 0]
    assert [metric(np.array([]), ()) for metric in METRICS] == [1.0, 0, 0]


def test_equal_times_keep_their_order():
    # The peer sorts unstably: 8 of these on one machine, 9 on another.
    labels = [0, 1] * 5
    assert track_fragmentation([0] * 10, labels, [0] * 10) == 9


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize(
    ("true", "estimated", "error", "text"),
    [
        ([1, 2], [1], ValueError, "estimated_labels has 1 labels, true_labels has 2"),
        (np.array([1, 2]), [], ValueError, "estimated_labels has 0 labels, true_labels has 2"),
        (np.eye(2), [1, 2], ValueError, "true_labels has shape (2, 2), expected (n,)"),
        ([1], np.array(5), ValueError, "estimated_labels has shape (), expected (n,)"),
        ([1.0, math.nan], [1, 2], ValueError, "true_labels[1] is nan"),
        ([1, 2], np.array([1, np.nan]), ValueError, "estimated_labels[1] is nan"),
        ([1], np.array(["NaT"], dtype="M8[s]"), ValueError, "estimated_labels[0] is NaT"),
        (
            [1, [2]],
            [1, 2],
            TypeError,
            "true_labels[1] must be a label that can be hashed, got list",
        ),
        ("abc", [1, 2, 3], TypeError, "true_labels must be a list or array, got str"),
    ],
)
def test_bad_labels_are_named(metric, true, estimated, error, text):
    with pytest.raises(error) as raised:
        metric(true, estimated)
    assert str(raised.value) == text


@pytest.mark.parametrize("metric", METRICS[1:])
@pytest.mark.parametrize(
    ("times", "error", "text"),
    [
        ([0], ValueError, "time_indices has 1 times, true_labels has 2"),
        ([0.0, math.nan], ValueError, "time_indices[1] is nan"),
        ([1, "a"], TypeError, "time_indices holds times that cannot be ordered"),
        ([[1, 2]], ValueError, "time_indices has shape (1, 2), expected (n,)"),
    ],
)
def test_bad_times_are_named(metric, times, error, text):
    with pytest.raises(error) as raised:
        metric([1, 2], [1, 2], times)
    assert str(raised.value) == text


@pytest.mark.parametrize("kernels", BACKENDS)
def test_kernels_name_what_is_wrong_alike(kernels):
    one, two = ids([1]), ids([1, 2])
    with pytest.raises(ValueError, match=r"^estimated_labels has 1 labels, true_labels has 2$"):
        kernels.track_purity(two, one)
    with pytest.raises(ValueError, match=r"^time_indices has 1 times, true_labels has 2$"):
        kernels.identity_switches(two, two, one)


@pytest.mark.peers
def test_the_peer_agrees():
    from pytcl import performance_evaluation as peer

    rng = np.random.default_rng(1)
    for _ in range(2000):
        n, k = rng.integers(0, 40), rng.integers(1, 8)
        true, estimated = rng.integers(-1, k, (2, n))
        times = rng.permutation(n) * 0.5
        assert track_purity(true, estimated) == peer.track_purity(true, estimated)
        for name in ["track_fragmentation", "identity_switches"]:
            ours, theirs = getattr(trackmetrics, name), getattr(peer, name)
            assert ours(true, estimated) == theirs(true, estimated)
            assert ours(true, estimated, times) == theirs(true, estimated, times)


@pytest.mark.data
def test_recordings(data):
    files = sorted((data / "mot" / "values").glob("*.pytcl.json"))
    records = [record for file in files if "labels" in (record := json.loads(file.read_text()))]
    assert len(records) >= 3
    for record in records:
        labels = record["labels"]
        true, estimated = labels["true"], labels["estimated"]
        assert track_purity(true, estimated) == record["track_purity"]
        for name in ["track_fragmentation", "identity_switches"]:
            metric = getattr(trackmetrics, name)
            assert metric(true, estimated) == record[name]
            assert metric(true, estimated, labels["frame"]) == record[f"{name}_with_time"]
