"""The Generalised Optimal Sub-Pattern Assignment (GOSPA) metric between finite sets of points."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.point_sets.distances import Distance, distances
from trackmetrics.results import GOSPAResult, GOSPASequence

_Gospa = tuple[tuple[float, float, float, float, int, int], NDArray[np.int64]]


def gospa(
    X: Any,
    Y: Any,
    c: float,
    p: float = 2.0,
    alpha: float = 2.0,
    *,
    distance: Distance = "euclidean",
) -> GOSPAResult:
    """Generalised Optimal Sub-Pattern Assignment (GOSPA) metric of truth and estimates.

    For alpha = 2, over all sets of disjoint pairs (x, y),

        gospa = min (sum over pairs d(x, y)^p + c^p / 2 (missed + false))^(1/p)

    where missed and false are the numbers of points of X and of Y without a partner. For other
    alpha and sets of m <= n points,

        gospa = (min over assignments sum_i min(d_i, c)^p + c^p / alpha (n - m))^(1/p)

    Parameters
    ----------
    X, Y : list of array_like, or array of shape (n, d)
        The points of the truth and of the estimate, all in one unit.
    c : float
        Cutoff, positive and finite, in the unit of the points: no pair is farther apart.
    p : float
        Order, at least 1 and finite.
    alpha : float
        What a point too many costs is ``c ** p / alpha``; above 0, at most 2.
    distance : {"euclidean", "manhattan", "haversine"}, Mahalanobis or callable
        The distance of two points, as in ``ospa``.

    Returns
    -------
    GOSPAResult
        The distance, at least 0, which is best; its parts as p-th powers that add up to
        ``distance ** p`` (NaN unless ``alpha = 2``), the counts, and the pairs.

    Raises
    ------
    ValueError
        Where a parameter is out of range, a coordinate is not finite, or points have different
        numbers of coordinates.

    Notes
    -----
    Not divided by the number of points, unlike OSPA: two more false alarms cost more. A metric
    where the distance of points is one; a score with a covariance for each point, or with a
    callable that is no metric. Ties are broken as in ``ospa_assignment``.

    References
    ----------
    Rahmathullah, Garcia-Fernandez and Svensson, "Generalized optimal sub-pattern assignment
    metric", 20th International Conference on Information Fusion, 2017,
    doi:10.23919/ICIF.2017.8009645.

    Examples
    --------
    >>> result = gospa([[0.0], [10.0]], [[3.0], [30.0], [50.0]], c=5)
    >>> result.localization, result.missed, result.false
    (9.0, 12.5, 25.0)
    >>> result.assignment
    array([[0, 0]])
    """
    if distance != "euclidean":
        return gospa_from_distances(distances(X, Y, distance), c, p, alpha)
    kernel = _backend.kernels.gospa
    try:
        answer: _Gospa = kernel(X, Y, c, p, alpha)
    except NotPlain:
        x, y = _check.points("X", X), _check.points("Y", Y)
        answer = kernel(x, y, *_check.numbers(c=c, p=p, alpha=alpha))
    return GOSPAResult(*answer[0], answer[1])


def gospa_from_distances(
    distances: Any, c: float, p: float = 2.0, alpha: float = 2.0
) -> GOSPAResult:
    """GOSPA of two sets of which only the distances between their points are known.

    Parameters
    ----------
    distances : array_like of shape (m, n)
        The distance of each point of X from each point of Y, at least 0; ``inf`` for two that can
        never be a pair. An empty set is an array of shape (0, n) or (m, 0).
    c, p, alpha : float
        As in ``gospa``.

    Returns
    -------
    GOSPAResult
        As of ``gospa``.

    Raises
    ------
    ValueError
        Where a distance is negative or NaN, or a parameter is out of range.

    Examples
    --------
    >>> gospa_from_distances([[1.0, 7.0], [7.0, 3.0]], c=5, p=1).distance
    4.0
    """
    kernel = _backend.kernels.gospa_from_distances
    try:
        answer: _Gospa = kernel(distances, c, p, alpha)
    except NotPlain:
        matrix = _check.matrix("distances", distances)
        answer = kernel(matrix, *_check.numbers(c=c, p=p, alpha=alpha))
    return GOSPAResult(*answer[0], answer[1])


def gospa_over_time(
    X_sequence: Any, Y_sequence: Any, c: float, p: float = 2.0, alpha: float = 2.0
) -> GOSPASequence:
    """GOSPA at every frame of two sequences of point sets.

    Entry t of each field is that of ``gospa(X_sequence[t], Y_sequence[t], c, p, alpha)``.

    Parameters
    ----------
    X_sequence, Y_sequence : list of sets of points, array of shape (T, n, d), or packed
        The truth and the estimates, equally long, as in ``ospa_over_time``.
    c, p, alpha : float
        As in ``gospa``.

    Returns
    -------
    GOSPASequence
        Distances, parts and counts, each of shape (T,).

    Raises
    ------
    ValueError
        Where the sequences are not equally long, and as in ``gospa``; the message names the frame
        and the point.

    Examples
    --------
    >>> result = gospa_over_time([[[0.0]], [[1.0], [9.0]]], [[[3.0]], [[1.0]]], c=4, p=1)
    >>> result.distance
    array([3., 2.])
    >>> result.num_missed
    array([0, 1])
    """
    kernel = _backend.kernels.gospa_over_time
    try:
        parts, counts = kernel(X_sequence, Y_sequence, c, p, alpha)
    except NotPlain:
        X = _check.frames("X_sequence", X_sequence)
        Y = _check.frames("Y_sequence", Y_sequence)
        parts, counts = kernel(X, Y, *_check.numbers(c=c, p=p, alpha=alpha))
    return GOSPASequence(*parts, *counts)
