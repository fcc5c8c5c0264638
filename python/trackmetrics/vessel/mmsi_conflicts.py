"""Which reports of one identity can be of one vessel: those it can have sailed between.

Two vessels that send under one MMSI, a jump and a bit fault look alike in one report: it lies where
the vessel cannot be. What comes after tells them apart. Reports are therefore put into chains, each
of reports within reach of the one before.
"""

from dataclasses import dataclass

import numpy as np

from trackmetrics.vessel.settings import Floats, metres_between

KNOT = 1852.0 / 3600.0
ESTABLISHED = 3
"""Reports from which on a chain is a vessel and not a slip."""


@dataclass
class Chain:
    """The end of a chain."""

    time: float
    lat: float
    lon: float
    slack: float
    """Metres by which a position may be wrong."""
    reports: int
    key: int
    """What its owner calls it."""

    def speed(
        self, time: float, lat: float, lon: float, slack: float, resolution: float = 0.0
    ) -> float:
        """Knots that a vessel must make to be there then, beyond what the sensors explain."""
        way = float(metres_between(self.lat, self.lon, lat, lon)) - self.slack - slack
        if way <= 0:
            return 0.0
        return way / max(abs(time - self.time) + resolution, 1e-9) / KNOT

    def extend(self, time: float, lat: float, lon: float, slack: float) -> None:
        """Moves the end to a new report."""
        self.time, self.lat, self.lon, self.slack = time, lat, lon, slack
        self.reports += 1


def choose(
    chains: list[Chain],
    time: float,
    lat: float,
    lon: float,
    slack: float,
    max_speed: float,
    resolution: float = 0.0,
) -> Chain | None:
    """The chain that a report continues: established rather than new, then the slowest."""
    reachable = [
        (chain.reports < ESTABLISHED, speed, k)
        for k, chain in enumerate(chains)
        if (speed := chain.speed(time, lat, lon, slack, resolution)) <= max_speed
    ]
    return chains[min(reachable)[2]] if reachable else None


def steps_too_fast(
    time: Floats, lat: Floats, lon: Floats, slack: Floats, *, max_speed: float
) -> bool:
    """Whether any step of a track is faster than a vessel can be: most have none."""
    way = metres_between(lat[:-1], lon[:-1], lat[1:], lon[1:]) - slack[:-1] - slack[1:]
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
