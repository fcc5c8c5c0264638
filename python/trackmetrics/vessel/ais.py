"""AIS recordings, as CSV with any column names or as NMEA; bad rows are set aside, and listed.

What is set aside, and why (:attr:`Recording.set_aside`):

| reason | the row |
| --- | --- |
| unreadable | has a time, position, speed or course that is no number, or no time at all |
| no identity | has no MMSI |
| no position | has latitude 91 or longitude 181 ("not available"), or one out of range |
| duplicate | is the same, in every column, as an earlier one |
| bit fault | lies where no vessel can be, and one flipped bit of its position explains it |
| jump | lies where the vessel cannot be at 60 kt, without such a bit |
| repeated position | has the position of the report before, while it makes more than 3 kt |

A vessel that goes on reporting from where it jumped to is another vessel under the same MMSI: its
reports are kept under the name ``MMSI#2``.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._progress import lines, watched
from trackmetrics.vessel.mmsi_conflicts import ESTABLISHED, Chain, choose, steps_too_fast
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import Floats

COLUMNS = ("time", "vessel", "lat", "lon", "sog", "cog")
"""What a report may have; time, vessel, lat and lon it must have."""

NAMES = {
    "time": ("time", "timestamp", "basedatetime", "datetime", "date_time", "t"),
    "vessel": ("mmsi", "vessel", "id", "userid"),
    "lat": ("latitude_degrees", "latitude", "lat", "y"),
    "lon": ("longitude_degrees", "longitude", "lon", "long", "x"),
    "sog": ("sog_knots", "sog", "speed_over_ground", "speed"),
    "cog": ("cog_degrees", "cog", "course_over_ground", "course"),
}
"""Headings that are known for each, without regard to case."""

MAX_SPEED = 60.0
"""Knots that no vessel makes."""
MOVING = 3.0
"""Knots above which a vessel does not stay in one place."""
AIS_UNIT = 600_000.0
"""Position units of AIS in a degree: 1/10 000 minute (ITU-R M.1371-5, table 48)."""


@dataclass(frozen=True)
class SetAside:
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
    """The usable reports of a recording, and what was set aside."""

    reports: Reports
    """In the order of time."""
    set_aside: tuple[SetAside, ...]
    """In the order of rows."""
    rows: int
    """How many rows were read."""
    out_of_order: int
    """How many rows had an earlier time than a row before them; they were sorted in."""
    without_course: int
    """How many usable reports say "course not available"."""
    shared: tuple[str, ...]
    """Identities under which more than one vessel reports."""

    @property
    def counts(self) -> dict[str, int]:
        """How many rows were set aside for each reason."""
        return dict(Counter(row.reason for row in self.set_aside))

    def __repr__(self) -> str:
        """What was used and what was not."""
        aside = ", ".join(f"{count} {reason}" for reason, count in self.counts.items()) or "none"
        return f"Recording({self.reports!r}, {self.rows} rows, set aside: {aside})"


def read_ais(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    max_speed: float = MAX_SPEED,
    *,
    progress: bool = False,
) -> Recording:
    """Read a recording of AIS reports.

    Parameters
    ----------
    path : path
        A CSV file with a heading; or NMEA sentences in a file named ``.nmea``, ``.nm4``, ``.aivdm``
        or ``.txt`` (needs the extra ``ais``), each with its time before it (``\\c:UNIX*hh\\!AIVDM``
        or ``UNIX,!AIVDM`` or ``UNIX !AIVDM``).
    columns : mapping, optional
        The heading of each of ``time, vessel, lat, lon, sog, cog`` where it is none of the usual
        ones. Times are seconds, or dates as ISO 8601 says (UTC where no zone is given).
    max_speed : float
        Knots that no vessel makes.
    progress : bool
        Whether a bar on standard error shows how far it is, where it takes longer than a second
        (needs the extra ``progress``).

    Returns
    -------
    Recording
        The usable reports, and each row that was set aside with its reason.

    Raises
    ------
    ValueError
        If a column is missing, or no row is usable.
    """
    path = Path(path)
    if path.suffix.lower() in (".nmea", ".nm4", ".aivdm", ".txt"):
        from trackmetrics.vessel.nmea import read_sentences

        return screen(read_sentences(path), max_speed, progress=progress)
    rows = _read_csv(path, columns or {}, progress)
    return screen(rows, max_speed, progress=progress)


def _read_csv(
    path: Path, mapping: Mapping[str, str], progress: bool = False
) -> list[dict[str, Any]]:
    import csv

    unknown = [name for name in mapping if name not in COLUMNS]
    if unknown:
        raise ValueError(f"columns: no column {unknown[0]!r}; a report has {', '.join(COLUMNS)}")
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(lines(file, "reading") if progress else file)
        heading = next(reader, [])
        places = _places(heading, mapping)
        return [
            {name: row[k] if k < len(row) else "" for name, k in places.items()}
            for row in reader
            if row
        ]


def _places(heading: Sequence[str], mapping: Mapping[str, str]) -> dict[str, int]:
    places = {}
    plain = [name.strip().lower() for name in heading]
    for name in COLUMNS:
        wanted = [mapping[name].lower()] if name in mapping else list(NAMES[name])
        found = [plain.index(w) for w in wanted if w in plain]
        if found:
            places[name] = found[0]
        elif name in mapping or name not in ("sog", "cog"):
            raise ValueError(
                f"no column for {name!r}: expected {' or '.join(wanted)}, "
                f"the file has {', '.join(heading)}"
            )
    return places


# ------------------------------------------------------------------ screening


def screen(
    rows: Sequence[Mapping[str, Any]], max_speed: float = MAX_SPEED, *, progress: bool = False
) -> Recording:
    """The usable reports among rows of text or numbers; see :func:`read_ais`.

    >>> row = {"time": 0, "vessel": "1", "lat": 50, "lon": 1, "sog": 9.0, "cog": 360.0}
    >>> screen([row, row])
    Recording(Reports(1 reports, 1 identities), 2 rows, set aside: 1 duplicate)
    """
    dated, checked = (
        watched(rows, what, len(rows), " rows") if progress else rows
        for what in ("reading dates", "checking")
    )
    table = _Table(rows, dated)
    table.set_aside_unusable(checked)
    order = table.in_time()
    by_vessel: dict[str, list[int]] = {}
    for k in order:
        by_vessel.setdefault(table.vessel[k], []).append(k)
    shared = [v for v, own in by_vessel.items() if table.split(own, max_speed)]
    kept = [k for k in order if k not in table.aside]
    if not kept:
        raise ValueError(f"no usable report among {len(rows)} rows")
    columns = {name: getattr(table, name)[kept] for name in ("time", "lat", "lon", "sog", "cog")}
    reports = Reports.from_columns(vessel=[table.vessel[k] for k in kept], **columns)
    return Recording(
        reports,
        tuple(table.aside[k] for k in sorted(table.aside)),
        len(rows),
        table.out_of_order,
        int((columns["cog"] >= 360.0).sum()),
        tuple(shared),
    )


class _Table:
    """The rows as columns, and which of them are set aside."""

    def __init__(
        self, rows: Sequence[Mapping[str, Any]], dated: Iterable[Mapping[str, Any]]
    ) -> None:
        self.rows = rows
        self.aside: dict[int, SetAside] = {}
        self.vessel = [str(row.get("vessel") or "").strip() for row in rows]
        self.time = np.array([_seconds(row.get("time")) for row in dated], np.float64)
        self.lat, self.lon, self.sog, self.cog = (
            np.array([_number(row.get(name, "")) for row in rows], np.float64)
            for name in ("lat", "lon", "sog", "cog")
        )
        self.out_of_order = 0

    def put_aside(self, k: int, reason: str, detail: str) -> None:
        self.aside[k] = SetAside(k, reason, self.vessel[k] or None, detail)

    def set_aside_unusable(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Rows that cannot be used by themselves, and repetitions of whole rows."""
        seen: dict[tuple[Any, ...], int] = {}
        for k, row in enumerate(rows):
            reason = self._unusable(k, row)
            if reason:
                self.put_aside(k, *reason)
                continue
            first = seen.setdefault(tuple(row.values()), k)
            if first != k:
                self.put_aside(k, "duplicate", f"the same as row {first}")

    def _unusable(self, k: int, row: Mapping[str, Any]) -> tuple[str, str] | None:
        for name in ("time", "lat", "lon", "sog", "cog"):
            empty = name in ("sog", "cog") and row.get(name) in ("", None)
            if not (empty or np.isfinite(getattr(self, name)[k])):
                return "unreadable", f"{name} is {row.get(name)!r}"
        if not self.vessel[k]:
            return "no identity", "it has no MMSI"
        if abs(self.lat[k]) > 90 or abs(self.lon[k]) > 180:
            return "no position", f"latitude {self.lat[k]:g}, longitude {self.lon[k]:g}"
        return None

    def in_time(self) -> list[int]:
        """The usable rows in the order of time."""
        usable = np.array([k for k in range(len(self.rows)) if k not in self.aside], np.int64)
        time = self.time[usable]
        if len(time):
            self.out_of_order = int((time < np.maximum.accumulate(time)).sum())
        return [int(k) for k in usable[np.argsort(time, kind="stable")]]

    def split(self, own: list[int], max_speed: float) -> bool:
        """Sets aside jumps and repeated positions of one vessel; whether it is more than one."""
        time, lat, lon = self.time[own], self.lat[own], self.lon[own]
        if not steps_too_fast(time, lat, lon, np.zeros(len(own)), max_speed=max_speed):
            self._set_aside_repeated(own)
            return False
        chains: list[Chain] = []
        members: list[list[int]] = []
        for k in own:
            report = (float(self.time[k]), float(self.lat[k]), float(self.lon[k]), 0.0)
            chain = choose(chains, *report, max_speed)
            if chain is None:
                chain = Chain(0.0, 0.0, 0.0, 0.0, 0, len(chains))
                chains.append(chain)
                members.append([])
            chain.extend(*report)
            members[chain.key].append(k)
        return self._judge(own, members, max_speed)

    def _judge(self, own: list[int], members: list[list[int]], max_speed: float) -> bool:
        """Which chains are vessels; the others are slips of the longest."""
        longest = max(members, key=len)
        vessels = [m for m in members if m is longest or len(m) >= ESTABLISHED]
        for number, chain in enumerate(vessels[1:], start=2):
            for k in chain:
                self.vessel[k] += f"#{number}"
        for chain in members:
            if any(chain is vessel for vessel in vessels):
                self._set_aside_repeated(chain)
                continue
            for k in chain:
                self._set_aside_slip(k, longest, max_speed)
        return len(vessels) > 1

    def _set_aside_slip(self, k: int, chain: list[int], max_speed: float) -> None:
        near = min(chain, key=lambda j: (abs(self.time[j] - self.time[k]), j))
        end = Chain(float(self.time[near]), float(self.lat[near]), float(self.lon[near]), 0.0, 1, 0)
        here = (float(self.lat[k]), float(self.lon[k]))
        speed = end.speed(float(self.time[k]), here[0], here[1], 0.0)
        flip = _flipped_bit(end, float(self.time[k]), here, max_speed)
        detail = f"{speed:.0f} kt from row {near}"
        if flip:
            self.put_aside(k, "bit fault", f"{detail}; one bit makes it {flip}")
        else:
            self.put_aside(k, "jump", detail)

    def _set_aside_repeated(self, own: list[int]) -> None:
        for before, k in pairwise(own):
            same = self.lat[k] == self.lat[before] and self.lon[k] == self.lon[before]
            if same and self.sog[k] > MOVING:
                since = self.time[k] - self.time[before]
                detail = f"at {self.sog[k]:g} kt where it was {since:.1f} s before"
                self.put_aside(k, "repeated position", detail)


def _flipped_bit(
    end: Chain, time: float, here: tuple[float, float], max_speed: float
) -> str | None:
    """The position that one flipped bit away from ``here`` is within reach, in words."""
    for name, axis in (("longitude", 1), ("latitude", 0)):
        # From 0.007 deg on, so that a small slip is not called a fault of the radio.
        for bit in range(12, 28):
            for sign in (1.0, -1.0):
                there = list(here)
                there[axis] += sign * 2.0**bit / AIS_UNIT
                if abs(there[0]) <= 90 and end.speed(time, there[0], there[1], 0.0) <= max_speed:
                    return f"{name} {there[axis]:.5f}"
    return None


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return np.nan


def _seconds(value: Any) -> float:
    """Seconds of a number or of a date."""
    number = _number(value)
    if np.isfinite(number) or not isinstance(value, str):
        return number
    from datetime import UTC, datetime

    try:
        date = datetime.fromisoformat(value.strip())
    except ValueError:
        return np.nan
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def decimated(reports: Reports, seconds: float) -> NDArray[np.bool_]:
    """Which reports are used where each vessel reports at most once in so many seconds.

    The others can test the predictions of the filter: see :func:`predictive_nis`.

    >>> reports = Reports.from_columns(time=[0, 30, 60, 90], lat=[0] * 4, lon=[0] * 4,
    ...                                vessel=["a"] * 4)
    >>> decimated(reports, 60).tolist()
    [True, False, True, False]
    """
    if not seconds > 0:
        raise ValueError(f"seconds must be positive, got {seconds!r}")
    last: dict[Any, float] = {}
    used = np.zeros(len(reports), bool)
    times: Floats = reports.time
    for k in np.argsort(times, kind="stable"):
        vessel = reports.vessel[k]
        if times[k] - last.get(vessel, -np.inf) >= seconds:
            last[vessel], used[k] = float(times[k]), True
    return used
