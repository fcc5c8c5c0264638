"""Distances between sets of trajectories."""

import math
from typing import Any

import numpy as np

from trackmetrics import _backend, _check, errors
from trackmetrics.results import OSPA2Result, TrajectoryGOSPAResult
from trackmetrics.trajectories import _input
from trackmetrics.trajectories._input import Trajectories
from trackmetrics.trajectories._switching import Parts, clusters, meetings, weights

_SHORTER = 1 - 1e-9
"""So much of a window counts, for times in steps that floats round, such as 0.1."""


def ospa2(
    truth: Any,
    tracks: Any,
    c: float,
    p: float,
    q: float | None = None,
    window: float = math.inf,
    base: str = "euclidean",
    times: Any = None,
) -> OSPA2Result:
    """OSPA(2): the OSPA distance between two sets of tracks, over a window that trails the time.

    With d_t the distance of the states of f and g at time t, two tracks are compared by

        d(f, g)^q = mean over the times in the window at which f or g exists of min(c, d_t)^q,
                    with c where only one exists,

    and for the m <= n tracks of either side that exist in the window,

        ospa2^p = (min over assignments sum_i d(f_i, g_i)^p + c^p (n - m)) / n

    Parameters
    ----------
    truth, tracks : list of (times, states)
        For each trajectory the times at which it exists, shape (n,), and its states there, shape
        (n, d) or (n,). A hole is a time left out. States are positions in one unit.
    c : float
        Cutoff in the unit of the states, positive and finite: the price of a track too many.
    p : float
        Order over the tracks, at least 1.
    q : float, optional
        Order over time, at least 1; ``p`` where it is not given.
    window : float
        Length of the window in the unit of time: at time t it holds the times in (t - window, t].
        Without it, all times up to t.
    base : {"euclidean", "p-norm"}
        The distance of two states. The authors' code takes the norm of order ``p``.
    times : array_like of shape (T,), optional
        When to evaluate; without it, at every time at which something exists.

    Returns
    -------
    OSPA2Result
        For each time the distance and its two parts, each in [0, c]; 0 is best.

    Raises
    ------
    ValueError
        Where a parameter is out of range, a trajectory has a time twice, a number is not finite, or
        states have different numbers of coordinates.
    TypeError
        Where a trajectory is not a pair.

    Notes
    -----
    A metric for every window. A track that breaks in two is two tracks, each right half of the
    time, so that OSPA(2) sees fragmentation and switches that OSPA does not. Times within a window
    count alike, however far apart they lie. No track on either side is at distance 0, on one side
    only at distance c.

    References
    ----------
    Beard, Vo and Vo, "A solution for large-scale multi-object tracking", IEEE Trans. Signal
    Processing 68, 2020, doi:10.1109/TSP.2020.2986136.

    Examples
    --------
    >>> truth = [([0, 1, 2, 3], [0.0, 1.0, 2.0, 3.0])]
    >>> tracks = [([0, 1], [0.0, 1.0]), ([2, 3], [2.0, 3.0])]
    >>> ospa2(truth, tracks, c=10, p=1).ospa2
    array([0.        , 0.        , 6.66666667, 7.5       ])
    """
    c, p, window, q = _check.numbers(c=c, p=p, window=window, q=p if q is None else q)
    x, y = _input.read("truth", truth), _input.read("tracks", tracks)
    clock = _input.clock(x, y)
    when = clock if times is None else _evaluation_times(times)
    if not window > 0:
        raise errors.parameter("window", "positive", window)
    parts = _backend.kernels.ospa2(
        (x.states, x.starts),
        _input.steps(x, clock),
        (y.states, y.starts),
        _input.steps(y, clock),
        np.searchsorted(clock, when - window * _SHORTER, side="right"),
        np.searchsorted(clock, when, side="right"),
        c,
        p,
        q,
        base,
    )
    return OSPA2Result(when, *parts)


def trajectory_gospa(
    truth: Any, tracks: Any, c: float, p: float, gamma: float, base: str = "euclidean"
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
        Cutoff in the unit of the states, positive and finite: farther apart, nobody follows.
    p : float
        Order, finite and at least 1.
    gamma : float
        Price of a switch in the unit of the states, positive and finite. A track that takes over
        from another costs gamma^p, one that begins or ends to follow half of it.
    base : {"euclidean", "p-norm"}
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
    assignments at each time need not. A state that exists begins or ends without the price of a
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
    _check_parameters(c=c, gamma=gamma, p=p, base=base)
    x, y = _input.read("truth", truth), _input.read("tracks", tracks)
    _check_dimensions(x, y)
    times = _input.clock(x, y)
    norm = 2.0 if base == "euclidean" else p
    found = meetings(x, y, times, c, norm, p)
    parts = Parts.of_nobody(x, y, times)
    for cluster in clusters(found, x.count, y.count):
        price = cluster.price(gamma / c, p)
        parts.follow(cluster, weights(cluster, price), price)
    return TrajectoryGOSPAResult(c * parts.total() ** (1 / p), times, *parts.scaled(c**p))


def _check_parameters(c: float, gamma: float, p: float, base: str) -> None:
    for name, value in (("c", c), ("gamma", gamma)):
        if not 0 < value < math.inf:
            raise errors.parameter(name, "positive and finite", value)
    if not 1 <= p < math.inf:
        raise errors.parameter("p", "finite and at least 1", p)
    if p * math.log10(c) > 300:
        raise errors.parameter("c", "such that its p-th power is finite", c)
    if base not in ("euclidean", "p-norm"):
        raise ValueError(f"base must be 'euclidean' or 'p-norm', got {base!r}")


def _check_dimensions(x: Trajectories, y: Trajectories) -> None:
    expected, found = x.states.shape[1], y.states.shape[1]
    if len(x.states) and len(y.states) and found != expected:
        first = int(np.searchsorted(y.starts, 0, side="right")) - 1
        raise errors.dimension("tracks", [first, 0], found, expected)


def _evaluation_times(times: Any) -> _check.Floats:
    when = _check.floats("times", times)
    if when.ndim != 1:
        raise errors.shape("times", when.shape, "(T,)")
    if not np.isfinite(when).all():
        i = int(np.argmin(np.isfinite(when)))
        raise errors.not_finite("times", [i], when[i])
    return when
