"""A ship that reports rarely, and a five-state extended Kalman filter: many runs at once.

Latitude and longitude (degrees), speed (knots), course (degrees from north), turn rate (degrees a
second); full reports of position, speed and course, and reports of position alone, 60 to 600 s
apart in an order that differs from run to run. The filter is not linear, the angles wrap, and the
kinds of measurement mix: what a user's log looks like.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants import as_log
from trackmetrics.logs import EstimatorLog, State

Floats = NDArray[np.float64]

KNOT = 1852 / 3600
RAD = np.pi / 180
STATES = (
    State("lat", "deg"),
    State("lon", "deg", 360.0),
    State("sog", "kt"),
    State("cog", "deg", 360.0),
    State("turn_rate", "deg/s"),
)
KINDS = ("full", "truncated", "position")
SHARES = (0.5, 0.2, 0.3)
POSITION_STD = np.array([10.0, 30.0, 60.0])
SPEED_STD, COURSE_STD = 0.3, 1.5
INTERVALS = (60, 120, 180, 240, 300, 360, 480, 600)
ACCELERATION, TURN = 1e-4, 2e-9
"""Power densities, m^2/s^3 and (deg/s)^2/s."""
TENTATIVE = 2

CASES = (
    "consistent",
    "Q / 10",
    "R / 4",
    "R x 4",
    "course bias",
    "speed bias",
    "position bias",
    "angle wrap bug",
    "late turn",
    "short turn",
    "bad start",
)


def metres(latitude: Floats) -> tuple[Floats, Floats]:
    """Metres per degree north and east."""
    a = latitude * RAD
    north = 111132.954 - 559.822 * np.cos(2 * a) + 1.175 * np.cos(4 * a)
    east = 111412.84 * np.cos(a) - 93.5 * np.cos(3 * a) + 0.118 * np.cos(5 * a)
    return north, east


def move(x: Floats, dt: Floats | float) -> Floats:
    """Constant speed and turn rate on the local plane, in the half-angle form."""
    lat, lon, sog, cog, rate = x.T
    half = rate * RAD * dt / 2
    course, length = cog * RAD + half, sog * KNOT * dt * np.sinc(half / np.pi)
    north, _ = metres(lat)
    to = lat + length * np.cos(course) / north
    _, east = metres((lat + to) / 2)
    lon = lon + length * np.sin(course) / east
    return np.stack([to, lon, sog, (cog + rate * dt) % 360, rate], axis=1)


def jacobian(x: Floats, dt: Floats) -> Floats:
    """Of ``move``, by central differences in steps that suit each state."""
    steps = np.array([1e-4, 1e-4, 1e-3, 1e-3, 1e-6])
    columns = []
    for i, step in enumerate(steps):
        shift = np.zeros(5)
        shift[i] = step
        difference = move(x + shift, dt) - move(x - shift, dt)
        difference[:, 3] = (difference[:, 3] + 180) % 360 - 180
        columns.append(difference / (2 * step))
    return np.stack(columns, axis=2)


def process_noise(x: Floats, dt: Floats, factor: float) -> Floats:
    """The integral of white acceleration and turn acceleration along a straight line."""
    lat, _, sog, cog, rate = x.T
    v, course = sog * KNOT, cog * RAD + rate * RAD * dt / 2
    qa, qw = ACCELERATION * factor, TURN * factor * RAD**2
    M = np.zeros((len(x), 5, 5))
    M[:, 0, 0], M[:, 0, 2], M[:, 2, 2] = qa * dt**3 / 3, qa * dt**2 / 2, qa * dt
    M[:, 1, 1], M[:, 1, 3] = v**2 * qw * dt**5 / 20, v * qw * dt**4 / 8
    M[:, 1, 4], M[:, 3, 3] = v * qw * dt**3 / 6, qw * dt**3 / 3
    M[:, 3, 4], M[:, 4, 4] = qw * dt**2 / 2, qw * dt
    M = np.maximum(M, M.swapaxes(1, 2))
    north, east = metres(lat)
    G = np.zeros((len(x), 5, 5))
    G[:, 0, 0], G[:, 0, 1] = np.cos(course) / north, -np.sin(course) / north
    G[:, 1, 0], G[:, 1, 1] = np.sin(course) / east, np.cos(course) / east
    G[:, 2, 2], G[:, 3, 3], G[:, 4, 4] = 1 / KNOT, 1 / RAD, 1 / RAD
    return G @ M @ G.swapaxes(1, 2)


@dataclass
class Reports:
    """When and what: ``(runs, updates)``."""

    dt: Floats
    kinds: NDArray[np.int64]


def schedule(runs: int, updates: int, rng: np.random.Generator, case: str) -> Reports:
    """Random intervals and kinds; the first two are full reports."""
    dt = rng.choice(INTERVALS, (runs, updates)).astype(float)
    dt[:, 0] = 0.0
    kinds = rng.choice(3, (runs, updates), p=SHARES)
    kinds[:, :2] = 0
    if case == "bad start":
        kinds[:, 0], kinds[:, 1:3] = 1, 0
    return Reports(dt, kinds)


def true_paths(reports: Reports, case: str, rng: np.random.Generator) -> Floats:
    """``(runs, updates, 5)``, in steps of 10 s."""
    runs, updates = reports.dt.shape
    x = np.zeros((runs, 5))
    x[:, :3] = 60.0, 5.0, 12.0
    x[:, 3] = 359.5 if case == "angle wrap bug" else rng.uniform(0, 360, runs)
    times = np.cumsum(reports.dt, axis=1)
    begin = times[:, int(0.7 * updates)]
    rate, end = {"late turn": (0.05, np.inf), "short turn": (0.1, begin + 900)}.get(
        case, (0.0, 0.0)
    )
    path = np.empty((runs, updates, 5))
    path[:, 0] = x
    for k in range(1, updates):
        left, now = reports.dt[:, k].copy(), times[:, k - 1].copy()
        while (left > 0).any():
            on = left > 0
            turning = on & (begin <= now) & (now < end)
            y = x.copy()
            y[:, 4] += rate * turning
            y = move(y, 10.0)
            y[:, 4] = x[:, 4] + rng.normal(size=runs) * np.sqrt(TURN * 10)
            y[:, 2] += rng.normal(size=runs) * np.sqrt(ACCELERATION * 10) / KNOT
            x = np.where(on[:, None], y, x)
            left, now = left - 10, now + 10
        path[:, k] = x
    return path


def noise_std(kinds: NDArray[np.int64], latitude: Floats) -> Floats:
    """``(runs, 4)``: of latitude, longitude, speed, course."""
    north, east = metres(latitude)
    position = POSITION_STD[kinds]
    columns = [position / north, position / east, 0 * north + SPEED_STD, 0 * north + COURSE_STD]
    return np.stack(columns, axis=1)


def measure(path: Floats, reports: Reports, case: str, rng: np.random.Generator) -> Floats:
    """``(runs, updates, 4)``: what is reported, whatever the kind."""
    z = np.empty((*path.shape[:2], 4))
    for k in range(path.shape[1]):
        std = noise_std(reports.kinds[:, k], path[:, k, 0])
        z[:, k] = path[:, k, :4] + rng.normal(size=std.shape) * std
        if case == "position bias":
            z[:, k, 1] += 1.5 * std[:, 1] * (reports.kinds[:, k] == 2)
    z[..., 2] += 2 * SPEED_STD * (case == "speed bias")
    z[..., 3] = (z[..., 3] + 2 * COURSE_STD * (case == "course bias")) % 360
    z[..., 2] = np.maximum(z[..., 2], 0.0)
    return z


def simulate(case: str, updates: int, runs: int, seed: int) -> EstimatorLog:
    """The log of many runs, with truth; ``updates`` of them after the tentative ones."""
    rng = np.random.default_rng([seed, updates, CASES.index(case)])
    total = updates + (1 if case == "bad start" else TENTATIVE)
    reports = schedule(runs, total, rng, case)
    path = true_paths(reports, case, rng)
    z = measure(path, reports, case, rng)
    first = total - updates
    x, P = _start(z[:, :first], reports, case)
    r = {"R / 4": 0.5, "R x 4": 2.0}.get(case, 1.0)
    q = {"Q / 10": 0.1}.get(case, 1.0)
    out: dict[str, Any] = {
        "innovation": np.full((runs, updates, 4), np.nan),
        "S": np.full((runs, updates, 4, 4), np.nan),
        "nis": np.empty((runs, updates)),
        "error": np.empty((runs, updates, 5)),
        "P": np.empty((runs, updates, 5, 5)),
        "A": np.empty((runs, updates, 5, 5)),
    }
    for k in range(first, total):
        full = reports.kinds[:, k] == 0
        F, dt = jacobian(x, reports.dt[:, k]), reports.dt[:, k]
        P = F @ P @ F.swapaxes(1, 2) + process_noise(x, dt, q)
        x = move(x, dt)
        x, P, keep = _update(
            x,
            P,
            z[:, k],
            full,
            r * noise_std(reports.kinds[:, k], z[:, k, 0]),
            case != "angle wrap bug",
            out,
            k - first,
        )
        out["A"][:, k - first] = keep @ F
        error = x - path[:, k]
        error[:, 3] = (error[:, 3] + 180) % 360 - 180
        out["error"][:, k - first], out["P"][:, k - first] = error, P
    return _log(out, reports.kinds[:, first:])


def _start(z: Floats, reports: Reports, case: str) -> tuple[Floats, Floats]:
    """From the last tentative report; the bad start has placeholders for speed and course."""
    x = np.zeros((len(z), 5))
    x[:, :4] = z[:, -1]
    P = np.zeros((len(z), 5, 5))
    std = noise_std(reports.kinds[:, z.shape[1] - 1], z[:, -1, 0])
    P[:, range(4), range(4)] = std**2
    P[:, 4, 4] = 0.02**2
    if case == "bad start":
        x[:, 2:4] = 0.0
        P[:, 2, 2], P[:, 3, 3], P[:, 4, 4] = 9.0, 100.0, 0.25
    return x, P


def _update(x, P, z, full, std, wrap, out, k):  # type: ignore[no-untyped-def]
    """An update with what each run reports; a component that is not reported gains nothing."""
    H = np.eye(4, 5) * np.where(full[:, None], 1.0, [1.0, 1.0, 0.0, 0.0])[:, :, None]
    R = np.eye(4) * np.where(full[:, None], std, np.where([1, 1, 0, 0], std, 1.0))[:, None, :] ** 2
    v = z - x[:, :4]
    if wrap:
        v[:, 3] = (v[:, 3] + 180) % 360 - 180
    v = np.where(full[:, None] | np.array([True, True, False, False]), v, 0.0)
    S = H @ P @ H.swapaxes(1, 2) + R
    K = np.linalg.solve(S, H @ P).swapaxes(1, 2)
    x = x + (K @ v[..., None])[..., 0]
    x[:, 3] %= 360
    keep = np.eye(5) - K @ H
    P = keep @ P @ keep.swapaxes(1, 2) + K @ R @ K.swapaxes(1, 2)
    out["nis"][:, k] = (v * np.linalg.solve(S, v[..., None])[..., 0]).sum(axis=1)
    out["innovation"][:, k] = np.where(full[:, None] | (np.arange(4) < 2), v, np.nan)
    seen = full[:, None, None] | ((np.arange(4)[:, None] < 2) & (np.arange(4) < 2))
    out["S"][:, k] = np.where(seen, S, np.nan)
    return x, (P + P.swapaxes(1, 2)) / 2, keep


def _log(out: dict[str, Any], kinds: NDArray[np.int64]) -> EstimatorLog:
    observed: Sequence[Sequence[int]] = ([0, 1, 2, 3], [0, 1], [0, 1])
    flat = kinds.ravel()
    return as_log(out, [KINDS[k] for k in flat], STATES, observed=[observed[k] for k in flat])
