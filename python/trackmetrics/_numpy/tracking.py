"""Scores over the identities of tracks: reference implementation of ``tracking`` in the core."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, frames, plain_ids, plain_numbers
from trackmetrics._numpy.assignment import solve

Ids = NDArray[np.int64]


def track_purity(true_labels: Ids, estimated_labels: Ids) -> float:
    """The share of observations with the most frequent true label of their estimated label."""
    plain_ids(true_labels, estimated_labels)
    _same_length(true_labels, estimated_labels, None)
    if not len(true_labels):
        return 1.0
    pairs = np.stack([estimated_labels, true_labels])
    (tracks, _), counts = np.unique(pairs, axis=1, return_counts=True)
    _, starts = np.unique(tracks, return_index=True)
    return int(np.maximum.reduceat(counts, starts).sum()) / len(true_labels)


def track_fragmentation(true_labels: Ids, estimated_labels: Ids, time_indices: Ids | None) -> int:
    """How often the estimated label of a true label changes."""
    plain_ids(true_labels, estimated_labels)
    if time_indices is not None:
        plain_ids(time_indices)
    _same_length(true_labels, estimated_labels, time_indices)
    return _changes(true_labels, estimated_labels, time_indices)


def identity_switches(true_labels: Ids, estimated_labels: Ids, time_indices: Ids | None) -> int:
    """How often the true label of an estimated label changes."""
    plain_ids(true_labels, estimated_labels)
    if time_indices is not None:
        plain_ids(time_indices)
    _same_length(true_labels, estimated_labels, time_indices)
    return _changes(estimated_labels, true_labels, time_indices)


def _same_length(true_labels: Ids, estimated_labels: Ids, time_indices: Ids | None) -> None:
    n = len(true_labels)
    if len(estimated_labels) != n:
        raise errors.length("estimated_labels", len(estimated_labels), "true_labels", n, "labels")
    if time_indices is not None and len(time_indices) != n:
        raise errors.length("time_indices", len(time_indices), "true_labels", n, "times")


def _changes(keys: Ids, values: Ids, times: Ids | None) -> int:
    """How often the value of a key differs from the one before, in a stable order of time."""
    order = np.lexsort((keys,) if times is None else (times, keys))
    keys, values = keys[order], values[order]
    return int(np.count_nonzero((keys[1:] == keys[:-1]) & (values[1:] != values[:-1])))


def mot_metrics(
    ground_truth: Any, estimates: Any, threshold: float
) -> tuple[float, float, int, int, int, int]:
    """CLEAR MOT scores of frames whose list index is the identity."""
    plain_numbers(threshold)
    truth, found = frames("ground_truth", ground_truth), frames("estimates", estimates)
    _check_frames(truth, found, threshold)
    switches = fragmentations = misses = false_positives = matches = 0
    distance = 0.0
    remembered: dict[int, int] = {}  # truth index -> estimate index in the last frame with truth
    matched_before: set[int] = set()
    for x, y in zip(truth, found, strict=True):
        if not len(x):
            false_positives += len(y)
            continue
        pairs = {i: (j, d) for i, j, d in _pairs(x, y) if d <= threshold}
        for i, (j, _) in pairs.items():
            switches += remembered.get(i, j) != j
            fragmentations += i in matched_before and i not in remembered
        matches += len(pairs)
        misses += len(x) - len(pairs)
        false_positives += len(y) - len(pairs)
        distance += sum(d for _, d in pairs.values())
        remembered = {i: j for i, (j, _) in pairs.items()}
        matched_before.update(pairs)
    points = sum(map(len, truth))
    mota = 1 - (misses + false_positives + switches) / points if points else 1.0
    motp = distance / matches if matches else 0.0
    return mota, motp, switches, fragmentations, false_positives, misses


def _check_frames(truth: list[Floats], found: list[Floats], threshold: float) -> None:
    if not threshold >= 0:
        raise errors.parameter("threshold", "at least 0", threshold)
    if len(found) != len(truth):
        raise errors.length("estimates", len(found), "ground_truth", len(truth), "frames")
    x = next((x for x in truth if len(x)), None)
    t, y = next(((t, y) for t, y in enumerate(found) if len(y)), (0, None))
    if x is not None and y is not None and x.shape[1] != y.shape[1]:
        raise errors.dimension("estimates", [t, 0], y.shape[1], x.shape[1])


def _pairs(x: Floats, y: Floats) -> list[tuple[int, int, float]]:
    """The matching of two sets at the least total distance, gated by nothing."""
    if not len(y):
        return []
    with np.errstate(over="ignore"):
        squares = (x[:, None] - y[None]) ** 2
        costs = np.sqrt(squares.cumsum(-1)[..., -1])  # one coordinate after the other
    return [(i, int(j), float(costs[i, j])) for i, j in enumerate(solve(costs)) if j >= 0]
