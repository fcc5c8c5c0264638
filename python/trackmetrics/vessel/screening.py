"""Which reports of a recording can be used, and why the others cannot.

Each row that is rejected has one reason (:attr:`Recording.rejected`):

| reason | the row |
| --- | --- |
| base station | is of a base station |
| aid to navigation | is of a buoy, a lighthouse or another aid to navigation |
| no report | is a message without a position, such as the name of a ship |
| unreadable | has a time, position, speed or course that is no number, or no time at all |
| no identity | has no MMSI |
| no position | has latitude 91 or longitude 181 ("not available"), none, or one out of range |
| duplicate | is the same, in every column, as an earlier one |
| bit fault | lies where no vessel can be, and one flipped bit of its position explains it |
| jump | lies where the vessel cannot be at 60 kt, without such a bit |
| repeated position | has the position of the report before, while it makes more than 3 kt |

A vessel that goes on reporting from where it jumped to is another vessel under the same MMSI: its
reports are kept under the name ``MMSI#2``. Time stamps are cut to their resolution, so that the
time between two reports may be longer than their difference by as much: speeds are judged with it.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _deprecated
from trackmetrics._progress import with_progress
from trackmetrics._tables.errors import value
from trackmetrics.vessel.ais_columns import Table, from_rows
from trackmetrics.vessel.mmsi_conflicts import (
    MIN_VESSEL_REPORTS,
    VesselSegment,
    assign_segment,
    speeds,
)
from trackmetrics.vessel.reports import NO_COURSE, NO_SPEED, Reports
from trackmetrics.vessel.settings import Floats

Integers = NDArray[np.int64]

MAX_SPEED = 60.0
"""Knots that no vessel makes."""
MIN_SPEED_UNDER_WAY = 3.0
"""Knots above which a vessel does not stay in one place."""
MAX_ROUNDING = 1e-6
"""Seconds by which a time may differ from a multiple of its resolution."""
AIS_UNIT = 600_000.0
"""Position units of AIS in a degree: 1/10 000 minute (ITU-R M.1371-5, table 48)."""


@dataclass(frozen=True)
class RejectedRow:
    """A row of a recording that is not used."""

    row: int
    """Its number, from 0, without the heading."""
    reason: str
    """Why: see the module's table."""
    vessel: str | None
    """Its identity, where it has one."""
    detail: str
    """What is wrong with it, with numbers."""


@dataclass(frozen=True)
class Recording:
    """The usable reports of a recording, and what was rejected."""

    reports: Reports
    """In the order of time."""
    rejected: tuple[RejectedRow, ...]
    """In the order of rows."""
    rows: int
    """How many rows were read."""
    out_of_order: int
    """How many rows had an earlier time than a row before them; they were sorted in."""
    without_course: int
    """How many usable reports have no course: none, below 0, or 360 and above."""
    without_speed: int
    """How many usable reports have no speed: none, below 0, or 102.3 kt and above."""
    time_resolution: float
    """Resolution of the time stamps, in seconds: 1 where all are whole seconds."""
    duplicate_mmsi: tuple[str, ...]
    """Identities under which more than one vessel reports."""

    set_aside = _deprecated.attribute("rejected")
    shared = _deprecated.attribute("duplicate_mmsi")

    @property
    def counts(self) -> dict[str, int]:
        """How many rows were rejected for each reason."""
        return dict(Counter(row.reason for row in self.rejected))

    def __repr__(self) -> str:
        """What was used and what was not."""
        rejected = ", ".join(f"{count} {reason}" for reason, count in self.counts.items()) or "none"
        return f"Recording({self.reports!r}, {self.rows} rows, rejected: {rejected})"


def screen_rows(
    rows: Sequence[Mapping[str, Any]], max_speed: float = MAX_SPEED, *, progress: bool = False
) -> Recording:
    """The usable reports among rows of text or numbers; see :func:`read_ais`.

    >>> row = {"time": 0, "vessel": "1", "lat": 50, "lon": 1, "sog": 9.0, "cog": 360.0}
    >>> screen_rows([row, row])
    Recording(Reports(1 reports, 1 identities), 2 rows, rejected: 1 duplicate)
    """
    if not isinstance(rows, Sequence) or isinstance(rows, str):
        raise TypeError(f"rows must be a sequence of mappings, got {type(rows).__name__}")
    return screen_table(from_rows(rows), max_speed, progress=progress)


def screen_table(
    table: Table, max_speed: float = MAX_SPEED, *, progress: bool = False
) -> Recording:
    """The usable reports of a table."""
    screening = _Screening(table, max_speed)
    screening.reject_unusable()
    screening.reject_duplicates()
    order = screening.in_time()
    duplicate_mmsi = screening.reject_impossible(order, progress)
    kept = order[~screening.is_rejected[order]]
    if not len(kept):
        raise ValueError(screening.nothing_usable())
    columns = {name: getattr(table, name)[kept] for name in ("time", "lat", "lon", "sog", "cog")}
    reports = Reports.from_columns(vessel=screening.vessel[kept], **columns)
    sog, cog = columns["sog"], columns["cog"]
    return Recording(
        reports,
        tuple(screening.rejected[k] for k in sorted(screening.rejected)),
        len(table),
        screening.out_of_order,
        int((~((cog >= 0) & (cog < NO_COURSE))).sum()),
        int((~((sog >= 0) & (sog < NO_SPEED))).sum()),
        screening.resolution,
        tuple(duplicate_mmsi),
    )


class _Screening:
    """The rows of a table, and which of them are rejected."""

    def __init__(self, table: Table, max_speed: float) -> None:
        self.table, self.max_speed = table, max_speed
        self.time, self.lat, self.lon = table.time, table.lat, table.lon
        self.vessel = table.vessel.copy()
        self.rejected: dict[int, RejectedRow] = {}
        self.is_rejected = np.zeros(len(table), bool)
        self.out_of_order = 0
        self.resolution = _resolution(table.time)

    def reject(self, k: int, reason: str, detail: str) -> None:
        """Rejects one row."""
        self.rejected[k] = RejectedRow(k, reason, self.vessel[k] or None, detail)
        self.is_rejected[k] = True

    def reject_unusable(self) -> None:
        """Rows that cannot be used by themselves: the first reason counts."""
        table = self.table
        for reason in ("base station", "aid to navigation", "no report"):
            self._reject_all(
                table.sender == reason, reason, lambda k: f"it is of {table.type_of(k)}"
            )
        for name in ("time", "lat", "lon", "sog", "cog"):
            self._reject_all(
                table.unreadable(name),
                "unreadable",
                lambda k, name=name: f"{name} is {value(table.given(name, k))}",
            )
        self._reject_all(np.isnan(table.time), "unreadable", lambda k: "time is missing")
        self._reject_all(self.vessel == "", "no identity", lambda k: "it has no MMSI")
        for name in ("lat", "lon"):
            missing = np.isnan(getattr(table, name))
            self._reject_all(missing, "no position", lambda k, name=name: f"{name} is missing")
        beyond = (np.abs(self.lat) > 90) | (np.abs(self.lon) > 180)
        self._reject_all(
            beyond,
            "no position",
            lambda k: f"latitude {self.lat[k]:g}, longitude {self.lon[k]:g}",
        )

    def _reject_all(self, rows: Any, reason: str, detail: Any) -> None:
        for k in np.flatnonzero(rows & ~self.is_rejected).tolist():
            self.reject(k, reason, detail(k))

    def reject_duplicates(self) -> None:
        """Rows that are the same in every column as an earlier one."""
        rows = np.flatnonzero(~self.is_rejected)
        table = self.table
        columns = [table.vessel_code, table.cog, table.sog, table.lon, table.lat, table.time]
        keys = [column[rows] for column in columns]
        order = np.lexsort(keys)
        same = np.ones(max(len(rows) - 1, 0), bool)
        for key in keys:
            a, b = key[order][:-1], key[order][1:]
            same &= (a == b) | ((a != a) & (b != b))
        group = np.concatenate([[0], np.cumsum(~same)])[: len(rows)]
        first = rows[order[np.searchsorted(group, group)]] if len(rows) else rows
        for place in np.flatnonzero(same) + 1:
            k = int(rows[order[place]])
            self.reject(k, "duplicate", f"the same as row {first[place]}")

    def in_time(self) -> Integers:
        """The usable rows in the order of time."""
        usable = np.flatnonzero(~self.is_rejected)
        time = self.time[usable]
        if len(time):
            self.out_of_order = int((time < np.maximum.accumulate(time)).sum())
        return usable[np.argsort(time, kind="stable")]

    def reject_impossible(self, order: Integers, progress: bool) -> list[str]:
        """Jumps and repeated positions; the identities that are of more than one vessel."""
        by_vessel = order[np.argsort(self.table.vessel_code[order], kind="stable")]
        code = self.table.vessel_code[by_vessel]
        same = code[1:] == code[:-1]
        fast = self._speeds(by_vessel[:-1], by_vessel[1:]) > self.max_speed
        suspects = np.unique(code[1:][same & fast])
        self._reject_repeated(by_vessel, same & ~np.isin(code[1:], suspects))
        own = [by_vessel[slice(*np.searchsorted(code, [c, c + 1]))] for c in suspects]
        own.sort(key=lambda rows: int(np.flatnonzero(order == rows[0])[0]))
        watching: Iterable[Integers] = own
        if progress:
            watching = with_progress(own, "checking jumps", len(own), " vessels")
        return [str(self.table.vessel[rows[0]]) for rows in watching if self._split(rows)]

    def _speeds(self, before: Integers, after: Integers) -> Floats:
        places = [(self.time[k], self.lat[k], self.lon[k]) for k in (before, after)]
        return speeds(*places[0], *places[1], resolution=self.resolution)

    def _split(self, own: Integers) -> bool:
        """Puts the reports of one identity into segments; whether they are of several vessels."""
        segments: list[VesselSegment] = []
        members: list[list[int]] = []
        for k in own.tolist():
            report = (float(self.time[k]), float(self.lat[k]), float(self.lon[k]), 0.0)
            segment = assign_segment(segments, *report, self.max_speed, self.resolution)
            if segment is None:
                segment = VesselSegment(0.0, 0.0, 0.0, 0.0, 0, len(segments))
                segments.append(segment)
                members.append([])
            segment.extend(*report)
            members[segment.key].append(k)
        return self._judge(members)

    def _judge(self, members: list[list[int]]) -> bool:
        """Which segments are vessels; the others are errors of the longest."""
        longest = max(members, key=len)
        vessels = [m for m in members if m is longest or len(m) >= MIN_VESSEL_REPORTS]
        for number, segment in enumerate(vessels[1:], start=2):
            for k in segment:
                self.vessel[k] += f"#{number}"
        for segment in members:
            if any(segment is vessel for vessel in vessels):
                rows = np.array(segment, np.int64)
                self._reject_repeated(rows, np.ones(len(rows) - 1, bool))
                continue
            for k in segment:
                self._reject_error(k, longest)
        return len(vessels) > 1

    def _reject_error(self, k: int, segment: list[int]) -> None:
        near = min(segment, key=lambda j: (abs(self.time[j] - self.time[k]), j))
        end = VesselSegment(
            float(self.time[near]), float(self.lat[near]), float(self.lon[near]), 0.0, 1, 0
        )
        here = (float(self.lat[k]), float(self.lon[k]))
        speed = end.speed(float(self.time[k]), *here, 0.0, self.resolution)
        flip = _flipped_bit(end, float(self.time[k]), here, self.max_speed, self.resolution)
        detail = f"{speed:.0f} kt from row {near}"
        if flip:
            self.reject(k, "bit fault", f"{detail}; one bit makes it {flip}")
        else:
            self.reject(k, "jump", detail)

    def _reject_repeated(self, own: Integers, follows: NDArray[np.bool_]) -> None:
        """Rows that have the position of the row before, where ``follows`` says there is one."""
        before, after = own[:-1], own[1:]
        same = follows & (self.lat[after] == self.lat[before])
        same &= (self.lon[after] == self.lon[before]) & (
            self.table.sog[after] > MIN_SPEED_UNDER_WAY
        )
        for place in np.flatnonzero(same):
            k, first = int(after[place]), int(before[place])
            since = self.time[k] - self.time[first]
            detail = f"at {self.table.sog[k]:g} kt where it was {since:.1f} s before"
            self.reject(k, "repeated position", detail)

    def nothing_usable(self) -> str:
        """Counts by reason, and one row with its reason."""
        text = f"no usable report among {len(self.table)} rows"
        if not self.rejected:
            return text
        counts = Counter(row.reason for row in self.rejected.values())
        listed = ", ".join(f"{count} {reason}" for reason, count in counts.most_common())
        first = self.rejected[min(self.rejected)]
        row = ", ".join(
            f"{name}={value(self.table.given(name, first.row), 24)}"
            for name in ("time", "vessel", "lat", "lon")
        )
        return f"{text}: {listed}. Row {first.row} ({row}): {first.detail}"


def _resolution(time: Floats) -> float:
    """The coarsest of 1 s, 0.1 s, 0.01 s and 1 ms of which all times are multiples; else 0."""
    finite = time[np.isfinite(time)]
    for parts in (1.0, 10.0, 100.0, 1000.0):
        scaled = finite * parts
        if (np.abs(scaled - np.round(scaled)) <= MAX_ROUNDING * parts).all():
            return 1.0 / parts
    return 0.0


def _flipped_bit(
    end: VesselSegment, time: float, here: tuple[float, float], max_speed: float, resolution: float
) -> str | None:
    """The position that one flipped bit away from ``here`` is within reach."""
    for name, axis in (("longitude", 1), ("latitude", 0)):
        # From 0.007 deg on, so that a small error is not called a fault of the radio.
        for bit in range(12, 28):
            for sign in (1.0, -1.0):
                there = list(here)
                there[axis] += sign * 2.0**bit / AIS_UNIT
                speed = end.speed(time, there[0], there[1], 0.0, resolution)
                if abs(there[0]) <= 90 and speed <= max_speed:
                    return f"{name} {there[axis]:.5f}"
    return None
