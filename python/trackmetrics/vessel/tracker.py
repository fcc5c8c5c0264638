"""Many vessels at once: AIS by identity, positions by gate and global nearest neighbour."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _deprecated
from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel.association import associate
from trackmetrics.vessel.mmsi_conflicts import (
    MIN_VESSEL_REPORTS,
    VesselSegment,
    assign_segment,
    exceeds_speed,
)
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import OBSERVED, Floats, Settings
from trackmetrics.vessel.to_log import FilterBatch, Outcome, write_log

Integers = NDArray[np.int64]

MAX_POSITION_DEVIATIONS = 5.0
"""Standard deviations by which a position may lie off, where a vessel's reach is judged."""


@dataclass(frozen=True)
class VesselTrack:
    """A track at one moment."""

    name: str
    """Its name in the log."""
    vessel: str | None
    """The identity that its reports carry; None where none did."""
    status: str
    """``"tentative"``, ``"active"``, ``"coasting"`` or ``"deleted"``."""
    reports: int
    """How many reports it has taken."""
    time: float
    """Time of the last of them."""
    x: Floats
    """State after it: latitude, longitude, speed, course, turn rate."""
    P: Floats
    """Its covariance."""


@dataclass
class _Fleet:
    """The tracks as kernels take them, and who they are."""

    life: Floats = field(default_factory=lambda: np.zeros((0, 7)))
    x: Floats = field(default_factory=lambda: np.zeros((0, 5)))
    p: Floats = field(default_factory=lambda: np.zeros((0, 5, 5)))
    vessel: list[str | None] = field(default_factory=list)

    def grow(self, vessels: Iterable[str | None]) -> Integers:
        """Add tracks, return their indices; doubles the arrays, so that the cost stays linear."""
        first = len(self.vessel)
        self.vessel.extend(vessels)
        if len(self.vessel) > len(self.life):
            added = max(2 * len(self.life), len(self.vessel), 16) - len(self.life)
            self.life = np.concatenate([self.life, np.zeros((added, 7))])
            self.x = np.concatenate([self.x, np.zeros((added, 5))])
            self.p = np.concatenate([self.p, np.zeros((added, 5, 5))])
        return np.arange(first, len(self.vessel))


class Tracker:
    """Tracks vessels from their reports.

    Reports with an identity go to the track of that identity; where one identity reports from
    places that no vessel can sail between, it is taken for two vessels, the second one with ``#2``
    at its name. Positions without identity are given, scan by scan (one time is one scan), to the
    tracks into whose gates they fall, so that the total likelihood is greatest; what is left over
    starts a track of its own. A report older than the last one of its track is late: not used, and
    counted.

    Parameters
    ----------
    settings : Settings
        What the filter assumes.

    Notes
    -----
    A speed may become negative by an update: a vessel that goes astern, or lies still. Latitudes
    beyond 89 deg are outside the model's local plane. The longitude is kept in (-180, 180].

    Examples
    --------
    >>> tracker = Tracker(Settings())
    >>> tracker.add(Reports.from_columns(time=[0, 60, 120], lat=[50.0, 50.005, 50.01],
    ...                                  lon=[1.0, 1.0, 1.0], sog=[18.0] * 3, cog=[0.0] * 3,
    ...                                  vessel=["Tern"] * 3))
    >>> tracker.tracks()[0].status
    'active'
    >>> tracker.log()["Tern"].nis_dof
    array([nan, nan,  4.])
    """

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self._fleet = _Fleet()
        self._segments: dict[str, list[VesselSegment]] = {}
        self._blocks: list[FilterBatch] = []
        self._clock = -np.inf
        self._seen = 0
        self._sigmas = self.settings.sigmas
        # The quantile of a chi-square of two degrees of freedom has a closed form.
        self._gate = float(-2 * np.log1p(-self.settings.gate_probability))

    # ------------------------------------------------------------------ what goes in

    def add(self, reports: Reports, truth: Any = None) -> None:
        """Take reports in, in the order of their times.

        Parameters
        ----------
        reports : Reports
            The next reports. Those of one call are sorted; between calls time goes on.
        truth : array_like, shape (n, 5), optional
            The true state at each report, where it is known: it goes into the log.

        Raises
        ------
        ValueError
            Where a time or a measured value is not finite, or a latitude beyond 90 degrees; no
            report of the call has been used then.
        """
        truths = _truths(truth, len(reports))
        sources = np.arange(self._seen, self._seen + len(reports))
        if len(reports) > 1:
            order = np.argsort(reports.time, kind="stable")
            reports, truths, sources = reports.take(order), truths[order], sources[order]
        _refuse_what_is_not_finite(reports)
        self._seen += len(reports)
        for scan, rows in _scans(reports):
            whole = isinstance(rows, slice)
            part = reports if whole else reports.take(rows)
            take = self._take_positions if scan else self._take_identified
            take(part, truths[rows], sources[rows])
        if len(reports):
            self._clock = max(self._clock, float(reports.time[-1]))

    def _take_identified(self, reports: Reports, truths: Floats, sources: Integers) -> None:
        tracks = self._tracks_of(reports)
        if len(tracks) == 1:
            self._run(tracks, reports, truths, sources)
            return
        order = np.argsort(tracks, kind="stable")
        self._run(tracks[order], reports.take(order), truths[order], sources[order])

    def _take_positions(self, reports: Reports, truths: Floats, sources: Integers) -> None:
        time = float(reports.time[0])
        if time < self._clock:
            self._blocks.append(FilterBatch.late(reports, sources))
            return
        self._clock = time
        tracks = np.full(len(reports), -1, np.int64)
        for position, track in self._associate(reports, time):
            tracks[position] = track
        new = np.flatnonzero(tracks < 0)
        tracks[new] = self._fleet.grow([None] * len(new))
        order = np.argsort(tracks, kind="stable")
        self._run(tracks[order], reports.take(order), truths[order], sources[order])

    def _associate(self, reports: Reports, time: float) -> list[tuple[int, int]]:
        """(row of the scan, track) of the positions that are given to a track."""
        fleet, n = self._fleet, len(self._fleet.vessel)
        age = time - fleet.life[:n, 2]
        live = np.flatnonzero(
            (fleet.life[:n, 0] > 0) & (age >= 0) & (age <= self.settings.delete_after)
        )
        if not len(live):
            return []
        sigmas = self._sigmas[reports.kind, 0]
        z = np.ascontiguousarray(reports.z[:, :2])
        positions, tracks, distances, log_dets = _backend.kernels.vessel_gate(
            fleet.x[live], fleet.p[live], age[live], z, sigmas, self._gate, self.settings.motion
        )
        return associate(positions, live[tracks], distances, log_dets, self._gate)

    def _run(self, tracks: Integers, reports: Reports, truths: Floats, sources: Integers) -> None:
        """Reports, sorted by track, through the filters."""
        fleet = self._fleet
        first = np.flatnonzero(np.concatenate([[True], tracks[1:] != tracks[:-1]]))
        used, starts = tracks[first], np.concatenate([first, [len(tracks)]])
        state, rows = _backend.kernels.vessel_filter(
            fleet.life[used],
            fleet.x[used],
            fleet.p[used],
            starts,
            reports.time,
            np.ascontiguousarray(reports.z),
            OBSERVED[reports.kind],
            self._sigmas[reports.kind],
            self.settings.motion,
            self.settings.rules,
        )
        fleet.life[used], fleet.x[used], fleet.p[used] = state
        self._blocks.append(FilterBatch(tracks, sources, reports, truths, rows))

    # ------------------------------------------------------------------ whose reports

    def _tracks_of(self, reports: Reports) -> Integers:
        """The track of each report by its identity."""
        tracks = np.empty(len(reports), np.int64)
        for vessel, rows in reports.rows_by_vessel().items():
            tracks[rows] = self._tracks_of_vessel(str(vessel), reports, rows)
        return tracks

    def _tracks_of_vessel(self, vessel: str, reports: Reports, rows: Integers) -> Any:
        """One track, as long as the vessel can have sailed from each report to the next."""
        segments = self._segments.setdefault(vessel, [])
        columns = (reports.time[rows], reports.z[rows, 0], reports.z[rows, 1])
        position_tolerance = MAX_POSITION_DEVIATIONS * self._sigmas[reports.kind[rows], 0]
        if len(segments) <= 1 < len(rows):
            if segments:
                end = segments[0]
                before = ([end.time], [end.lat], [end.lon], [end.position_tolerance])
                steps = [
                    np.append(a, b)
                    for a, b in zip(before, (*columns, position_tolerance), strict=True)
                ]
            else:
                steps = [*columns, position_tolerance]
            if not exceeds_speed(steps[0], *steps[1:], max_speed=self.settings.max_speed):
                segment = segments[0] if segments else self._new_segment(vessel, segments)
                segment.extend(*(float(c[-1]) for c in (*columns, position_tolerance)))
                segment.reports += len(rows) - 1
                return segment.key
        return [
            self._continue(vessel, segments, *map(float, report))
            for report in zip(*columns, position_tolerance, strict=True)
        ]

    def _continue(
        self,
        vessel: str,
        segments: list[VesselSegment],
        time: float,
        lat: float,
        lon: float,
        position_tolerance: float,
    ) -> int:
        segment = assign_segment(
            segments, time, lat, lon, position_tolerance, self.settings.max_speed
        )
        if segment is None:
            segment = self._new_segment(vessel, segments)
        segment.extend(time, lat, lon, position_tolerance)
        return segment.key

    def _new_segment(self, vessel: str, segments: list[VesselSegment]) -> VesselSegment:
        key = int(self._fleet.grow([vessel])[0])
        segments.append(VesselSegment(0.0, 0.0, 0.0, 0.0, 0, key))
        return segments[-1]

    # ------------------------------------------------------------------ what comes out

    def tracks(self, at: float | None = None) -> tuple[VesselTrack, ...]:
        """Every track with its status at a time (default: that of the last report)."""
        now = self._clock if at is None else at
        fleet = self._fleet
        names = self._names()
        found = []
        for k, vessel in enumerate(fleet.vessel):
            reports, start, time = fleet.life[k, :3]
            status = self._status(int(reports), now - time)
            name = names[k, int(start)]
            x, p = fleet.x[k].copy(), fleet.p[k].copy()
            found.append(VesselTrack(name, vessel, status, int(reports), float(time), x, p))
        return tuple(found)

    def _status(self, reports: int, age: float) -> str:
        if age > self.settings.delete_after:
            return "deleted"
        if reports <= self.settings.num_tentative:
            return "tentative"
        return "coasting" if age > self.settings.coast_after else "active"

    @property
    def late(self) -> Integers:
        """Which reports, counted from the first ever added, came late and were not used."""
        late = [block.sources[block.outcome == Outcome.LATE] for block in self._blocks]
        return np.sort(np.concatenate([np.empty(0, np.int64), *late]))

    @property
    def duplicate_mmsi(self) -> tuple[str, ...]:
        """Identities under which two or more vessels report."""
        return tuple(
            vessel
            for vessel, segments in self._segments.items()
            if sum(segment.reports >= MIN_VESSEL_REPORTS for segment in segments) > 1
        )

    shared = _deprecated.attribute("duplicate_mmsi")

    def log(self) -> EstimatorLog:
        """One row for each report that was used, track by track.

        Two updates of one track at one time stand one unit in the last place apart.

        Raises
        ------
        ValueError
            If no report was used.
        """
        return write_log([self.blocks_and_names()])

    def blocks_and_names(self) -> tuple[list[FilterBatch], dict[tuple[int, int], str]]:
        """What a log of several trackers needs of this one."""
        return self._blocks, self._names()

    def _names(self) -> dict[tuple[int, int], str]:
        """The name of each track and start: its vessel, with a number from the second on."""
        names: dict[tuple[int, int], str] = {}
        counts: dict[str | None, int] = {}
        for block in self._blocks:
            for key in block.births():
                vessel = self._fleet.vessel[key[0]]
                counts[vessel] = count = counts.get(vessel, 0) + 1
                first = f"unknown {count}" if vessel is None else vessel
                names[key] = first if vessel is None or count == 1 else f"{vessel}#{count}"
        return names


def _truths(truth: Any, n: int) -> Floats:
    if truth is None:
        return np.full((n, 5), np.nan)
    truths = np.asarray(truth, np.float64)
    if truths.shape != (n, 5):
        raise ValueError(f"truth has shape {truths.shape}, expected {(n, 5)}")
    return truths


def _refuse_what_is_not_finite(reports: Reports) -> None:
    """Before anything is used, so that a bad call changes nothing."""
    used = np.arange(4) < OBSERVED[reports.kind][:, None]
    columns = np.column_stack([reports.time, reports.z])
    bad = ~np.isfinite(columns)
    bad[:, 1:] &= used
    if bad.any():
        k, column = np.argwhere(bad)[0]
        name = ("time", "lat", "lon", "sog", "cog")[column]
        raise ValueError(
            f"{name} of the report at time {float(reports.time[k])!r} is not finite: "
            f"{columns[k, column]}"
        )
    beyond = np.abs(reports.z[:, 0]) > 90
    if beyond.any():
        k = int(np.argmax(beyond))
        raise ValueError(
            f"lat of the report at time {float(reports.time[k])!r} is beyond 90 degrees: "
            f"{reports.z[k, 0]}"
        )


def _scans(reports: Reports) -> Iterable[tuple[bool, Any]]:
    """Runs of identified reports, and scans of positions without identity, in time."""
    anonymous = np.array([v is None for v in reports.vessel], bool)
    if not anonymous.any():
        yield False, slice(None)
        return
    rows = np.arange(len(reports))
    new_time = np.diff(reports.time, prepend=np.nan) != 0
    # Of one time, identified reports come first: they know whose they are.
    order = np.lexsort((anonymous, np.cumsum(new_time)))
    changes = np.diff(anonymous[order].astype(int), prepend=-1) != 0
    changes |= anonymous[order] & (np.diff(reports.time[order], prepend=np.nan) != 0)
    for part in np.split(order, np.flatnonzero(changes)[1:]):
        yield bool(anonymous[part[0]]), rows[part]
