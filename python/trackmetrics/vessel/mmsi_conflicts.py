"""Which reports of one identity can be of one vessel: those it can have sailed between.

Two vessels that send under one MMSI, a jump and a bit fault look alike in one report: it lies where
the vessel cannot be. Only later reports distinguish them. Reports are therefore divided into
segments, each of reports within reach of the one before.
"""

from dataclasses import dataclass

import numpy as np

from trackmetrics.vessel.geodesy import KNOT, metres_between
from trackmetrics.vessel.settings import Floats

MIN_VESSEL_REPORTS = 3
"""Fewest reports of a segment that counts as a vessel; those of a shorter one are errors."""


@dataclass
class VesselSegment:
    """The last report of a segment, and how many reports the segment has."""

    time: float
    lat: float
    lon: float
    position_tolerance: float
    """Metres by which a position may be wrong."""
    reports: int
    key: int
    """Number of the segment, chosen by the caller."""

    def speed(
        self,
        time: float,
        lat: float,
        lon: float,
        position_tolerance: float,
        resolution: float = 0.0,
    ) -> float:
        """Knots that a vessel must make to be there then, beyond what the sensors explain."""
        way = (
            float(metres_between(self.lat, self.lon, lat, lon))
            - self.position_tolerance
            - position_tolerance
        )
        if way <= 0:
            return 0.0
        return way / max(abs(time - self.time) + resolution, 1e-9) / KNOT

    def extend(self, time: float, lat: float, lon: float, position_tolerance: float) -> None:
        """Moves the end to a new report."""
        self.time, self.lat, self.lon, self.position_tolerance = time, lat, lon, position_tolerance
        self.reports += 1


def assign_segment(
    segments: list[VesselSegment],
    time: float,
    lat: float,
    lon: float,
    position_tolerance: float,
    max_speed: float,
    resolution: float = 0.0,
) -> VesselSegment | None:
    """The segment that a report continues: one of a vessel first, then the slowest step; None if no
    segment is within reach."""
    reachable = [
        (segment.reports < MIN_VESSEL_REPORTS, speed, k)
        for k, segment in enumerate(segments)
        if (speed := segment.speed(time, lat, lon, position_tolerance, resolution)) <= max_speed
    ]
    return segments[min(reachable)[2]] if reachable else None


def exceeds_speed(
    time: Floats, lat: Floats, lon: Floats, position_tolerance: Floats, *, max_speed: float
) -> bool:
    """Whether any step of a track is faster than a vessel can be: most have none."""
    way = (
        metres_between(lat[:-1], lon[:-1], lat[1:], lon[1:])
        - position_tolerance[:-1]
        - position_tolerance[1:]
    )
    return bool((way > max_speed * KNOT * np.maximum(np.abs(np.diff(time)), 1e-9)).any())


def speeds(
    time0: Floats,
    lat0: Floats,
    lon0: Floats,
    time: Floats,
    lat: Floats,
    lon: Floats,
    *,
    resolution: float,
) -> Floats:
    """Knots from each first place to the second one, for times of this resolution in seconds."""
    way = metres_between(lat0, lon0, lat, lon)
    knots: Floats = way / np.maximum(np.abs(time - time0) + resolution, 1e-9) / KNOT
    return knots
