"""CLEAR MOT: reference implementation of ``clear_mot`` in the core."""

import numpy as np
from numpy.typing import NDArray

from trackmetrics._numpy.arguments import Floats, plain_numbers
from trackmetrics._numpy.assignment import linear_sum_assignment
from trackmetrics._numpy.similar_pairs import Codes, PairColumns, PairMatrices, SideColumns
from trackmetrics._similarity import EPS

Flags = NDArray[np.bool_]

# TrackEval's weight of a continued pair. It rounds similarities to 1e-13, so that another weight
# could break ties in another way.
_CONTINUED = 1000.0


def clear_mot(
    truth: SideColumns,
    tracks: SideColumns,
    pairs: PairColumns,
    rules: tuple[bool, bool, bool],
    limit: float,
) -> tuple[Codes, Floats, Codes, Codes, float]:
    """Truth and tracks matched frame by frame: (partners, values, events, matched, total)."""
    plain_numbers(limit)
    matrices = PairMatrices(truth, tracks, pairs)
    forgets, most_similar, own_frames = rules
    rows, columns, values, continued = _match(matrices, forgets, most_similar, limit)
    partners = np.full(len(truth[0]), -1)
    partners[rows] = columns
    by_row = np.full(len(truth[0]), np.nan)
    by_row[rows] = values
    events = np.zeros(len(truth[0]), dtype=np.int64)
    targets, others = truth[0][rows], tracks[0][columns]
    times = np.searchsorted(truth[1], rows, side="right")
    events[rows] = _events(targets, others, times, continued)
    clock = _clock(truth, tracks, own_frames)[rows]
    events[rows] += 32 * _is_interrupted(targets, clock)
    matched = np.bincount(targets, minlength=truth[2])
    return partners, by_row, events, matched, float(values.sum())


def _match(
    matrices: PairMatrices, forgets: bool, most_similar: bool, limit: float
) -> tuple[Codes, Codes, Floats, Flags]:
    """Truth row, track row and value of each pair, and whether it continues an earlier one."""
    last = np.full(matrices.truth[2], -1, dtype=np.int64)
    none = np.empty(0, dtype=np.int64)
    found = [(none, none, np.empty(0), np.empty(0, dtype=np.bool_))]
    for _, rows, columns in matrices.frames():
        ids, others = matrices.truth[0][rows], matrices.tracks[0][columns]
        wanted = last[ids][:, None] == others
        if most_similar:
            values = matrices.similarity(rows, columns)
            i, j, fixed = _most_similar(values, wanted, limit)
        else:
            values = matrices.distance(rows, columns, limit)
            i, j, fixed = _continue_then_assign(values, wanted)
        if forgets:
            last[:] = -1
        last[ids[i]] = others[j]
        found.append((i + rows.start, j + columns.start, values[i, j], fixed))
    i, j, values, fixed = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return i, j, values, fixed


def _most_similar(similarities: Floats, wanted: Flags, least: float) -> tuple[Codes, Codes, Flags]:
    """Rows and columns of the pairs with the largest total score."""
    scores = _CONTINUED * wanted + similarities
    scores[similarities < least] = 0
    rows, columns = linear_sum_assignment(scores, True)
    kept = scores[rows, columns] > EPS
    rows, columns = rows[kept], columns[kept]
    return rows, columns, wanted[rows, columns]


def _continue_then_assign(distances: Floats, wanted: Flags) -> tuple[Codes, Codes, Flags]:
    """Rows and columns of the continued pairs, then of the largest assignment of least cost."""
    rows, columns = np.nonzero(wanted & np.isfinite(distances))
    columns, first = np.unique(columns, return_index=True)  # the first target that wants it
    rows = rows[first]
    free = distances.copy()
    free[rows] = np.nan
    free[:, columns] = np.nan
    finite = np.isfinite(free)
    if not finite.any():
        return rows, columns, np.ones(len(rows), dtype=np.bool_)
    # A cost that no assignment takes where it can have one more pair instead.
    large = 2 * min(free.shape) * (np.abs(free[finite]).max() + 1) + 1
    more, others = linear_sum_assignment(np.where(finite, free, large), False)
    kept = finite[more, others]
    continued = np.repeat([True, False], [len(rows), int(kept.sum())])
    return np.append(rows, more[kept]), np.append(columns, others[kept]), continued


def _events(targets: Codes, tracks: Codes, times: Codes, continued: Flags) -> Codes:
    """What happens with each pair, as bits of a number. A continued pair is no transfer, and the
    target that a track was last assigned to is not changed by it."""
    assigned = np.flatnonzero(~continued)
    transfer = np.zeros(len(targets), dtype=np.bool_)
    transfer[assigned] = _changed(tracks[assigned], targets[assigned], times[assigned])
    switch = _changed(targets, tracks, times)
    ascend, migrate = switch & _is_first(tracks, times), transfer & _is_first(targets, times)
    bits: Codes = np.array([1, 2, 4, 8, 16]) @ np.stack(
        [continued, switch, transfer, ascend, migrate]
    )
    return bits


def _clock(truth: SideColumns, tracks: SideColumns, own_frames: bool) -> Codes:
    """For each truth row a number; matched rows of a target are consecutive where it rises by 1."""
    ids, starts, _ = truth
    if not own_frames:
        both = (np.diff(starts) > 0) & (np.diff(tracks[1]) > 0)
        return np.repeat(np.cumsum(both), np.diff(starts)).astype(np.int64)
    clock = np.empty(len(ids), dtype=np.int64)
    clock[np.argsort(ids, kind="stable")] = np.arange(len(ids))
    return clock


def _is_interrupted(targets: Codes, clock: Codes) -> Flags:
    """Whether a pair is not the next on the clock after the pair before of its target."""
    order = np.lexsort((clock, targets))
    interrupted = np.zeros(len(targets), dtype=np.bool_)
    same = np.diff(targets[order]) == 0
    interrupted[order[1:]] = same & (np.diff(clock[order]) != 1)
    return interrupted


def _changed(keys: Codes, values: Codes, times: Codes) -> Flags:
    """Whether an element's value differs from that of the element before with the same key."""
    order = np.lexsort((times, keys))
    changed = np.zeros(len(keys), dtype=np.bool_)
    same = np.diff(keys[order]) == 0
    changed[order[1:]] = same & (np.diff(values[order]) != 0)
    return changed


def _is_first(keys: Codes, times: Codes) -> Flags:
    """Whether an element is the earliest of its key."""
    order = np.lexsort((times, keys))
    first = np.zeros(len(keys), dtype=np.bool_)
    first[order] = np.diff(keys[order], prepend=-1) != 0
    return first
