"""The rows of a log track by track, in the order of time, without repeated ones.

A display that logs every track at every scan repeats the last update until the next one arrives.
Such repeated rows are no data: at the same time they are recognised by equal content; at another
time only where a state or measurement is logged, since a number such as a NIS may repeat by
coincidence. Different updates at one time are updates, in the order given.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs.columns import Columns, Integers, Strings, has_value
from trackmetrics.logs.schema import NUMERIC_COLUMNS, STRING_COLUMNS

ON_REPEATS = ("drop", "keep", "raise")
_CONTENT_COLUMNS = ("x", "z", "innovation", "x_pred", "error")
"""Columns whose repetition to the bit, at another time, shows that nothing was updated."""


class Grouped(NamedTuple):
    """The rows of a log track by track."""

    columns: Columns
    tracks: Sequence[str]
    starts: Sequence[int]
    repeated: Sequence[int]
    """How many repeated rows of each track were dropped."""


def group_by_track(columns: Columns, names: Strings, timed: bool, on_repeats: str) -> Grouped:
    """The columns track by track, in the order in which the tracks first appear."""
    if on_repeats not in ON_REPEATS:
        raise ValueError(f"on_repeats must be one of {', '.join(ON_REPEATS)}, got {on_repeats!r}")
    tracks, inverse = _in_order_of_appearance(names)
    if (np.diff(inverse) < 0).any():
        order = np.argsort(inverse, kind="stable")
        columns, inverse = columns.take(order), inverse[order]
    if not timed:
        columns = columns.replace(time=_count_up(inverse, len(tracks)))
    else:
        _check_rising(columns, inverse, tracks)
    repeated = np.zeros(len(columns), bool)
    if on_repeats != "keep":
        repeated = _repeated(columns, inverse, timed)
    if on_repeats == "raise" and repeated.any():
        k = int(np.argmax(repeated))
        raise ValueError(f"row {columns.row[k]} repeats row {columns.row[k - 1]}")
    dropped = np.bincount(inverse[repeated], minlength=len(tracks))
    if repeated.any():
        columns, inverse = columns.take(~repeated), inverse[~repeated]
        if not timed:
            columns = columns.replace(time=_count_up(inverse, len(tracks)))
    starts = np.searchsorted(inverse, np.arange(len(tracks) + 1))
    return Grouped(columns, tracks, starts.tolist(), dropped.tolist())


def _in_order_of_appearance(names: Strings) -> tuple[list[str], Integers]:
    """The different names, and the index of each row's."""
    heads = np.flatnonzero(np.append(True, names[1:] != names[:-1]))
    place: dict[str, int] = {}
    index = [place.setdefault(name, len(place)) for name in names[heads]]
    if None in place:
        row = int(heads[index.index(place[None])])  # type: ignore[index]
        raise ValueError(f"track[{row}] is missing")
    lengths = np.diff(np.append(heads, len(names)))
    return list(place), np.repeat(np.array(index, np.int64), lengths)


def _count_up(inverse: Integers, tracks: int) -> NDArray[np.float64]:
    starts = np.searchsorted(inverse, np.arange(tracks))
    return (np.arange(len(inverse)) - starts[inverse]).astype(np.float64)


def _check_rising(columns: Columns, inverse: Integers, tracks: Sequence[str]) -> None:
    falls = (np.diff(columns.time) < 0) & (np.diff(inverse) == 0)
    if falls.any():
        k = int(np.argmax(falls)) + 1
        now, before = float(columns.time[k]), float(columns.time[k - 1])
        raise ValueError(
            f"times of track {tracks[inverse[k]]!r} must not fall: "
            f"row {columns.row[k]} is at {now!r}, row {columns.row[k - 1]} at {before!r}"
        )


def _repeated(columns: Columns, inverse: Integers, timed: bool) -> NDArray[np.bool_]:
    """Which rows repeat the one before."""
    same = np.zeros(len(columns), bool)
    same[1:] = np.diff(inverse) == 0
    has_content = np.zeros(len(columns), bool)
    for name in (*NUMERIC_COLUMNS, *STRING_COLUMNS, "observed"):
        column = getattr(columns, name)
        if column is None or not same.any():
            continue
        # Most rows differ in the first columns: only the others are compared in the rest.
        rows = np.flatnonzero(same)
        now, before = column[rows], column[rows - 1]
        equal = now == before
        if name in NUMERIC_COLUMNS:
            equal |= np.isnan(now) & np.isnan(before)
        same[rows] = equal.all(axis=tuple(range(1, column.ndim)))
        if name in _CONTENT_COLUMNS:
            has_content |= has_value(column)
    if timed:
        has_content[1:] |= np.diff(columns.time) == 0
    return same & has_content
