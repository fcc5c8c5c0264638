"""Filters with known faults, many runs at once: what the rates of the diagnosis are measured on.

A plant is a target, its sensors and the Kalman filter of a user; a case is a fault in one of them.
Manoeuvres and biases are given in standard deviations of that plant's own innovation or sensor, so
that a case means the same on every plant. Runs are simulated together, step by step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs import EstimatorLog, State

Floats = NDArray[np.float64]

ONSET = 0.7
"""Share of the run after which a manoeuvre begins."""


@dataclass(frozen=True)
class Sensor:
    """What a sensor sees, and how noisily."""

    name: str
    H: Floats
    R: Floats


@dataclass(frozen=True)
class Plant:
    """A linear target and its sensors, which take turns."""

    name: str
    F: Floats
    Q: Floats
    sensors: Sequence[Sensor]
    P0: Floats
    push: Floats
    """Direction of a manoeuvre's increment of the state at each step."""
    wrong_start: Floats
    """Error of a bad start in claimed standard deviations of each state."""
    states: tuple[str, ...] = field(default=())

    def steady(self) -> tuple[list[Floats], list[Floats]]:
        """Innovation covariance and gain of each sensor's turn, long after the start."""
        P, S, K = self.P0, [], []
        for k in range(200 * len(self.sensors)):
            P, s, gain, _ = _filter_step(self.F, self.Q, P, self.sensors[k % len(self.sensors)])
            S, K = [*S, s][-len(self.sensors) :], [*K, gain][-len(self.sensors) :]
        return S, K

    def kick(self, sigmas: float) -> Floats:
        """The increment along ``push`` that at last shifts the innovation by ``sigmas`` in each
        component (root mean square)."""
        S, K = self.steady()
        error, shifts = np.zeros(len(self.F)), []
        for k in range(200 * len(self.sensors)):
            i = k % len(self.sensors)
            predicted = self.F @ error - self.push
            shift = -self.sensors[i].H @ predicted
            shifts.append(shift @ np.linalg.solve(S[i], shift) / len(shift))
            error = predicted + K[i] @ shift
        return self.push * sigmas / np.sqrt(np.mean(shifts[-len(self.sensors) :]))


def _filter_step(F: Floats, Q: Floats, P: Floats, sensor: Sensor) -> tuple[Floats, ...]:
    """Updated covariance, innovation covariance, gain and (I - K H) F."""
    P = F @ P @ F.T + Q
    S = sensor.H @ P @ sensor.H.T + sensor.R
    K = np.linalg.solve(S, sensor.H @ P).T
    keep = np.eye(len(F)) - K @ sensor.H
    return keep @ P @ keep.T + K @ sensor.R @ K.T, S, K, keep @ F


LATE, MILD, SHORT = 5.6, 3.0, 7.4
"""Steady shifts of the innovation in sigmas a component: a hard, a mild and a short manoeuvre."""

CASES = (
    "consistent",
    "Q / 10",
    "R / 4",
    "biased sensor",
    "biased only sensor",
    "late manoeuvre",
    "mild late manoeuvre",
    "short manoeuvre",
    "bad start",
    "R x 4",
    "Q x 10",
    "P x 4",
    "outliers",
)


def simulate(plant: Plant, case: str, updates: int, runs: int, seed: int) -> EstimatorLog:
    """The log of many runs of one case, with truth."""
    rng = np.random.default_rng([seed, updates, CASES.index(case)])
    q = {"Q / 10": 0.1, "Q x 10": 10.0, "P x 4": 4.0}.get(case, 1.0)
    r = {"R / 4": 0.25, "R x 4": 4.0, "P x 4": 4.0}.get(case, 1.0)
    sensors = plant.sensors[:1] if case == "biased only sensor" else plant.sensors
    start = np.sqrt(plant.P0.diagonal())
    n, d = len(plant.F), max(len(s.R) for s in sensors)
    truth = np.zeros((runs, n))
    x = truth + rng.normal(size=(runs, n)) @ np.linalg.cholesky(plant.P0).T
    if case == "bad start":
        x = x + plant.wrong_start * start
    P = plant.P0
    shape = (runs, updates)
    out: dict[str, Any] = {
        "innovation": np.full((*shape, d), np.nan),
        "S": np.full((*shape, d, d), np.nan),
        "error": np.empty((*shape, n)),
        "P": np.empty((*shape, n, n)),
        "A": np.empty((*shape, n, n)),
    }
    for k in range(updates):
        sensor = sensors[k % len(sensors)]
        m = len(sensor.R)
        truth = truth @ plant.F.T + rng.normal(size=(runs, n)) @ _root(plant.Q).T
        truth = truth + _manoeuvre(plant, case, k, updates)
        z = truth @ sensor.H.T + _noise(sensor, case, runs, rng)
        if case in ("biased sensor", "biased only sensor") and sensor is sensors[-1]:
            z[:, 0] += 1.5 * np.sqrt(sensor.R[0, 0])
        claimed = Sensor(sensor.name, sensor.H, sensor.R * r)
        P, S, K, A = _filter_step(plant.F, plant.Q * q, P, claimed)
        predicted = x @ plant.F.T
        innovation = z - predicted @ sensor.H.T
        x = predicted + innovation @ K.T
        out["innovation"][:, k, :m] = innovation
        out["S"][:, k, :m, :m] = S
        out["error"][:, k], out["P"][:, k], out["A"][:, k] = x - truth, P, A
    kinds = [sensors[k % len(sensors)].name for k in range(updates)]
    return as_log(out, kinds, plant.states or [f"x{i}" for i in range(n)])


def as_log(
    out: dict[str, Any], kinds: Sequence[str], states: Sequence[str | State], **more: Any
) -> EstimatorLog:
    """Runs as tracks; ``kinds`` of one run, or of all of them one behind the other."""
    runs, updates = out["error"].shape[:2]
    flat = {name: v.reshape(runs * updates, *v.shape[2:]) for name, v in out.items()}
    return EstimatorLog.from_columns(
        track=np.repeat([f"run {i}" for i in range(runs)], updates),
        time=np.tile(np.arange(float(updates)), runs),
        measurement_type=list(kinds) * (runs if len(kinds) == updates else 1),
        states=states,
        **flat,
        **more,
    )


def _root(Q: Floats) -> Floats:
    """A square root of a covariance that may be singular."""
    values, vectors = np.linalg.eigh(Q)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def _manoeuvre(plant: Plant, case: str, k: int, updates: int) -> Floats | float:
    first = int(ONSET * updates)
    if case == "late manoeuvre" and k >= first:
        return plant.kick(LATE)
    if case == "mild late manoeuvre" and k >= first:
        return plant.kick(MILD)
    if case == "short manoeuvre" and first <= k < first + max(5, updates // 10):
        return plant.kick(SHORT)
    return 0.0


def _noise(sensor: Sensor, case: str, runs: int, rng: np.random.Generator) -> Floats:
    m = len(sensor.R)
    noise = rng.normal(size=(runs, m)) @ np.linalg.cholesky(sensor.R).T
    if case == "outliers":
        hit = rng.random(runs) < 0.05
        noise[hit] += rng.normal(size=(hit.sum(), m)) * 5 * np.sqrt(sensor.R.diagonal())
    return noise


def _chain(order: int, dt: float, q: float) -> tuple[Floats, Floats]:
    """An integrated white noise: its transition and the covariance of its increments."""
    i = np.arange(order)
    power = i[None, :] - i[:, None]
    factorial = np.cumprod([1.0, *range(1, order)])
    F = np.where(power >= 0, dt ** np.maximum(power, 0) / factorial[np.maximum(power, 0)], 0.0)
    a, b = order - 1 - i[:, None], order - 1 - i[None, :]
    Q = q * dt ** (a + b + 1) / (a + b + 1) / factorial[a] / factorial[b]
    return F, Q


def two_sensors() -> Plant:
    """Constant velocity in a plane; two position sensors of 10 and 15 m take turns every 5 s."""
    F, Q = _chain(2, 5.0, 0.5)
    H = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0]])
    push = np.array([12.5, 5.0, -12.5, -5.0])
    return Plant(
        "two sensors",
        np.kron(np.eye(2), F),
        np.kron(np.eye(2), Q),
        [Sensor("A", H, 100.0 * np.eye(2)), Sensor("B", H, 225.0 * np.eye(2))],
        np.diag([100.0, 25.0, 100.0, 25.0]),
        push,
        np.array([0.0, -5.0, 0.0, 4.0]),
        ("x", "vx", "y", "vy"),
    )


def one_range() -> Plant:
    """Along a line, constant velocity; two ranging sensors of 5 and 8 m take turns every second."""
    F, Q = _chain(2, 1.0, 4.0)
    H = np.array([[1.0, 0.0]])
    return Plant(
        "one range",
        F,
        Q,
        [Sensor("near", H, np.array([[25.0]])), Sensor("far", H, np.array([[64.0]]))],
        np.diag([25.0, 100.0]),
        np.array([0.5, 1.0]),
        np.array([0.0, 6.0]),
        ("s", "v"),
    )


def depth() -> Plant:
    """Up and down, constant velocity; a pressure gauge of 3 m and a sonar of 4.5 m every 2 s."""
    F, Q = _chain(2, 2.0, 2.0)
    H = np.array([[1.0, 0.0]])
    return Plant(
        "depth",
        F,
        Q,
        [Sensor("gauge", H, np.array([[9.0]])), Sensor("sonar", H, np.array([[20.25]]))],
        np.diag([9.0, 16.0]),
        np.array([2.0, 2.0]),
        np.array([0.0, 7.0]),
        ("d", "vd"),
    )


def in_space() -> Plant:
    """In space, constant velocity; a radar of three coordinates and a camera of two take turns."""
    F, Q = _chain(2, 2.0, 1.0)
    radar = np.kron(np.eye(3), [[1.0, 0.0]])
    return Plant(
        "in space",
        np.kron(np.eye(3), F),
        np.kron(np.eye(3), Q),
        [
            Sensor("radar", radar, np.diag([36.0, 36.0, 100.0])),
            Sensor("camera", radar[:2], 16.0 * np.eye(2)),
        ],
        np.kron(np.eye(3), np.diag([36.0, 25.0])),
        np.array([2.0, 2.0, -2.0, -2.0, 1.0, 1.0]),
        np.array([0.0, 5.0, 0.0, -4.0, 0.0, 0.0]),
        ("x", "vx", "y", "vy", "z", "vz"),
    )


def accelerating() -> Plant:
    """Along a line, constant acceleration; one ranging sensor of 3 m every second."""
    F, Q = _chain(3, 1.0, 0.3)
    H = np.array([[1.0, 0.0, 0.0]])
    return Plant(
        "accelerating",
        F,
        Q,
        [Sensor("range", H, np.array([[9.0]]))],
        np.diag([9.0, 25.0, 4.0]),
        np.array([1 / 6, 0.5, 1.0]),
        np.array([0.0, 5.0, 4.0]),
        ("s", "v", "a"),
    )


def doppler() -> Plant:
    """Along a line, constant velocity; a radar of range and speed and a ranging sensor take turns
    every 3 s."""
    F, Q = _chain(2, 3.0, 0.8)
    H = np.eye(2)
    return Plant(
        "doppler",
        F,
        Q,
        [Sensor("radar", H, np.diag([64.0, 4.0])), Sensor("range", H[:1], np.array([[36.0]]))],
        np.diag([64.0, 49.0]),
        np.array([4.5, 3.0]),
        np.array([0.0, 6.0]),
        ("s", "v"),
    )


PLANTS: dict[str, Callable[[], Any]] = {
    "two sensors": two_sensors,
    "one range": one_range,
    "depth": depth,
    "in space": in_space,
    "accelerating": accelerating,
    "doppler": doppler,
}
