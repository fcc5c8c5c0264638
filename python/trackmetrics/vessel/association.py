"""Which position without identity belongs to which track: gating and global nearest neighbour.

Within a scan every position that can be given to a track is, so that the sum of d^2 + ln det S, the
negative log-likelihood up to a constant, is least (Blackman and Popoli, *Design and Analysis of
Modern Tracking Systems*, 1999, chapter 6). Pairs fall into clusters that share nothing; each is an
assignment problem of its own.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.vessel.settings import Floats

Integers = NDArray[np.int64]


def associate(
    positions: Integers, tracks: Integers, distances: Floats, log_dets: Floats, gate: float
) -> list[tuple[int, int]]:
    """The chosen (position, track) among the pairs within the gate."""
    costs = distances + log_dets
    if len(np.unique(positions)) == len(positions) and len(np.unique(tracks)) == len(tracks):
        return list(zip(positions.tolist(), tracks.tolist(), strict=True))
    chosen = []
    for pairs in _clusters(positions, tracks):
        if len(pairs) == 1:
            chosen.append((int(positions[pairs[0]]), int(tracks[pairs[0]])))
        else:
            chosen += _solve(positions[pairs], tracks[pairs], costs[pairs], gate)
    return sorted(chosen)


def _clusters(positions: Integers, tracks: Integers) -> list[Any]:
    """Indices of the pairs of each connected component."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    rows, columns = np.unique(positions), np.unique(tracks)
    i, j = np.searchsorted(rows, positions), np.searchsorted(columns, tracks) + len(rows)
    size = len(rows) + len(columns)
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(size, size))
    labels = connected_components(graph, directed=False)[1][i]
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)


def _solve(
    positions: Integers, tracks: Integers, costs: Floats, gate: float
) -> list[tuple[int, int]]:
    """One cluster; leaving a position out costs more than any pair, so that most are matched."""
    rows, columns = np.unique(positions), np.unique(tracks)
    span = costs.max() - costs.min() + gate
    matrix = np.full((len(rows), len(columns) + len(rows)), np.inf)
    matrix[:, len(columns) :] = span * (min(len(rows), len(columns)) + 1)
    matrix[np.searchsorted(rows, positions), np.searchsorted(columns, tracks)] = costs - costs.min()
    i, j = linear_sum_assignment(matrix)
    matched = j < len(columns)
    return [(int(rows[a]), int(columns[b])) for a, b in zip(i[matched], j[matched], strict=True)]
