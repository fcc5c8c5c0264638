"""Identity scores and HOTA: reference implementations of ``identity`` and ``hota`` in the core."""

import numpy as np

from trackmetrics._numpy.arguments import Floats, plain, plain_numbers
from trackmetrics._numpy.assignment import linear_sum_assignment
from trackmetrics._numpy.similar_pairs import Codes, PairColumns, PairMatrices, SideColumns
from trackmetrics._similarity import EPS


def identities(
    truth: SideColumns, tracks: SideColumns, pairs: PairColumns, by_distance: bool, limit: float
) -> tuple[Codes, Codes, Codes, Codes, int]:
    """Targets and tracks that meet: (targets, tracks, counts, assigned, true positives)."""
    plain_numbers(limit)
    matrices = PairMatrices(truth, tracks, pairs)
    together = np.zeros((truth[2], tracks[2]), dtype=np.int64)
    for _, rows, columns in matrices.frames():
        if by_distance:
            near = np.isfinite(matrices.distance(rows, columns, limit))
        else:
            near = matrices.similarity(rows, columns) >= limit
        together[np.ix_(truth[0][rows], tracks[0][columns])] += near
    targets, others = np.nonzero(together)
    assigned = np.full(truth[2], -1)
    i, j = linear_sum_assignment(together.astype(np.float64), True)
    kept = together[i, j] > 0
    assigned[i[kept]] = j[kept]
    return targets, others, together[targets, others], assigned, int(together[i, j].sum())


def hota(
    truth: SideColumns, tracks: SideColumns, pairs: PairColumns, thresholds: Floats
) -> tuple[Codes, Floats, Floats, Floats, Floats]:
    """At each threshold: (true positives, sum of similarities, AssA, AssRe, AssPr)."""
    plain(thresholds)
    matrices = PairMatrices(truth, tracks, pairs)
    rows = np.bincount(truth[0], minlength=truth[2])
    columns = np.bincount(tracks[0], minlength=tracks[2])
    targets, others, values = _match(matrices, _agreement(matrices, rows, columns))
    kept = values >= thresholds[:, None]
    codes, of_pair = np.unique(targets * tracks[2] + others, return_inverse=True)
    i, j = np.divmod(codes, max(1, tracks[2]))
    counts = (np.bincount(of_pair[k], minlength=len(i)) for k in kept)
    means = np.array([_association(n, rows[i], columns[j]) for n in counts]).reshape(-1, 3)
    sums = np.array([values[k].sum() for k in kept], dtype=np.float64)
    return kept.sum(axis=1), sums, *(np.ascontiguousarray(part) for part in means.T)


def _agreement(matrices: PairMatrices, rows: Codes, columns: Codes) -> Floats:
    """How well each target and each track agree over the sequence, before any assignment."""
    shared = np.zeros((len(rows), len(columns)))
    for _, i, j in matrices.frames():
        similarity = matrices.similarity(i, j)
        union = similarity.sum(axis=0) + similarity.sum(axis=1)[:, None] - similarity
        part = np.divide(similarity, union, out=np.zeros_like(similarity), where=union > EPS)
        shared[np.ix_(matrices.truth[0][i], matrices.tracks[0][j])] += part
    agreement: Floats = shared / (rows[:, None] + columns - shared)
    return agreement


def _match(matrices: PairMatrices, agreement: Floats) -> tuple[Codes, Codes, Floats]:
    """Target, track and similarity of the pairs with the largest total in each frame."""
    none = np.empty(0, dtype=np.int64)
    found = [(none, none, np.empty(0))]
    for _, rows, columns in matrices.frames():
        similarity = matrices.similarity(rows, columns)
        ids, others = matrices.truth[0][rows], matrices.tracks[0][columns]
        i, j = linear_sum_assignment(agreement[np.ix_(ids, others)] * similarity, True)
        found.append((ids[i], others[j], similarity[i, j]))
    targets, tracks, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return targets, tracks, values


def _association(n: Codes, rows: Codes, columns: Codes) -> Floats:
    """AssA, AssRe and AssPr of one alpha, from the numbers of pairs of a target and a track and
    the numbers of rows of either; 0 without a pair."""
    shares = np.stack([n / (rows + columns - n), n / rows, n / columns])
    means: Floats = (n * shares).sum(axis=1) / max(1, n.sum())
    return means
