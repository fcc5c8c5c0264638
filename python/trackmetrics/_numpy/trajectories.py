"""Distances between sets of trajectories: reference of ``trajectories`` in the core."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, frames, plain_ids
from trackmetrics._numpy.assignment import solve

Ids = NDArray[np.int64]
Trajectory = tuple[Ids, Floats]
"""Steps that rise, and the state at each."""


def ospa2(
    truth: Any,
    truth_steps: Ids,
    tracks: Any,
    track_steps: Ids,
    first: Ids,
    beyond: Ids,
    c: float,
    p: float,
    q: float,
    base: str,
) -> tuple[Floats, Floats, Floats]:
    """OSPA(2) over each window: (distance, localization, cardinality)."""
    if base not in ("euclidean", "p-norm"):
        raise ValueError(f"base must be 'euclidean' or 'p-norm', got '{base}'")
    x = _trajectories("truth", truth, truth_steps)
    y = _trajectories("tracks", tracks, track_steps)
    plain_ids(first, beyond)
    _check(x, y, c, p, q)
    order = 2.0 if base == "euclidean" else p
    found = [_distance(x, y, window, c, p, q, order) for window in zip(first, beyond, strict=True)]
    parts = np.array(found, dtype=np.float64).reshape(len(found), 3)
    return parts[:, 0].copy(), parts[:, 1].copy(), parts[:, 2].copy()


def _trajectories(argument: str, packed: Any, steps: Ids) -> list[Trajectory]:
    states = frames(argument, packed)
    plain_ids(steps)
    if len(steps) != sum(map(len, states)):
        raise errors.offsets(argument, len(steps))
    split = np.split(steps, packed[1][1:-1]) if states else []
    for i, part in enumerate(split):
        if (np.diff(part) <= 0).any():
            raise errors.steps_not_increasing(argument, i)
    return list(zip(split, states, strict=True))


def _check(x: list[Trajectory], y: list[Trajectory], c: float, p: float, q: float) -> None:
    if not 0 < c < math.inf:
        raise errors.parameter("c", "positive and finite", c)
    for name, value in (("p", p), ("q", q)):
        if not 1 <= value < math.inf:
            raise errors.parameter(name, "finite and at least 1", value)
    sizes = [states.shape[1] for _, states in x if len(states)]
    for j, (_, states) in enumerate(y):
        if sizes and len(states) and states.shape[1] != sizes[0]:
            raise errors.dimension("tracks", [j, 0], states.shape[1], sizes[0])


def _distance(
    x: list[Trajectory],
    y: list[Trajectory],
    window: tuple[int, int],
    c: float,
    p: float,
    q: float,
    order: float,
) -> tuple[float, float, float]:
    """OSPA of the trajectories that exist in a window."""
    x, y = ([f for f in map(_within(window), side) if len(f[0])] for side in (x, y))
    most, missing = max(len(x), len(y)), abs(len(x) - len(y))
    if most == 0:
        return 0.0, 0.0, 0.0
    costs = np.array([[_mean_power(f, g, c, q, order) ** (p / q) for g in y] for f in x])
    total = 0.0
    if costs.size:
        columns = solve(costs)
        matched = columns >= 0
        total = costs[matched, columns[matched]].sum()
    parts = [c * (part / most) ** (1 / p) for part in (total + missing, total, missing)]
    return parts[0], parts[1], parts[2]


def _within(window: tuple[int, int]) -> Any:
    def cut(f: Trajectory) -> Trajectory:
        inside = (f[0] >= window[0]) & (f[0] < window[1])
        return f[0][inside], f[1][inside]

    return cut


def _mean_power(f: Trajectory, g: Trajectory, c: float, q: float, order: float) -> float:
    """The mean q-th power of the distance over the steps of either, in units of c, cut off."""
    (s, x), (t, y) = f, g
    _, i, j = np.intersect1d(s, t, assume_unique=True, return_indices=True)
    with np.errstate(over="ignore"):
        ratio = (np.abs((x[i] - y[j]) / c) ** order).sum(axis=1) ** (1 / order)
    either = len(s) + len(t) - len(i)
    return float((np.minimum(ratio, 1.0) ** q).sum() + either - len(i)) / either
