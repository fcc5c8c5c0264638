"""Trajectory GOSPA: localisation, missed and false states, and switches."""

import math
from typing import Any

from trackmetrics import _check, _deprecated, errors
from trackmetrics.results import TrajectoryGOSPAResult
from trackmetrics.trajectories import _input
from trackmetrics.trajectories._gospa_solver import Parts, close_pairs, clusters, weights


@_deprecated.parameters(base="distance")
def trajectory_gospa(
    truth: Any, tracks: Any, c: float, p: float, gamma: float, distance: str = "euclidean"
) -> TrajectoryGOSPAResult:
    """Trajectory GOSPA: localisation, missed and false states and track switches in one metric.

    With weights W_t(i, j) of at least 0 that say how much truth i is followed by track j at time t,
    at most 1 in sum over the tracks and over the truths,

        distance^p = min over W of  sum over t and pairs of  W_t(i, j) min(c, d_t(i, j))^p
                                    + c^p / 2  for every state that is not followed
                                    + gamma^p / 2 sum over t and pairs of |W_t+1(i, j) - W_t(i, j)|

    where a pair of which only one exists counts as that one not followed.

    Parameters
    ----------
    truth, tracks : list of (times, states)
        For each trajectory the times at which it exists, shape (n,), and its states there, shape
        (n, d) or (n,). A hole is a time left out. States are positions in one unit.
    c : float
        Cutoff in the unit of the states, positive and finite: pairs farther apart are not matched.
    p : float
        Order, finite and at least 1.
    gamma : float
        Cost of a switch in the unit of the states, positive and finite. A track that takes over
        from another costs gamma^p, one that begins or ends to follow half of it.
    distance : {"euclidean", "p-norm"}
        The distance of two states. The authors' code takes the norm of order ``p``.

    Returns
    -------
    TrajectoryGOSPAResult
        The distance, at least 0, which is best, and for each time the four parts whose sum is its
        p-th power.

    Raises
    ------
    ValueError
        Where a parameter is out of range, a trajectory has a time twice, a number is not finite, or
        states have different numbers of coordinates.
    TypeError
        Where a trajectory is not a pair.

    Notes
    -----
    A metric: the relaxation to weights between 0 and 1 keeps the triangle inequality, which whole
    assignments at each time need not. A state that exists begins or ends without the cost of a
    switch. Where several W are optimal the distance is the same, but the parts may fall otherwise.

    Trajectories that are never nearer than c are solved apart. Where only one truth or only one
    track is involved a chain of choices is solved exactly; otherwise a linear programme by HiGHS,
    whose tolerances are 1e-7. There is one implementation for both backends.

    References
    ----------
    García-Fernández, Rahmathullah and Svensson, "A metric on the space of finite sets of
    trajectories for evaluation of multi-target tracking algorithms", IEEE Trans. Signal Processing
    68, 2020, doi:10.1109/TSP.2020.3005309.

    Examples
    --------
    One truth, followed by one track for two steps and by another for the next two:

    >>> truth = [([0, 1, 2, 3], [0.0, 1.0, 2.0, 3.0])]
    >>> tracks = [([0, 1], [0.5, 1.5]), ([2, 3], [2.0, 3.0])]
    >>> result = trajectory_gospa(truth, tracks, c=8, p=1, gamma=2)
    >>> result.distance
    3.0
    >>> result.totals()
    {'localization': 1.0, 'missed': 0.0, 'false': 0.0, 'switching': 2.0}
    """
    c, gamma, p = _check.numbers(c=c, gamma=gamma, p=p)
    _check_parameters(c=c, gamma=gamma, p=p)
    _input.check_distance(distance)
    x, y = _input.read("truth", truth), _input.read("tracks", tracks)
    _input.check_dimensions(x, y)
    times = _input.clock(x, y)
    norm = 2.0 if distance == "euclidean" else p
    found = close_pairs(x, y, times, c, norm, p)
    parts = Parts.unassigned(x, y, times)
    for cluster in clusters(found, x.count, y.count):
        cost = cluster.switching_cost(gamma / c, p)
        parts.add_cluster(cluster, weights(cluster, cost), cost)
    return TrajectoryGOSPAResult(c * parts.total() ** (1 / p), times, *parts.scaled(c**p))


def _check_parameters(c: float, gamma: float, p: float) -> None:
    for name, value in (("c", c), ("gamma", gamma)):
        if not 0 < value < math.inf:
            raise errors.parameter(name, "positive and finite", value)
    if not 1 <= p < math.inf:
        raise errors.parameter("p", "finite and at least 1", p)
    if p * math.log10(c) > 300:
        raise errors.parameter("c", "such that its p-th power is finite", c)
