"""Events and tables in columns, from the matched pairs of all frames."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.tracking.frames import FrameColumns, TrackFrames
from trackmetrics.tracking.matches import Event, Matches

Columns = dict[str, NDArray[Any]]
EVENTS = ("match", "miss", "false alarm", "switch", "transfer", "fragmentation")


def event_log(frames: TrackFrames, matches: Matches, distances: NDArray[np.float64]) -> Columns:
    """time, truth, track, event and distance of every event, in the order of time."""
    truth, tracks = frames.truth, frames.tracks
    of_interest = (Event.SWITCH, Event.TRANSFER, Event.FRAGMENTATION)
    pairs = [np.arange(len(distances)), *(np.flatnonzero(matches.has(e)) for e in of_interest)]
    missed = np.setdiff1d(np.arange(len(truth)), matches.truth_rows)
    false = np.setdiff1d(np.arange(len(tracks)), matches.track_rows)
    paired = np.concatenate(pairs)
    rows = np.concatenate([matches.truth_rows[paired], missed, np.full(len(false), -1)])
    columns = np.concatenate([matches.track_rows[paired], np.full(len(missed), -1), false])
    kinds = (0, 3, 4, 5, 1, 2)
    counts = [*map(len, pairs), len(missed), len(false)]
    kind = np.repeat(kinds, counts)
    time = np.where(rows >= 0, _frame(truth, rows), _frame(tracks, columns))
    distance = np.full(len(rows), np.nan)
    distance[: len(paired)] = distances[paired]
    order = np.lexsort((kind, columns, rows < 0, rows, time))
    return {
        "time": frames.times[time[order]],
        "truth": _names(truth, rows[order]),
        "track": _names(tracks, columns[order]),
        "event": np.array(EVENTS, dtype=object)[kind[order]],
        "distance": distance[order],
    }


def _frame(side: FrameColumns, rows: NDArray[Any]) -> NDArray[np.int64]:
    """The frame of each row; that of row -1 means nothing."""
    return np.maximum(np.searchsorted(side.starts, rows, side="right") - 1, 0).astype(np.int64)


def _names(side: FrameColumns, rows: NDArray[Any]) -> NDArray[Any]:
    """The id of each row; None for row -1."""
    names: NDArray[Any] = np.empty(len(side.names) + 1, dtype=object)
    names[:-1] = list(side.names)
    names[-1] = None
    codes = np.append(side.ids, len(side.names))
    named: NDArray[Any] = names[codes[rows]]
    return named


def _spans(frames: TrackFrames, side: FrameColumns) -> Columns:
    """id, first and last time and number of rows of each id."""
    at = np.repeat(np.arange(len(frames)), np.diff(side.starts))
    n = len(side.names)
    first, last = np.full(n, len(frames)), np.full(n, -1)
    np.minimum.at(first, side.ids, at)
    np.maximum.at(last, side.ids, at)
    names = np.empty(n, dtype=object)
    names[:] = list(side.names)
    counts = np.bincount(side.ids, minlength=n)
    return {"id": names, "first": frames.times[first], "last": frames.times[last], "rows": counts}


def _distinct(keys: NDArray[Any], values: NDArray[Any], n: int) -> tuple[Any, Any]:
    """How many different values each key has, and how often its most frequent one."""
    pairs, counts = np.unique(np.stack([keys, values]), axis=1, return_counts=True)
    most = np.zeros(n, dtype=np.int64)
    np.maximum.at(most, pairs[0], counts)
    return np.bincount(pairs[0], minlength=n), most


def object_rows(frames: TrackFrames, matches: Matches, distances: NDArray[np.float64]) -> Columns:
    """A row for each truth object."""
    ids, n = frames.truth.ids[matches.truth_rows], len(frames.truth.names)
    partners = frames.tracks.ids[matches.track_rows]
    switch = matches.has(Event.SWITCH)
    found = _spans(frames, frames.truth)
    matched = np.bincount(ids, minlength=n)
    squares = np.bincount(ids, weights=distances**2, minlength=n)
    mean = np.divide(squares, matched, out=np.full(n, np.nan), where=matched > 0)
    return found | {
        "matched": matched,
        "share": matched / found["rows"],
        "tracks": _distinct(ids, partners, n)[0],
        "switches": np.bincount(ids[switch], minlength=n),
        "rmse": np.sqrt(mean),
    }


def track_rows(frames: TrackFrames, matches: Matches) -> Columns:
    """A row for each track."""
    ids, n = frames.tracks.ids[matches.track_rows], len(frames.tracks.names)
    found = _spans(frames, frames.tracks)
    matched = np.bincount(ids, minlength=n)
    objects, most = _distinct(ids, frames.truth.ids[matches.truth_rows], n)
    return found | {
        "matched": matched,
        "purity": np.divide(most, matched, out=np.full(n, np.nan), where=matched > 0),
        "objects": objects,
        "false_share": 1 - matched / found["rows"],
    }
