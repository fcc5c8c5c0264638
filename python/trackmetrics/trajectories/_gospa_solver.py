"""Trajectory GOSPA: the assignment over time of least cost, solved cluster by cluster.

In units of c^p a state of either side costs 1/2 where it is not matched. A pair (i, j) that is held
with weight W at a step where the two are nearer than c saves the gain 1 - (d/c)^p of it; elsewhere
holding it is free. Every change of W costs (gamma/c)^p / 2. So the metric is

    (states / 2  -  max over W of  sum gain W - (gamma/c)^p / 2 sum |change of W|) c^p

over weights of at least 0 whose sums over each truth and over each track are at most 1.
Trajectories that are never nearer than c have no part in each other's weights: clusters are solved
one by one, on the steps at which some pair of theirs has a gain. A cluster around a single truth or
a single track is a chain of choices, solved exactly by dynamic programming: its changes are a
distance on a star with "unmatched" in the middle, for which the relaxation on a chain is tight.
Any other cluster is a linear programme.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics.trajectories._input import Trajectories, steps

Floats = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class ClosePairs:
    """Every step at which a truth and a track are nearer than the cutoff."""

    step: Places
    truth: Places
    track: Places
    power: Floats
    """The p-th power of their distance in units of the cutoff, below 1."""


@dataclass(frozen=True)
class Cluster:
    """Trajectories that meet, directly or through others."""

    pairs: Places
    """Truth and track of each pair that meets, shape (P, 2)."""
    steps: Places
    """The steps at which some pair is near, shape (L,)."""
    powers: Floats
    """The p-th power of their distance in units of c, shape (P, L); 1 where they are not near."""

    @property
    def gains(self) -> Floats:
        """What holding a pair at a step saves, shape (P, L)."""
        return 1 - self.powers

    def switching_cost(self, ratio: float, p: float) -> float:
        """What a change of 1 costs, for a ``ratio`` of gamma to c.

        A change that costs more than all possible gains is never made, whatever it costs.
        """
        most = 1 + float(self.gains.sum())
        return most if p * math.log(ratio) > math.log(2 * most) else ratio**p / 2


def close_pairs(
    x: Trajectories, y: Trajectories, times: Floats, c: float, norm: float, p: float
) -> ClosePairs:
    """All close pairs of two sets on a common clock."""
    found = [
        _close_pairs_at(k, x, i, y, j, c, norm, p)
        for k, (i, j) in enumerate(
            zip(_states_by_step(x, times), _states_by_step(y, times), strict=True)
        )
        if len(i) and len(j)
    ]
    if not found:
        nothing = np.empty(0, dtype=np.intp)
        return ClosePairs(nothing, nothing, nothing, np.empty(0))
    return ClosePairs(*(np.concatenate(part) for part in zip(*found, strict=True)))


def _states_by_step(x: Trajectories, times: Floats) -> list[Places]:
    when = steps(x, times)
    order = np.argsort(when, kind="stable")
    return np.split(order, np.searchsorted(when[order], np.arange(1, len(times))))


def _close_pairs_at(
    k: int, x: Trajectories, i: Places, y: Trajectories, j: Places, c: float, norm: float, p: float
) -> tuple[Places, Places, Places, Floats]:
    with np.errstate(over="ignore"):
        differences = np.abs((x.states[i, None] - y.states[None, j]) / c)
        ratios = (differences**norm).sum(axis=-1) ** (1 / norm)
    a, b = np.nonzero(ratios < 1)
    owners = [
        np.searchsorted(side.starts, at, side="right") - 1 for side, at in ((x, i[a]), (y, j[b]))
    ]
    return np.full(len(a), k), owners[0], owners[1], ratios[a, b] ** p


def clusters(found: ClosePairs, truths: int, tracks: int) -> Iterator[Cluster]:
    """The connected parts of the graph of close_pairs."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(found.step):
        return
    edges = (np.ones(len(found.step)), (found.truth, truths + found.track))
    graph = coo_array(edges, shape=(truths + tracks,) * 2)
    label = connected_components(graph, directed=False)[1][found.truth]
    order = np.argsort(label, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        yield _cluster(found, members)


def _cluster(found: ClosePairs, members: Places) -> Cluster:
    both = np.stack([found.truth[members], found.track[members]], axis=1)
    pairs, which = np.unique(both, axis=0, return_inverse=True)
    when, column = np.unique(found.step[members], return_inverse=True)
    powers = np.ones((len(pairs), len(when)))
    powers[which.ravel(), column] = found.power[members]
    return Cluster(pairs, when, powers)


def weights(cluster: Cluster, cost: float) -> Floats:
    """How much each pair is held at each step, where a change of 1 costs ``cost``."""
    if (cluster.pairs == cluster.pairs[0]).all(axis=0).any():
        return _dynamic_program(cluster.gains, cost)
    return _linear_program(cluster, cost)


def _dynamic_program(gains: Floats, cost: float) -> Floats:
    """One pair at a time, or none: the best sequence of choices.

    A change from one pair to another leads through none, so that a step needs to look at the best
    choice before it only, and at the same one.
    """
    count, length = gains.shape
    held, free = [0.0] * count, 0.0  # the best value so far that ends in each choice
    history = []
    for gain in gains.T.tolist():
        best = max(range(count), key=held.__getitem__)
        released = held[best] - cost
        source, free = (best, released) if released > free else (-1, free)
        taken = free - cost
        history.append((source, [value >= taken for value in held]))
        held = [max(value, taken) + g for value, g in zip(held, gain, strict=True)]
    return _trace(history, held, free, (count, length))


def _trace(
    history: list[tuple[int, list[bool]]], held: list[float], free: float, shape: tuple[int, int]
) -> Floats:
    """Follows the choices of `_dynamic_program` back from the last step; -1 stands for none."""
    result = np.zeros(shape)
    choice = max(range(shape[0]), key=held.__getitem__)
    choice = choice if held[choice] > free else -1
    for k in range(shape[1] - 1, -1, -1):
        source, kept = history[k]
        if choice >= 0:
            result[choice, k] = 1.0
        if choice < 0 or not kept[choice]:
            choice = source
    return result


def _linear_program(cluster: Cluster, cost: float) -> Floats:
    """The linear programme over the weights and their changes up and down."""
    from scipy.optimize import linprog
    from scipy.sparse import csr_matrix, hstack, identity, kron

    pairs, length = cluster.powers.shape
    each = identity(pairs * (length - 1))
    one = identity(length, format="csr")
    shares = kron(csr_matrix(_owners(cluster)), one)
    # After minus before is what went up minus what went down.
    balance = hstack([kron(identity(pairs), one[1:] - one[:-1]), -each, each])
    solution = linprog(
        np.concatenate([-cluster.gains.ravel(), np.full(2 * pairs * (length - 1), cost)]),
        A_ub=hstack([shares, csr_matrix((shares.shape[0], 2 * each.shape[0]))]),
        b_ub=np.ones(shares.shape[0]),
        A_eq=balance if length > 1 else None,
        b_eq=np.zeros(each.shape[0]) if length > 1 else None,
        method="highs",
    )
    if solution.status != 0:
        raise RuntimeError(f"the linear programme was not solved: {solution.message}")
    found: Floats = solution.x[: pairs * length].reshape(pairs, length)
    return found.clip(0, 1)


def _owners(cluster: Cluster) -> Floats:
    """A row for each truth and each track: 1 for its pairs."""
    names = (np.unique(side) for side in cluster.pairs.T)
    rows = [side == name[:, None] for side, name in zip(cluster.pairs.T, names, strict=True)]
    return np.concatenate(rows).astype(np.float64)


@dataclass
class Parts:
    """The four parts for each step, in units of c^p."""

    localization: Floats
    missed: Floats
    false: Floats
    switching: Floats

    @classmethod
    def unassigned(cls, x: Trajectories, y: Trajectories, times: Floats) -> "Parts":
        """The parts where nothing is matched."""
        missed, false = (np.bincount(steps(s, times), minlength=len(times)) / 2 for s in (x, y))
        return cls(np.zeros(len(times)), missed, false, np.zeros(max(len(times) - 1, 0)))

    def add_cluster(self, cluster: Cluster, held: Floats, cost: float) -> None:
        """Takes in the weights of one cluster."""
        held_near = held * (cluster.powers < 1)
        followed = held_near.sum(axis=0)
        self.localization[cluster.steps] += (held_near * cluster.powers).sum(axis=0)
        self.missed[cluster.steps] -= followed / 2
        self.false[cluster.steps] -= followed / 2
        # Between the steps of a cluster nothing changes until just before the next.
        changes = cost * np.abs(np.diff(held, axis=1)).sum(axis=0)
        self.switching[cluster.steps[1:] - 1] += changes

    def total(self) -> float:
        """The sum of all parts."""
        return math.fsum(float(part.sum()) for part in self._all())

    def scaled(self, unit: float) -> list[Floats]:
        """The parts in units of their own."""
        return [unit * part.clip(0, None) for part in self._all()]

    def _all(self) -> tuple[Floats, Floats, Floats, Floats]:
        return self.localization, self.missed, self.false, self.switching
