"""Simulated vessels, deterministic by seed; the truth follows the filter's process model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trackmetrics import _backend, _deprecated
from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel.geodesy import KNOT
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import (
    AIS,
    AIS_WITHOUT_COURSE,
    MIN_SPEED_FOR_COURSE,
    OBSERVED,
    POSITION,
    TRUNCATED_AIS,
    Floats,
    Settings,
)
from trackmetrics.vessel.simulation_check import STEP, check_fleet, check_simulation
from trackmetrics.vessel.to_log import write_log
from trackmetrics.vessel.tracker import Tracker


@dataclass(frozen=True)
class Turn:
    """A turn that the process model does not expect."""

    start: float
    """When it begins, in seconds."""
    stop: float
    """When it ends."""
    rate: float
    """Degrees per second, to starboard."""


@dataclass(frozen=True)
class Ship:
    """A vessel to simulate, and how it is seen."""

    name: str
    """Its name."""
    start: tuple[float, float, float, float]
    """Latitude, longitude (deg), speed (kt), course (deg) when the simulation begins."""
    times: tuple[float, ...]
    """When it is seen, in seconds: whole steps of 10 s after the beginning."""
    kinds: tuple[int, ...]
    """By which kind of report, as index into ``REPORT_TYPES``."""
    turns: tuple[Turn, ...] = ()
    """Its manoeuvres."""


@dataclass(frozen=True)
class Simulation:
    """What was true and what was seen."""

    settings: Mapping[str, Settings]
    """What each ship's filter assumes."""
    reports: Mapping[str, Reports]
    """The reports of each ship."""
    truth: Mapping[str, Floats]
    """``(n, 5)``: the true state at each report."""
    path_times: Floats
    """Times of the true paths."""
    paths: Mapping[str, Floats]
    """``(times, 5)``: the true path of each ship."""

    @property
    def ships(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.reports)

    def track(self) -> EstimatorLog:
        """Run every ship's reports through its filter; the log holds the truth too."""
        parts = []
        for ship in self.ships:
            tracker = Tracker(self.settings[ship])
            tracker.add(self.reports[ship], self.truth[ship])
            parts.append(tracker.blocks_and_names())
        return write_log(parts)


@_deprecated.parameters(
    interval="report_interval",
    shares="type_shares",
    outages="outage_rate",
    outage="outage_duration",
    rate="turn_rate",
    spread="start_std",
)
def fleet(
    ships: int = 10,
    *,
    duration: float = 3600.0,
    report_interval: float | tuple[float, float] = (10.0, 60.0),
    type_shares: tuple[float, float, float] = (0.5, 0.2, 0.3),
    outage_rate: float = 0.0,
    outage_duration: float = 1200.0,
    manoeuvres: float = 0.0,
    turn_rate: float = 0.1,
    centre: tuple[float, float] = (50.7, -1.1),
    start_std: float = 20_000.0,
    speed: tuple[float, float] = (5.0, 20.0),
    settings: Settings | None = None,
    seed: int = 0,
) -> Simulation:
    """A fleet whose filter is consistent, up to outages and manoeuvres.

    Parameters
    ----------
    ships : int
        How many.
    duration : float
        Seconds.
    report_interval : float or (float, float)
        Mean seconds between two reports of a ship, or the range from which each draws its own;
        times are whole steps of 10 s.
    type_shares : (float, float, float)
        Share of full AIS, truncated AIS and positions; the first two reports are full AIS.
    outage_rate, outage_duration : float
        Expected number of gaps without reports per ship, and their length in seconds.
    manoeuvres, turn_rate : float
        Expected number of turns per ship, of 5 to 15 minutes, and their rate in deg/s.
    centre, start_std
        Where the fleet is (deg), and the standard deviation of the starts in metres.
    speed : (float, float)
        Range of speeds, knots.
    settings : Settings, optional
        What the filter assumes and what is true.
    seed : int
        The same seed gives the same fleet.

    Examples
    --------
    >>> fleet(3, seed=4).ships
    ('ship 1', 'ship 2', 'ship 3')
    """
    check_fleet(ships, duration, type_shares, centre, seed)
    settings = settings or Settings()
    low, high = (
        report_interval
        if isinstance(report_interval, tuple)
        else (report_interval, report_interval)
    )
    drawn = []
    for k in range(ships):
        rng = np.random.default_rng([seed, 1, k])
        start = _start(rng, centre, start_std, speed)
        times = _times(rng, float(rng.uniform(low, high)), duration)
        times = _without_outages(rng, times, rng.poisson(outage_rate), outage_duration, duration)
        kinds = rng.choice([AIS, TRUNCATED_AIS, POSITION], len(times), p=type_shares)
        kinds[:2] = AIS
        turns = tuple(_turn(rng, duration, turn_rate) for _ in range(rng.poisson(manoeuvres)))
        drawn.append(Ship(f"ship {k + 1}", start, tuple(times), tuple(kinds.tolist()), turns))
    each = {ship.name: settings for ship in drawn}
    return simulate(drawn, settings, each, begin=0.0, end=duration, seed=seed)


def _without_outages(
    rng: np.random.Generator,
    times: Floats,
    outages: int,
    outage_duration: float,
    duration: float,
) -> Floats:
    """Times without those in the gaps."""
    for begin in rng.uniform(0, max(duration - outage_duration, 0), outages):
        times = times[(times <= begin) | (times > begin + outage_duration)]
    return times


def _start(
    rng: np.random.Generator,
    centre: tuple[float, float],
    start_std: float,
    speed: tuple[float, float],
) -> tuple[float, float, float, float]:
    north, east = rng.normal(size=2) * start_std / 111_000.0
    lon = centre[1] + east / max(np.cos(np.radians(centre[0])), 0.01)
    return centre[0] + north, lon, float(rng.uniform(*speed)), float(rng.uniform(0, 360))


def _times(rng: np.random.Generator, report_interval: float, duration: float) -> Floats:
    """Times of reports: gaps of 0.5 to 1.5 intervals, in whole steps."""
    gaps = rng.uniform(0.5, 1.5, int(2 * duration / report_interval) + 2) * report_interval
    times = np.unique(np.round(np.cumsum(gaps) / STEP) * STEP)
    return times[times <= duration]


def _turn(rng: np.random.Generator, duration: float, turn_rate: float) -> Turn:
    length = float(rng.uniform(300, 900))
    start = float(rng.uniform(0, max(duration - length, 0)))
    return Turn(start, start + length, turn_rate * float(rng.choice([-1, 1])))


def simulate(
    ships: Sequence[Ship],
    true: Settings,
    settings: Mapping[str, Settings],
    *,
    begin: float,
    end: float,
    seed: int,
) -> Simulation:
    """Truth from the process model of ``true``, reports with its noise, each ship by its own draws.

    Parameters
    ----------
    ships : sequence of Ship
        Who sails, and when each is seen.
    true : Settings
        Noise of motion and sensors.
    settings : mapping of str to Settings
        What each ship's filter assumes.
    begin, end : float
        Seconds.
    seed : int
        The same seed gives the same run; a ship's draws do not depend on the others.

    Raises
    ------
    ValueError, TypeError
        Where a number is not finite or out of its range, times do not rise or are outside the
        simulation, or a ship has no settings; the message names the field.
    """
    check_simulation(ships, settings, begin, end, seed)
    generators = [np.random.default_rng([seed, 0, k]) for k in range(len(ships))]
    steps = round((end - begin) / STEP)
    times: Floats = begin + STEP * np.arange(steps + 1, dtype=np.float64)
    paths = _sail(ships, true, times, [rng.normal(size=(steps, 3)) for rng in generators])
    truth, reports = {}, {}
    for ship, path, rng in zip(ships, paths.swapaxes(0, 1), generators, strict=True):
        at = np.round((np.array(ship.times) - begin) / STEP).astype(int)
        truth[ship.name] = path[at]
        reports[ship.name] = _report(ship, path[at], true, rng)
    return Simulation(
        dict(settings),
        reports,
        truth,
        times,
        {ship.name: paths[:, k] for k, ship in enumerate(ships)},
    )


def _sail(ships: Sequence[Ship], true: Settings, times: Floats, draws: list[Floats]) -> Floats:
    """``(times, ships, 5)``: all ships step by step together."""
    x = np.array([[*ship.start, 0.0] for ship in ships])
    kicks = np.stack(draws, axis=1) * np.sqrt(STEP)
    kicks *= np.sqrt([true.acceleration_density, true.turn_density, true.course_density])
    kicks[..., 0] /= KNOT
    extra = np.zeros((len(times), len(ships)))
    for k, ship in enumerate(ships):
        for turn in ship.turns:
            extra[(times >= turn.start) & (times < turn.stop), k] += turn.rate
    motion, step = (0.0, 0.0, 0.0, true.turn_rate_decay), np.full(len(ships), STEP)
    paths = [x]
    for i in range(len(times) - 1):
        turned = x.copy()
        turned[:, 4] += extra[i]
        after = _backend.kernels.vessel_advance(turned, step, motion)
        after[:, 4] = x[:, 4] * np.exp(-STEP / true.turn_rate_decay)
        after[:, [2, 4, 3]] += kicks[i]
        after[:, 3] %= 360.0
        paths.append(x := after)
    return np.stack(paths)


def _report(ship: Ship, truth: Floats, true: Settings, rng: np.random.Generator) -> Reports:
    """What the sensors make of the truth; a course below 1 kt is not used."""
    kind = np.array(ship.kinds, np.int64)
    sigma = true.sigmas[kind]
    draws = rng.normal(size=(len(kind), 4))
    z = truth[:, :4].copy()
    # Metres to degrees on the local plane; the filter's own degrees differ by less than 1e-5.
    metres = _metres_per_degree(truth[:, 0])
    z[:, :2] += draws[:, :2] * sigma[:, :1] / metres
    z[:, 2] = np.maximum(z[:, 2] + draws[:, 2] * sigma[:, 1], 0.0)
    z[:, 3] = (z[:, 3] + draws[:, 3] * sigma[:, 2]) % 360.0
    kind[(kind == AIS) & (z[:, 2] < MIN_SPEED_FOR_COURSE)] = AIS_WITHOUT_COURSE
    z[np.arange(4) >= OBSERVED[kind][:, None]] = np.nan
    names = np.full(len(kind), ship.name, object)
    return Reports(np.array(ship.times, np.float64), names, kind, z)


def _metres_per_degree(latitude: Floats) -> Floats:
    """``(n, 2)``: metres in a degree of latitude and of longitude on WGS-84."""
    phi = np.radians(latitude)
    e2 = 0.0066943799901413165
    w = 1 - e2 * np.sin(phi) ** 2
    north, east = 6378137.0 * (1 - e2) / w**1.5, 6378137.0 / np.sqrt(w) * np.cos(phi)
    return np.radians(np.stack([north, east], axis=1))
