"""Distances between finite sets of points."""

from typing import Any

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
        parts = kernel(X, Y, c, p)
    except NotPlain:
        parts = kernel(_check.points("X", X), _check.points("Y", Y), c, p)
    return OSPAResult(*parts)
