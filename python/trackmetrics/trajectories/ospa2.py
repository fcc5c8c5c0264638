"""OSPA(2): the OSPA distance between sets of tracks over a window of time."""

import math
from typing import Any

import numpy as np

from trackmetrics import _backend, _check, _deprecated, errors
from trackmetrics.results import OSPA2Result
from trackmetrics.trajectories import _input

_WINDOW_SHARE = 1 - 1e-9
"""Fraction of a window that counts: times in steps such as 0.1 are rounded."""


@_deprecated.parameters(base="distance")
def ospa2(
    truth: Any,
    tracks: Any,
    c: float,
    p: float,
    q: float | None = None,
    window: float = math.inf,
    distance: str = "euclidean",
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
        Cutoff in the unit of the states, positive and finite: what each unmatched track costs.
    p : float
        Order over the tracks, at least 1.
    q : float, optional
        Order over time, at least 1; ``p`` where it is not given.
    window : float
        Length of the window in the unit of time: at time t it holds the times in (t - window, t].
        Without it, all times up to t.
    distance : {"euclidean", "p-norm"}
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
    >>> ospa2(truth, tracks, c=10, p=1).distance
    array([0.        , 0.        , 6.66666667, 7.5       ])
    """
    c, p, window, q = _check.numbers(c=c, p=p, window=window, q=p if q is None else q)
    x, y = _input.read("truth", truth), _input.read("tracks", tracks)
    _input.check_distance(distance)
    clock = _input.clock(x, y)
    when = clock if times is None else _evaluation_times(times)
    if not window > 0:
        raise errors.parameter("window", "positive", window)
    parts = _backend.kernels.ospa2(
        (x.states, x.starts),
        _input.steps(x, clock),
        (y.states, y.starts),
        _input.steps(y, clock),
        np.searchsorted(clock, when - window * _WINDOW_SHARE, side="right"),
        np.searchsorted(clock, when, side="right"),
        c,
        p,
        q,
        distance,
    )
    return OSPA2Result(when, *parts)


def _evaluation_times(times: Any) -> _check.Floats:
    when = _check.floats("times", times)
    if when.ndim != 1:
        raise errors.shape("times", when.shape, "(T,)")
    if not np.isfinite(when).all():
        i = int(np.argmin(np.isfinite(when)))
        raise errors.not_finite("times", [i], when[i])
    return when
