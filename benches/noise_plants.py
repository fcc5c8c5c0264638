"""Plants of which the factors on the claimed noises are known, to measure `estimate_noise` on.

The user's filter claims Q and R of a plant; the truth has ``q`` times that process noise, and of
each sensor ``r`` times the measurement noise. A fault is something that neither explains.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs import EstimatorLog

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Sensor:
    """What a sensor measures, and the noise that the filter claims."""

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
    states: tuple[str, ...]
    push: Floats
    """Direction of a manoeuvre's increment of the state at each step."""


def chain(order: int, dt: float, density: float) -> tuple[Floats, Floats]:
    """Transition and noise of an integrated white noise."""
    from math import factorial

    i = np.arange(order)
    F = np.zeros((order, order))
    for a in range(order):
        for b in range(a, order):
            F[a, b] = dt ** (b - a) / factorial(b - a)
    a, b = order - 1 - i[:, None], order - 1 - i[None, :]
    factorials = np.array([factorial(k) for k in range(order)], float)
    Q = density * dt ** (a + b + 1) / (a + b + 1) / factorials[a] / factorials[b]
    return F, Q


def tide() -> Plant:
    """The level of a harbour, a random walk of 2 cm a step; one gauge of 3 cm."""
    one = np.ones((1, 1))
    sensors = [Sensor("gauge", one, 9.0 * one)]
    return Plant("tide", one, 4.0 * one, sensors, 100.0 * one, ("level",), np.ones(1))


def drone() -> Plant:
    """A drone in a plane at constant velocity; a radar of position every second."""
    F, Q = chain(2, 1.0, 0.6)
    H = np.kron(np.eye(2), [[1.0, 0.0]])
    return Plant(
        "drone", np.kron(np.eye(2), F), np.kron(np.eye(2), Q),
        [Sensor("radar", H, 4.0 * np.eye(2))],
        np.kron(np.eye(2), np.diag([10.0, 10.0])), ("x", "vx", "y", "vy"),
        np.array([0.5, 1.0, -0.5, -1.0]),
    )  # fmt: skip


def ferry() -> Plant:
    """A ferry in a plane; a radar of position and a transponder of position and velocity."""
    F, Q = chain(2, 4.0, 0.05)
    position = np.kron(np.eye(2), [[1.0, 0.0]])
    return Plant(
        "ferry", np.kron(np.eye(2), F), np.kron(np.eye(2), Q),
        [
            Sensor("radar", position, 400.0 * np.eye(2)),
            Sensor("transponder", np.eye(4), np.diag([100.0, 0.25, 100.0, 0.25])),
        ],
        np.kron(np.eye(2), np.diag([400.0, 25.0])), ("x", "vx", "y", "vy"),
        np.array([8.0, 4.0, -8.0, -4.0]),
    )  # fmt: skip


def lift() -> Plant:
    """A lift at constant acceleration; a laser of height, and an accelerometer."""
    F, Q = chain(3, 0.5, 0.02)
    return Plant(
        "lift", F, Q,
        [
            Sensor("laser", np.array([[1.0, 0, 0]]), np.array([[0.04]])),
            Sensor("accelerometer", np.array([[0, 0, 1.0]]), np.array([[0.01]])),
        ],
        np.diag([1.0, 1.0, 0.25]), ("z", "vz", "az"), np.array([0.02, 0.125, 0.5]),
    )  # fmt: skip


def oven() -> Plant:
    """A temperature that returns to its set point, and the drift of a thermometer's offset."""
    F = np.diag([0.8, 0.99])
    Q = np.diag([1.5, 0.01])
    return Plant(
        "oven", F, Q,
        [
            Sensor("cheap", np.array([[1.0, 1.0]]), np.array([[1.0]])),
            Sensor("good", np.array([[1.0, 0.0]]), np.array([[0.25]])),
        ],
        np.diag([4.0, 0.5]), ("temperature", "offset"), np.array([1.0, 0.0]),
    )  # fmt: skip


PLANTS = {plant().name: plant for plant in (tide, drone, ferry, lift, oven)}


@dataclass(frozen=True)
class Case:
    """A truth beside the claims: factors on the noises, or a fault that they do not explain."""

    q: float = 1.0
    r: float | Mapping[str, float] = 1.0
    bias: float = 0.0
    """Of the last sensor, in true standard deviations of each component."""
    outliers: float = 0.0
    """Fraction of measurements that are off by 5 to 15 standard deviations."""
    initial: float = 0.0
    """Error of the start in claimed standard deviations of each state."""
    correlation: float = 0.0
    """Of the measurement noise with that of the same sensor's measurement before."""
    manoeuvre: float = 0.0
    """Size of the increments from 70 % on, in standard deviations of the innovation at last."""
    short: bool = False
    """Whether the manoeuvre ends after 10 % of the run."""
    missed: float = 0.0
    """Fraction of measurements that never arrive."""


def root(Q: Floats) -> Floats:
    """A square root of a covariance that may be singular."""
    values, vectors = np.linalg.eigh(Q)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def simulate(plant: Plant, case: Case, updates: int, runs: int, seed: int) -> dict[str, Any]:
    """Columns ``(runs, updates, ...)`` of many logs of one case, all with the same updates."""
    rng = np.random.default_rng([seed, updates])
    n, m = len(plant.F), max(len(s.R) for s in plant.sensors)
    factors = {
        s.name: case.r if np.isscalar(case.r) else case.r.get(s.name, 1.0) for s in plant.sensors
    }
    truth = np.zeros((runs, n))
    start = rng.normal(size=(runs, n)) @ np.linalg.cholesky(plant.P0).T
    signs = rng.choice([-1.0, 1.0], (runs, n))
    x = truth + start + case.initial * signs * np.sqrt(plant.P0.diagonal())
    P = plant.P0
    shape = (runs, updates)
    out = {
        "innovation": np.full((*shape, m), np.nan),
        "S": np.full((*shape, m, m), np.nan), "R": np.full((*shape, m, m), np.nan),
        "H": np.full((*shape, m, n), np.nan), "A": np.empty((*shape, n, n)),
        "P_pred": np.empty((*shape, n, n)), "P": np.empty((*shape, n, n)),
        "x_pred": np.empty((*shape, n)), "x": np.empty((*shape, n)),
        "truth": np.empty((*shape, n)), "z": np.full((*shape, m), np.nan),
    }  # fmt: skip
    push = kick(plant, case.manoeuvre) if case.manoeuvre else np.zeros(n)
    first = int(0.7 * updates)
    last = first + max(5, updates // 10) if case.short else updates
    memory: dict[str, Floats] = {}
    types, F, step = [], np.eye(n), 0
    for k in range(updates):
        F, Q = np.eye(n), np.zeros((n, n))
        while True:
            truth = truth @ plant.F.T + rng.normal(size=(runs, n)) @ root(plant.Q * case.q).T
            if first <= k < last:
                truth = truth + push
            F, Q, step = plant.F @ F, plant.F @ Q @ plant.F.T + plant.Q, step + 1
            if rng.random() >= case.missed:
                break
        sensor = plant.sensors[(step - 1) % len(plant.sensors)]
        p = len(sensor.R)
        L = np.linalg.cholesky(sensor.R * factors[sensor.name])
        white = rng.normal(size=(runs, p))
        if case.correlation and sensor.name in memory:
            white = (
                case.correlation * memory[sensor.name] + (1 - case.correlation**2) ** 0.5 * white
            )
        memory[sensor.name] = white
        v = white @ L.T
        if case.outliers:
            hit = rng.random(runs) < case.outliers
            size = rng.uniform(5, 15, (runs, 1)) * rng.choice([-1.0, 1.0], (runs, p))
            v = np.where(hit[:, None], size * np.sqrt(sensor.R.diagonal()), v)
        if case.bias and sensor is plant.sensors[-1]:
            v = v + case.bias * np.sqrt((sensor.R * factors[sensor.name]).diagonal())
        xp, Pp = x @ F.T, F @ P @ F.T + Q
        z = truth @ sensor.H.T + v
        S = sensor.H @ Pp @ sensor.H.T + sensor.R
        K = np.linalg.solve(S, sensor.H @ Pp).T
        nu = z - xp @ sensor.H.T
        keep = np.eye(n) - K @ sensor.H
        x, P = xp + nu @ K.T, keep @ Pp @ keep.T + K @ sensor.R @ K.T
        out["innovation"][:, k, :p], out["z"][:, k, :p] = nu, z
        out["S"][:, k, :p, :p], out["R"][:, k, :p, :p] = S, sensor.R
        out["H"][:, k, :p], out["A"][:, k] = sensor.H, keep @ F
        out["P_pred"][:, k], out["P"][:, k] = Pp, P
        out["x_pred"][:, k], out["x"][:, k], out["truth"][:, k] = xp, x, truth
        types.append(sensor.name)
    return {**out, "measurement_type": types}


def kick(plant: Plant, sigmas: float) -> Floats:
    """The increment along ``push`` that at last shifts the innovation by ``sigmas`` in each
    component (root mean square)."""
    P, error, shifts = plant.P0, np.zeros(len(plant.F)), []
    for k in range(200 * len(plant.sensors)):
        sensor = plant.sensors[k % len(plant.sensors)]
        Pp = plant.F @ P @ plant.F.T + plant.Q
        S = sensor.H @ Pp @ sensor.H.T + sensor.R
        K = np.linalg.solve(S, sensor.H @ Pp).T
        predicted = plant.F @ error + plant.push
        shift = sensor.H @ predicted
        shifts.append(shift @ np.linalg.solve(S, shift) / len(shift))
        error, P = predicted - K @ shift, Pp - K @ S @ K.T
    return plant.push * sigmas / np.sqrt(np.mean(shifts[-len(plant.sensors) :]))


def one_log(plant: Plant, columns: dict[str, Any], run: int) -> EstimatorLog:
    """The log of one run."""
    own = {name: values[run] for name, values in columns.items() if name != "measurement_type"}
    kinds = columns["measurement_type"]
    return EstimatorLog.from_columns(states=plant.states, measurement_type=kinds, **own)
