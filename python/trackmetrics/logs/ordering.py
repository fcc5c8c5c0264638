"""The rows of a log track by track, in the order of time, without repeated ones.

A display that logs every track at every scan repeats the last update until the next one arrives.
Such frozen rows are no data: at the same time they are recognised by equal content; at another time
only where a state or measurement is logged, since a number such as a NIS may repeat by chance.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs.columns import FLOATS, WORDS, Columns, Integers, Words, present

_TELLING = ("x", "z", "innovation", "x_pred", "error")


def arrange(
    columns: Columns, names: Words, timed: bool
) -> tuple[Columns, list[str], list[int], list[int]]:
    """The columns track by track; names, first rows, and counts of rows dropped."""
    tracks, inverse = _in_order_of_appearance(names)
    order = np.argsort(inverse, kind="stable")
    columns, inverse = columns.take(order), inverse[order]
    if not timed:
        columns = columns.with_(time=_count_up(inverse, len(tracks)))
    else:
        _check_rising(columns, inverse, tracks)
    frozen = _frozen(columns, inverse, timed)
    if timed:
        _check_times_differ(columns, inverse, tracks, frozen)
    repeated = np.bincount(inverse[frozen], minlength=len(tracks))
    columns, inverse = columns.take(~frozen), inverse[~frozen]
    if not timed:
        columns = columns.with_(time=_count_up(inverse, len(tracks)))
    starts = np.searchsorted(inverse, np.arange(len(tracks) + 1))
    return columns, tracks, starts.tolist(), repeated.tolist()


def _in_order_of_appearance(names: Words) -> tuple[list[str], Integers]:
    place: dict[str, int] = {}
    for row, name in enumerate(names):
        if name is None:
            raise ValueError(f"track[{row}] is missing")
        place.setdefault(name, len(place))
    return list(place), np.array([place[name] for name in names], np.int64)


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


def _frozen(columns: Columns, inverse: Integers, timed: bool) -> NDArray[np.bool_]:
    """Which rows repeat the one before."""
    same = np.zeros(len(columns), bool)
    same[1:] = np.diff(inverse) == 0
    telling = np.zeros(len(columns), bool)
    for name in (*FLOATS, *WORDS, "observed"):
        column = getattr(columns, name)
        if column is None:
            continue
        equal = column[1:] == column[:-1]
        if name in FLOATS:
            equal |= np.isnan(column[1:]) & np.isnan(column[:-1])
        same[1:] &= equal.all(axis=tuple(range(1, column.ndim)))
        if name in _TELLING:
            telling |= present(column)
    if timed:
        telling[1:] |= np.diff(columns.time) == 0
    return same & telling


def _check_times_differ(
    columns: Columns, inverse: Integers, tracks: Sequence[str], frozen: NDArray[np.bool_]
) -> None:
    twice = np.zeros(len(columns), bool)
    twice[1:] = (np.diff(columns.time) == 0) & (np.diff(inverse) == 0) & ~frozen[1:]
    if twice.any():
        k = int(np.argmax(twice))
        raise ValueError(
            f"track {tracks[inverse[k]]!r} has two different updates at time "
            f"{float(columns.time[k])!r}: rows {columns.row[k - 1]} and {columns.row[k]}"
        )
