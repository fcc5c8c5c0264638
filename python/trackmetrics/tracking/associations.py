"""Which track is associated with which target, and when: the input of the SIAP metrics.

Associations are intervals, both ends included. `Associations` merges those of one pair, and finds
the rows of the two at each time.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors
from trackmetrics._similarity import euclidean_distances
from trackmetrics.tracking.frames import FrameColumns, TrackFrames, as_frames
from trackmetrics.tracks import TrackTable

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]
Interval = tuple[Hashable, Hashable, Any, Any]
"""Target, track, first and last time."""


def associate(
    frames: TrackFrames | TrackTable,
    tracks: TrackTable | None = None,
    *,
    threshold: float,
    confirm: int = 3,
    end: int = 2,
) -> list[Interval]:
    """Associate each track with the target that it is nearest to for some consecutive rows.

    Parameters
    ----------
    frames : TrackFrames or TrackTable
        Truth and tracks of one sequence, with positions or boxes, or the truth alone.
    tracks : TrackTable, optional
        The tracks, where ``frames`` is the truth.
    threshold : float
        Distance from which on a target is not near, in the unit of the positions.
    confirm : int
        Rows of the track, one after the other, that begin an association.
    end : int
        Rows of the track, one after the other and nearest to another target or to none, that end
        it. It then ends with the last row that was nearest to its own target.

    Returns
    -------
    list of (truth id, track id, first time, last time)
        Both times included. A track has at most one target at a time.

    Raises
    ------
    ValueError
        Where ``threshold`` is not above 0, ``confirm`` or ``end`` is no whole number of at least 1,
        or there are neither positions nor boxes.

    Notes
    -----
    The rules are those of Stone Soup 1.9's ``TrackToTruth``. Of equally near targets the first in
    the frame counts.

    Examples
    --------
    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 3, 4], ["ferry"] * 4, [1, 2, 3, 4], [7] * 4,
    ...     truth_positions=[[0], [1], [2], [3]], track_positions=[[0], [1], [2], [9]],
    ... )
    >>> associate(frames, threshold=1.0)
    [('ferry', 7, 1, 3)]
    """
    frames = as_frames(frames, tracks)
    threshold = _check.number("threshold", threshold)
    if not threshold > 0:
        raise errors.parameter("threshold", "above 0", threshold)
    _check.count("confirm", confirm, 1)
    _check.count("end", end, 1)
    nearest = _nearest(frames, threshold)
    order = np.argsort(frames.tracks.ids, kind="stable")
    times = frames.times[_frame_of(frames.tracks)]
    found: list[Interval] = []
    for rows in np.split(order, np.flatnonzero(np.diff(frames.tracks.ids[order])) + 1):
        for target, first, last in _runs(nearest[rows].tolist(), confirm, end):
            found.append(
                (
                    frames.truth.names[target],
                    frames.tracks.names[frames.tracks.ids[rows[0]]],
                    times[rows[first]].item(),
                    times[rows[last]].item(),
                )
            )
    return found


def _nearest(frames: TrackFrames, threshold: float) -> Codes:
    """Code of the nearest target of each track row, -1 where none is near."""
    truth, tracks = frames.truth.centres("truth"), frames.tracks.centres("tracks")
    nearest = np.full(len(tracks), -1, dtype=np.int64)
    for _, rows, columns in frames.slices():
        distances = euclidean_distances(truth[rows], tracks[columns])
        best = distances.argmin(axis=0)
        near = distances.min(axis=0) < threshold
        nearest[columns] = np.where(near, frames.truth.ids[rows][best], -1)
    return nearest


def _runs(nearest: list[int], confirm: int, end: int) -> list[tuple[int, int, int]]:
    """Target, first and last row of each association of one track."""
    found = []
    current, start, last, misses = -1, 0, 0, 0
    candidate, hits, since = -1, 0, 0
    for k, target in enumerate(nearest):
        if current >= 0 and target == current:
            misses, last = 0, k
            continue
        if target >= 0 and target == candidate:
            hits += 1
        else:
            candidate, hits, since = target, int(target >= 0 or current >= 0), k
        if current >= 0:
            misses += 1
            if misses < end:
                continue
            found.append((current, start, last))
            # The peer counts the failures anew only after a row that is near.
            if hits >= confirm and candidate >= 0:
                current, start, last = candidate, since, k
            else:
                current = -1
        elif hits >= confirm and candidate >= 0:
            current, start, last, candidate, hits = candidate, since, k, -1, 0
    if current >= 0:
        found.append((current, start, last))
    return found


def _frame_of(side: FrameColumns) -> Codes:
    """Frame of each row."""
    return np.repeat(np.arange(len(side.starts) - 1), np.diff(side.starts))


@dataclass(frozen=True, eq=False)
class Associations:
    """Intervals by target and track, and the pairs of rows within them."""

    truth: Codes
    """Code of the target of each interval, shape (k,). Intervals of one pair do not touch."""
    track: Codes
    """Code of its track."""
    limits: Floats
    """First and last time, both included, in seconds or the unit of the times, shape (k, 2)."""
    frame: Codes
    """Frame of each pair of rows, shape (n,)."""
    truth_row: Codes
    """Row of the target."""
    track_row: Codes
    """Row of the track."""


def find_pairs(frames: TrackFrames, intervals: Iterable[Interval]) -> Associations:
    """Merge the intervals of each pair, and find the rows of the two within them."""
    truth, track, limits = _merge(*_codes(frames, intervals))
    times = clock(frames)
    first = np.searchsorted(times, limits[:, 0], side="left")
    counts = np.searchsorted(times, limits[:, 1], side="right") - first
    of = np.repeat(np.arange(len(truth)), counts)
    frame = first[of] + np.arange(len(of)) - (np.cumsum(counts) - counts)[of]
    rows = _row(frames.truth, frame, truth[of]), _row(frames.tracks, frame, track[of])
    both = (rows[0] >= 0) & (rows[1] >= 0)
    return Associations(truth, track, limits, frame[both], rows[0][both], rows[1][both])


def clock(frames: TrackFrames) -> Floats:
    """The times as numbers: dates in seconds since the first."""
    if frames.times.dtype.kind in "mM":
        since = frames.times - frames.times[:1]
        return np.asarray(since / np.timedelta64(1, "s"), dtype=np.float64)
    return frames.times.astype(np.float64)


def _codes(frames: TrackFrames, intervals: Iterable[Interval]) -> tuple[Codes, Codes, Floats]:
    truths = {name: code for code, name in enumerate(frames.truth.names)}
    tracks = {name: code for code, name in enumerate(frames.tracks.names)}
    found, limits = [], []
    for i, interval in enumerate(intervals):
        if not isinstance(interval, tuple | list) or len(interval) != 4:
            raise ValueError(
                f"associations[{i}] must be (truth id, track id, first time, last time), "
                f"got {interval!r}"
            )
        for name, known, side in ((interval[0], truths, "truth"), (interval[1], tracks, "track")):
            if name not in known:
                raise ValueError(f"associations[{i}] names the {side} {name!r}, which has no row")
        found.append((truths[interval[0]], tracks[interval[1]]))
        limits.append(_limits(frames, i, interval))
    codes = np.array(found, dtype=np.int64).reshape(-1, 2)
    return codes[:, 0], codes[:, 1], np.array(limits, dtype=np.float64).reshape(-1, 2)


def _limits(frames: TrackFrames, i: int, interval: Interval) -> list[float]:
    both: tuple[Any, ...] = interval[2:]
    if frames.times.dtype.kind in "mM":
        second = np.timedelta64(1, "s")
        both = tuple(float((np.datetime64(t) - frames.times[0]) / second) for t in both)
    start, end = (_check.number(f"associations[{i}]", t) for t in both)
    if not start <= end:
        raise ValueError(f"associations[{i}] ends at {interval[3]}, before it starts")
    return [start, end]


def _merge(truth: Codes, track: Codes, limits: Floats) -> tuple[Codes, Codes, Floats]:
    """Intervals of one pair that overlap or touch become one."""
    order = np.lexsort((limits[:, 0], track, truth))
    merged: list[list[float]] = []
    codes: list[tuple[int, int]] = []
    for i, j, (start, end) in zip(truth[order], track[order], limits[order], strict=True):
        if codes and codes[-1] == (i, j) and start <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            codes.append((i, j))
            merged.append([start, end])
    pairs = np.array(codes, dtype=np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1], np.array(merged, dtype=np.float64).reshape(-1, 2)


def _row(side: FrameColumns, frame: Codes, code: Codes) -> Codes:
    """Row of a code in a frame, -1 where it has none."""
    if not len(side):
        return np.full(len(frame), -1, dtype=np.int64)
    keys = _frame_of(side) * len(side.names) + side.ids
    order = np.argsort(keys)
    wanted = frame * len(side.names) + code
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    row = order[place]
    return np.where(keys[row] == wanted, row, -1).astype(np.int64)
