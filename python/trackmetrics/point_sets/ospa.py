"""The Optimal Sub-Pattern Assignment (OSPA) distance between finite sets of points."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.point_sets.distances import Distance, distances
from trackmetrics.results import OSPAResult


def ospa(
    X: Any, Y: Any, c: float = 100.0, p: float = 2.0, *, distance: Distance = "euclidean"
) -> OSPAResult:
    """Optimal Sub-Pattern Assignment (OSPA) distance between two finite sets of points.

    For sets of m <= n points, with d the distance of two points,

        ospa = ((min over assignments sum_i min(d_i, c)^p + c^p (n - m)) / n)^(1/p)

    Parameters
    ----------
    X, Y : list of array_like, or array of shape (n, d)
        The points of the truth and of the estimate, all in one unit.
    c : float
        Cutoff, in the unit of the points: the price of a point too many or too few. ``inf`` is
        allowed.
    p : float
        Order, at least 0.001; a metric for ``p >= 1``. ``inf`` gives the bottleneck distance.
    distance : {"euclidean", "manhattan", "haversine"}, Mahalanobis or callable
        The distance of two points. ``"haversine"`` takes (latitude, longitude) in degrees and gives
        metres; then ``c`` is in metres too. A callable takes a point of X and one of Y.

    Returns
    -------
    OSPAResult
        The distance and its parts, each in [0, c]; 0 is best.

    Raises
    ------
    ValueError
        Where ``c`` is not positive, ``p`` is below 0.001 (where a root of powers keeps too few
        digits), a coordinate is not finite, or points have different numbers of coordinates.

    Notes
    -----
    Symmetric in X and Y, and a metric where the distance of points is one: the named ones, and
    ``Mahalanobis`` with one covariance. Two empty sets are at distance 0, an empty and a non-empty
    one at ``c``.

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
    if distance != "euclidean":
        return ospa_from_distances(distances(X, Y, distance), c, p)
    kernel = _backend.kernels.ospa
    try:
        result: OSPAResult = kernel(X, Y, c, p)
    except NotPlain:
        result = kernel(_check.points("X", X), _check.points("Y", Y), *_check.numbers(c=c, p=p))
    return result


def ospa_over_time(
    X_sequence: Any, Y_sequence: Any, c: float = 100.0, p: float = 2.0
) -> NDArray[np.float64]:
    """OSPA distance at every frame of two sequences of point sets.

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
        Order, at least 0.001; a metric for ``p >= 1``. ``inf`` gives the bottleneck distance.

    Returns
    -------
    ndarray of shape (T,)
        The distances, each in [0, c]; 0 is best.

    Raises
    ------
    ValueError
        Where the sequences are not equally long, and as in ``ospa``; the message names the frame
        and the point.

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
        distances = kernel(X, Y, *_check.numbers(c=c, p=p))
    return distances


def ospa_from_distances(distances: Any, c: float = 100.0, p: float = 2.0) -> OSPAResult:
    """OSPA of two sets of which only the distances between their points are known.

    Parameters
    ----------
    distances : array_like of shape (m, n)
        The distance of each point of X from each point of Y, at least 0; ``inf`` for two that can
        never be a pair. An empty set is an array of shape (0, n) or (m, 0).
    c, p : float
        Cutoff and order, as in ``ospa``.

    Returns
    -------
    OSPAResult
        As of ``ospa``.

    Raises
    ------
    ValueError
        Where a distance is negative or NaN, ``c`` is not positive or ``p`` is below 0.001.

    Examples
    --------
    >>> ospa_from_distances([[1.0, 7.0], [7.0, 3.0]], c=10, p=1).ospa
    2.0
    """
    kernel = _backend.kernels.ospa_from_distances
    try:
        result: OSPAResult = kernel(distances, c, p)
    except NotPlain:
        result = kernel(_check.matrix("distances", distances), *_check.numbers(c=c, p=p))
    return result


def ospa_assignment(X: Any, Y: Any, c: float = 100.0, p: float = 2.0) -> NDArray[np.int64]:
    """The pairs behind ``ospa``: the matched points.

    Parameters
    ----------
    X, Y, c, p
        As in ``ospa``.

    Returns
    -------
    ndarray of shape (k, 2)
        Index in X and index in Y of each pair closer than ``c``; the first rises. A pair at the
        cutoff or beyond costs what two points without a partner cost, and is none.

    Raises
    ------
    ValueError
        As ``ospa``.

    Notes
    -----
    Where several matchings have the least total, the pairs are those that SciPy's
    ``linear_sum_assignment`` finds in the matrix ``min(d, c) ** p``.

    Examples
    --------
    >>> ospa_assignment([[0, 0], [10, 10]], [[10, 11], [90, 90], [1, 0]], c=20)
    array([[0, 2],
           [1, 0]])
    """
    kernel = _backend.kernels.ospa_assignment
    try:
        pairs: NDArray[np.int64] = kernel(X, Y, c, p)
    except NotPlain:
        pairs = kernel(_check.points("X", X), _check.points("Y", Y), *_check.numbers(c=c, p=p))
    return pairs
