"""Simulated vessels, deterministic by seed: the three ships of a published run, and other fleets.

The three ships carry the support pattern of a published run of a vessel estimator ("Multi Object
Tracking framework diagnostics": the times and types of its 63 updates, read from the exported
plots): which sensor saw which ship, and when. Truth is drawn from the filter's own process model in
steps of 10 s; the third ship turns while there is no report.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackmetrics import _backend, _deprecated
from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel.mmsi_conflicts import KNOT
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import OBSERVED, SLOW, Floats, Noise, Settings
from trackmetrics.vessel.simulation_check import check_fleet, check_simulation
from trackmetrics.vessel.to_log import write_log
from trackmetrics.vessel.tracker import Tracker

STEP = 10.0
"""Seconds between two kicks of the true motion."""


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
    """By which kind of report, as index into ``KINDS``."""
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
            parts.append(tracker.part())
        return write_log(parts)


# ------------------------------------------------------------------ the three ships

_AIS, _NO_COURSE, _TRUNCATED, _POSITION = range(4)
_LETTERS = {"A": _AIS, "T": _TRUNCATED, "P": _POSITION}


def _seen(minutes: str, letters: str) -> dict[str, Any]:
    times = tuple(60.0 * int(minute) for minute in minutes.split())
    return {"times": times, "kinds": tuple(_LETTERS[letter] for letter in letters)}


THREE_SHIPS = (
    Ship(
        "MV Iron Falcon2",
        (72.04, 30.0, 10.0, 45.0),
        **_seen(
            "0 5 13 25 28 33 36 53 59 65 73 78 79 88 94 96 103 109 111 117 119 125 129 133 141"
            " 161 165 169",
            "TAAAAAAPPAPPPPPPAPPAAPPAAAAA",
        ),
    ),
    Ship(
        "SS Iron Aurora1",
        (74.53, 32.0, 10.0, 45.0),
        **_seen(
            "5 20 29 37 50 54 59 64 66 74 83 89 98 104 108 113 117 120 125 129 137 145 149 169",
            "TAAPPAPPPPPPPPPAAAPAPAAA",
        ),
    ),
    Ship(
        "SS Northern Star0",
        (73.60, 35.0, 25.0, 180.0),
        **_seen("5 36 50 54 64 69 72 78 81 113 120", "AAPPPPPPPAA"),
        turns=(Turn(5100.0, 6900.0, 0.10),),
    ),
)
"""The ships of the published run: minutes and kinds of its 63 updates (A AIS, T truncated AIS,
P position), starts near its own. Northern Star0's turn falls into the silence of the run from 4860
to 6780 s; the published run has no such turn, but breaks at the same update."""

ACCELERATION, TURN = 1e-4, 1e-7

CONSISTENT = Settings(
    ais=Noise(350.0, 1.25, 2.0),
    truncated_ais=Noise(150.0),
    position=Noise(350.0),
    acceleration_density=ACCELERATION,
    turn_density=TURN,
)
"""Sensor noise as it is: what the published run's reports show against its truth."""
PUBLISHED = replace(CONSISTENT, ais=Noise(600.0, 2.0, 3.0), position=Noise(600.0))
"""Sensor noise as the published run's filter claims it."""


def three_ships(seed: int = 0, noise: str = "consistent") -> Simulation:
    """The three ships of the published run.

    Parameters
    ----------
    seed : int
        The same seed gives the same run.
    noise : str
        ``"consistent"``: the filter assumes the noise that there is. ``"published"``: it
        assumes what the published filter did, and expects twice the true deviations of acceleration
        and turn.

    Returns
    -------
    Simulation
        Falcon2 starts from placeholders (speed 0, course 360, taken for known), as in the published
        run.

    Examples
    --------
    >>> log = three_ships(seed=1).track()
    >>> len(log), float(log["SS Northern Star0"].time[-1])
    (63, 7200.0)
    """
    if noise in _deprecated.RENAMED_NOISE:
        renamed = _deprecated.RENAMED_NOISE[noise]
        _deprecated.warn(f"three_ships(noise={noise!r})", f"three_ships(noise={renamed!r})")
        noise = renamed
    if noise not in ("consistent", "published"):
        raise ValueError(f"noise must be 'consistent' or 'published', got {noise!r}")
    share = 1.0 if noise == "consistent" else 0.25
    settings = CONSISTENT if noise == "consistent" else PUBLISHED
    falcon = replace(settings, placeholders=True, tentative=1)
    true = replace(
        CONSISTENT,
        acceleration_density=ACCELERATION * share,
        turn_density=TURN * share,
    )
    each = {ship.name: settings for ship in THREE_SHIPS} | {THREE_SHIPS[0].name: falcon}
    return simulate(THREE_SHIPS, true, each, begin=-420.0, end=10_320.0, seed=seed)


# ------------------------------------------------------------------ other fleets


def fleet(
    ships: int = 10,
    *,
    duration: float = 3600.0,
    interval: float | tuple[float, float] = (10.0, 60.0),
    shares: tuple[float, float, float] = (0.5, 0.2, 0.3),
    outages: float = 0.0,
    outage: float = 1200.0,
    manoeuvres: float = 0.0,
    rate: float = 0.1,
    centre: tuple[float, float] = (50.7, -1.1),
    spread: float = 20_000.0,
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
    interval : float or (float, float)
        Mean seconds between two reports of a ship, or the range from which each draws its own;
        times are whole steps of 10 s.
    shares : (float, float, float)
        Share of full AIS, truncated AIS and positions; the first two reports are full AIS.
    outages, outage : float
        Expected number of silences a ship, and their length in seconds.
    manoeuvres, rate : float
        Expected number of turns a ship of 5 to 15 minutes, and their rate in deg/s (either side).
    centre, spread
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
    check_fleet(ships, duration, shares, centre, seed)
    settings = settings or Settings()
    low, high = interval if isinstance(interval, tuple) else (interval, interval)
    drawn = []
    for k in range(ships):
        rng = np.random.default_rng([seed, 1, k])
        start = _start(rng, centre, spread, speed)
        times = _times(rng, float(rng.uniform(low, high)), duration)
        times = _silenced(rng, times, rng.poisson(outages), outage, duration)
        kinds = rng.choice([_AIS, _TRUNCATED, _POSITION], len(times), p=shares)
        kinds[:2] = _AIS
        turns = tuple(_turn(rng, duration, rate) for _ in range(rng.poisson(manoeuvres)))
        drawn.append(Ship(f"ship {k + 1}", start, tuple(times), tuple(kinds.tolist()), turns))
    each = {ship.name: settings for ship in drawn}
    return simulate(drawn, settings, each, begin=0.0, end=duration, seed=seed)


def _silenced(
    rng: np.random.Generator, times: Floats, outages: int, outage: float, duration: float
) -> Floats:
    """Times without those of the silences."""
    for begin in rng.uniform(0, max(duration - outage, 0), outages):
        times = times[(times <= begin) | (times > begin + outage)]
    return times


def _start(
    rng: np.random.Generator,
    centre: tuple[float, float],
    spread: float,
    speed: tuple[float, float],
) -> tuple[float, float, float, float]:
    north, east = rng.normal(size=2) * spread / 111_000.0
    lon = centre[1] + east / max(np.cos(np.radians(centre[0])), 0.01)
    return centre[0] + north, lon, float(rng.uniform(*speed)), float(rng.uniform(0, 360))


def _times(rng: np.random.Generator, interval: float, duration: float) -> Floats:
    """Times of reports: gaps between half and one and a half of the interval, in whole steps."""
    gaps = rng.uniform(0.5, 1.5, int(2 * duration / interval) + 2) * interval
    times = np.unique(np.round(np.cumsum(gaps) / STEP) * STEP)
    return times[times <= duration]


def _turn(rng: np.random.Generator, duration: float, rate: float) -> Turn:
    length = float(rng.uniform(300, 900))
    start = float(rng.uniform(0, max(duration - length, 0)))
    return Turn(start, start + length, rate * float(rng.choice([-1, 1])))


# ------------------------------------------------------------------ the simulation


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
    kind[(kind == _AIS) & (z[:, 2] < SLOW)] = _NO_COURSE
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
