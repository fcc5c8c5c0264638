"""Distances between finite sets of points."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.results import OSPAResult


def ospa(X: Any, Y: Any, c: float = 100.0, p: float = 2.0) -> OSPAResult:
    """Optimal Sub-Pattern Assignment (OSPA) distance between two finite sets of points.

    For sets of m <= n points, with d the Euclidean distance,

        ospa = ((min over assignments sum_i min(d_i, c)^p + c^p (n - m)) / n)^(1/p)

    Parameters
    ----------
    X, Y : list of array_like, or array of shape (n, d)
        The points of the truth and of the estimate, all in one unit.
    c : float
        Cutoff, in the unit of the points: the price of a point too many or too few. ``inf`` is
        allowed.
    p : float
        Order, positive; a metric for ``p >= 1``. ``inf`` gives the bottleneck distance.

    Returns
    -------
    OSPAResult
        The distance and its parts, each in [0, c]; 0 is best.

    Raises
    ------
    ValueError
        Where ``c`` or ``p`` is not positive, a coordinate is not finite, or points have different
        numbers of coordinates.

    Notes
    -----
    Symmetric in X and Y. Two empty sets are at distance 0, an empty and a non-empty one at ``c``.

    References
    ----------
    Schuhmacher, Vo and Vo, "A consistent metric for performance evaluation of multi-object
    filters", IEEE Trans. Signal Processing 56(8), 2008, doi:10.1109/TSP.2008.920469.

    Examples
    --------
    >>> import numpy as np
    >>> X = [np.array([0, 0]), np.array([10, 10])]
    >>> Y = [np.array([1, 0]), np.array([10, 11])]
    >>> ospa(X, Y, c=100, p=2)
    OSPAResult(ospa=1.0, localization=1.0, cardinality=0.0)
    """
    kernel = _backend.kernels.ospa
    try:
        result: OSPAResult = kernel(X, Y, c, p)
    except NotPlain:
        result = kernel(_check.points("X", X), _check.points("Y", Y), c, p)
    return result


def ospa_over_time(
    X_sequence: Any, Y_sequence: Any, c: float = 100.0, p: float = 2.0
) -> NDArray[np.float64]:
    """OSPA distance at every time step of two sequences of point sets.

    Entry t is ``ospa(X_sequence[t], Y_sequence[t], c, p).ospa``.

    Parameters
    ----------
    X_sequence, Y_sequence : list of sets of points, array of shape (T, n, d), or packed
        The truth and the estimates, equally long; all points in one unit and of one dimension.
        A set is what ``ospa`` takes. Packed is the tuple of all points, shape (N, d), and starts,
        integers of shape (T + 1,): set t is the points ``starts[t]:starts[t + 1]``.
    c : float
        Cutoff, in the unit of the points. ``inf`` is allowed.
    p : float
        Order, positive; a metric for ``p >= 1``. ``inf`` gives the bottleneck distance.

    Returns
    -------
    ndarray of shape (T,)
        The distances, each in [0, c]; 0 is best.

    Raises
    ------
    ValueError
        Where the sequences are not equally long, and as in ``ospa``; the message names the time
        step and the point.

    Notes
    -----
    Long sequences are shared among threads; the result has the same bits with any number.

    References
    ----------
    Schuhmacher, Vo and Vo, "A consistent metric for performance evaluation of multi-object
    filters", IEEE Trans. Signal Processing 56(8), 2008, doi:10.1109/TSP.2008.920469.

    Examples
    --------
    >>> truth = [[[0.0, 0.0]], [[1.0, 0.0], [9.0, 9.0]]]
    >>> estimates = [[[0.0, 3.0]], [[1.0, 0.0]]]
    >>> ospa_over_time(truth, estimates, c=10, p=1)
    array([3., 5.])
    """
    kernel = _backend.kernels.ospa_over_time
    try:
        distances: NDArray[np.float64] = kernel(X_sequence, Y_sequence, c, p)
    except NotPlain:
        X = _check.frames("X_sequence", X_sequence)
        Y = _check.frames("Y_sequence", Y_sequence)
        distances = kernel(X, Y, c, p)
    return distances
