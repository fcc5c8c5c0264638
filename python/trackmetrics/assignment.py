"""Who is matched with whom, at the least total cost or at the smallest largest cost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.results import BottleneckAssignment


def linear_sum_assignment(
    cost_matrix: Any, maximize: bool = False
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The pairs of rows and columns with the least total cost.

    A drop-in for ``scipy.optimize.linear_sum_assignment``: the same arguments, pairs (also where
    several matchings are optimal) and errors. For an ``(n, m)`` matrix C, over the matchings M of
    min(n, m) pairs,

        minimise  sum over (i, j) in M of C[i, j]

    Parameters
    ----------
    cost_matrix : array_like of shape (n, m)
        The costs, in any unit; ``inf`` forbids a pair.
    maximize : bool
        Whether to find the largest total instead; then ``-inf`` forbids a pair.

    Returns
    -------
    row_ind, col_ind : ndarray of int64, shape (min(n, m),)
        The matched rows, rising, and the column of each. ``cost_matrix[row_ind, col_ind].sum()`` is
        the least total.

    Raises
    ------
    ValueError
        Where ``cost_matrix`` has not two axes, holds NaN or ``-inf`` (``inf`` for ``maximize``), or
        every complete matching has a forbidden pair.
    TypeError
        Where its elements cannot be cast to float64 without loss of kind.

    Notes
    -----
    Of equally good matchings the one that SciPy returns is returned: rows enter one by one, and
    ties fall as in its implementation of Crouse's algorithm.

    References
    ----------
    Crouse, "On implementing 2D rectangular assignment algorithms", IEEE Trans. Aerospace and
    Electronic Systems 52(4), 2016, doi:10.1109/TAES.2016.140952.

    Examples
    --------
    >>> import numpy as np
    >>> cost = np.array([[4, 1, 3], [2, 0, 5], [3, 2, 2]])
    >>> rows, columns = linear_sum_assignment(cost)
    >>> columns
    array([1, 0, 2])
    >>> int(cost[rows, columns].sum())
    5
    """
    kernel = _backend.kernels.linear_sum_assignment
    try:
        pairs: tuple[NDArray[np.int64], NDArray[np.int64]] = kernel(cost_matrix, maximize)
    except NotPlain:
        pairs = kernel(_check.cost_matrix(cost_matrix), maximize)
    return pairs


def bottleneck_assignment(cost_matrix: Any) -> BottleneckAssignment:
    """A complete matching whose largest cost is as small as it can be.

    For an ``(n, m)`` matrix C, over the matchings M of min(n, m) pairs,

        minimise  max over (i, j) in M of C[i, j]

    Parameters
    ----------
    cost_matrix : array_like of shape (n, m)
        The costs, in any unit; ``inf`` forbids a pair.

    Returns
    -------
    BottleneckAssignment
        The largest cost of a pair and the pairs. The cost is NaN where there are no pairs.

    Raises
    ------
    ValueError
        Where ``cost_matrix`` has not two axes, holds NaN or ``-inf``, or every complete matching
        has a forbidden pair.
    TypeError
        Where its elements cannot be cast to float64 without loss of kind.

    Notes
    -----
    The cost is unique, the pairs are in general not: all that is promised of them is that none
    costs more. OSPA of order ``p = inf`` is a bottleneck assignment.

    References
    ----------
    Burkard, Dell'Amico and Martello, "Assignment Problems", SIAM 2012, section 6.2,
    doi:10.1137/1.9781611972238.

    Examples
    --------
    The least sum, 0 + 9, has a pair that costs 9.

    >>> result = bottleneck_assignment([[0, 5], [6, 9]])
    >>> result.cost
    6.0
    >>> result.col_ind
    array([1, 0])
    """
    kernel = _backend.kernels.bottleneck_assignment
    try:
        return BottleneckAssignment(*kernel(cost_matrix))
    except NotPlain:
        return BottleneckAssignment(*kernel(_check.cost_matrix(cost_matrix)))
