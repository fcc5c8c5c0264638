"""Scores over the identities of tracks: twin of ``tracking`` in the core."""

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import plain_ids

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
    plain_ids(true_labels, estimated_labels, time_indices)
    _same_length(true_labels, estimated_labels, time_indices)
    return _changes(true_labels, estimated_labels, time_indices)


def identity_switches(true_labels: Ids, estimated_labels: Ids, time_indices: Ids | None) -> int:
    """How often the true label of an estimated label changes."""
    plain_ids(true_labels, estimated_labels, time_indices)
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
