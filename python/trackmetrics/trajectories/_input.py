"""Turns trajectories as users hold them into states and steps of a common clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors

Floats = NDArray[np.float64]
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class Trajectories:
    """A set of trajectories, flat."""

    states: Floats
    """All states, shape (N, d), trajectory by trajectory."""
    starts: Ids
    """Where each trajectory begins, shape (n + 1,)."""
    times: Floats
    """The time of each state, rising within a trajectory, shape (N,)."""

    @property
    def count(self) -> int:
        """How many trajectories."""
        return len(self.starts) - 1


def read(argument: str, values: Any) -> Trajectories:
    """Trajectories from a list of ``(times, states)``, one pair each; a hole is a time left out."""
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise TypeError(
            f"{argument} must be a list of (times, states), got {type(values).__name__}"
        )
    pairs = [_pair(f"{argument}[{i}]", value) for i, value in enumerate(values)]
    full = [i for i, (times, _) in enumerate(pairs) if len(times)]
    for i in full:
        found, expected = pairs[i][1].shape[1], pairs[full[0]][1].shape[1]
        if found != expected:
            raise errors.dimension(argument, [i, 0], found, expected)
    lengths = [0, *(len(times) for times, _ in pairs)]
    return Trajectories(
        np.concatenate([pairs[i][1] for i in full]) if full else np.empty((0, 0)),
        np.cumsum(lengths, dtype=np.int64),
        np.concatenate([pairs[i][0] for i in full]) if full else np.empty(0),
    )


def _pair(argument: str, value: Any) -> tuple[Floats, Floats]:
    """The times of one trajectory, rising, and its states."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise TypeError(f"{argument} must be a pair (times, states)")
    times = _check.floats(f"{argument}[0]", value[0])
    if times.ndim != 1:
        raise errors.shape(f"{argument}[0]", times.shape, "(n,)")
    states = _check.points(f"{argument}[1]", value[1])
    if len(states) != len(times):
        raise errors.length(f"{argument}[1]", len(states), f"{argument}[0]", len(times), "times")
    for k in np.flatnonzero(~np.isfinite(times))[:1]:
        raise errors.not_finite(f"{argument}[0]", [int(k)], times[k])
    for k, component in np.argwhere(~np.isfinite(states))[:1]:
        raise errors.not_finite(f"{argument}[1]", [int(k)], states[k, component])
    order = np.argsort(times, kind="stable")
    times = times[order]
    for k in np.flatnonzero(np.diff(times) == 0)[:1]:
        raise ValueError(f"{argument} has time {float(times[k])!r} twice")
    return times, np.ascontiguousarray(states[order])


def clock(*sets: Trajectories) -> Floats:
    """All times at which something exists, rising."""
    return np.unique(np.concatenate([trajectories.times for trajectories in sets]))


def steps(trajectories: Trajectories, times: Floats) -> Ids:
    """The step of a clock at which each state stands."""
    return np.searchsorted(times, trajectories.times).astype(np.int64, copy=False)


def check_dimensions(x: Trajectories, y: Trajectories) -> None:
    expected, found = x.states.shape[1], y.states.shape[1]
    if len(x.states) and len(y.states) and found != expected:
        first = int(np.searchsorted(y.starts, 0, side="right")) - 1
        raise errors.dimension("tracks", [first, 0], found, expected)


def check_distance(distance: str) -> None:
    """The distance of two states is one that both metrics know."""
    if distance not in ("euclidean", "p-norm"):
        raise ValueError(f"distance must be 'euclidean' or 'p-norm', got {distance!r}")
