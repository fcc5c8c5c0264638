"""Assignment: pairs at the least total cost, or with the smallest largest cost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.results import AuctionAssignment, BottleneckAssignment


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


def linear_sum_assignment_batch(costs: Any, maximize: bool = False) -> Any:
    """The pairs of least total cost of many matrices, in parallel.

    Each matrix is solved as :func:`linear_sum_assignment` solves it, with the same pairs.

    Parameters
    ----------
    costs : array_like of shape (B, n, m), or list of array_like of shapes (n_b, m_b)
        The cost matrices, in any unit; ``inf`` forbids a pair.
    maximize : bool
        Whether to find the largest totals instead; then ``-inf`` forbids a pair.

    Returns
    -------
    row_ind, col_ind : ndarray of int64, shape (B, min(n, m))
        For an array: the matched rows of each matrix, rising, and the column of each.
    pairs : list of (row_ind, col_ind)
        For a list, or anything else that is not an array: the same for each matrix.

    Raises
    ------
    ValueError
        Where a matrix cannot be solved, as :func:`linear_sum_assignment` says, with its index; or
        an array has not three axes.
    TypeError
        Where elements cannot be cast to float64 without loss of kind.

    Notes
    -----
    The pairs do not depend on the number of threads (:func:`trackmetrics.set_threads`).

    Examples
    --------
    >>> import numpy as np
    >>> rows, columns = linear_sum_assignment_batch(np.array([[[1, 2], [1, 5]], [[0, 2], [1, 5]]]))
    >>> columns
    array([[1, 0],
           [1, 0]])
    >>> pairs = linear_sum_assignment_batch([[[1, 2], [1, 5]], [[3, 1, 2]]])
    >>> [columns.tolist() for rows, columns in pairs]
    [[1, 0], [1]]
    """
    kernel = _backend.kernels.linear_sum_assignment_batch
    try:
        return kernel(costs, maximize)
    except NotPlain:
        return kernel(_check.cost_matrices(costs), maximize)


def auction(
    cost_matrix: Any, epsilon: float | None = None, maximize: bool = False
) -> AuctionAssignment:
    """A complete matching whose total cost is within a bound of the least, by Bertsekas' auction.

    Rows bid for columns: a row takes its best column from whoever holds it and raises its price by
    what the second best is worse, and by epsilon. Large epsilons come first.

    For a dense matrix :func:`linear_sum_assignment` is exact and, in every case that was measured,
    faster; see the page on assignment. The auction is here for comparison with trackers that use
    it, and for its bound.

    Parameters
    ----------
    cost_matrix : array_like of shape (n, m)
        The costs, in any unit; ``inf`` forbids a pair. A rectangular matrix is padded to a square
        one, of which the larger of n and m counts as ``n`` below.
    epsilon : float, optional
        The last epsilon, in the unit of the costs: the total is at most ``n * epsilon`` from the
        best. By default ``1 / (n + 1)`` where all costs are whole numbers, which gives the optimum,
        and otherwise a millionth of the largest |cost| over n.
    maximize : bool
        Whether to find the largest total instead; then ``-inf`` forbids a pair.

    Returns
    -------
    AuctionAssignment
        The pairs, the epsilon and the proved bound; a bound of 0 says that the total is the best.

    Raises
    ------
    ValueError
        Where ``cost_matrix`` has not two axes, holds NaN or ``-inf`` (``inf`` for ``maximize``), or
        every complete matching has a forbidden pair, which is found before anything is bid; where
        ``epsilon`` is not positive, or below 1e-12 (and 1e-15 n) of the largest |cost|, where
        prices would not change by it; where the costs are so large that sums overflow.
    TypeError
        Where the elements cannot be cast to float64 without loss of kind.

    Notes
    -----
    The matching is always complete. The bound is computed from the prices, which are feasible
    duals, and includes what sums may lose by rounding.

    References
    ----------
    Bertsekas, "The auction algorithm: a distributed relaxation method for the assignment problem",
    Annals of Operations Research 14, 1988, doi:10.1007/BF02186476.

    Examples
    --------
    >>> result = auction([[4, 1, 3], [2, 0, 5], [3, 2, 2]])
    >>> result.col_ind
    array([1, 0, 2])
    >>> result.bound
    0.0
    >>> auction([[4, 1, 3], [2, 0, 5], [3, 2, 2]], epsilon=0.5).bound <= 1.5001
    True
    """
    kernel = _backend.kernels.auction
    try:
        return AuctionAssignment(*kernel(cost_matrix, epsilon, maximize))
    except NotPlain:
        costs = _check.cost_matrix(cost_matrix)
        step = None if epsilon is None else _check.number("epsilon", epsilon)
        return AuctionAssignment(*kernel(costs, step, maximize))


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
    The cost is unique, the pairs are in general not: the only guarantee is that none
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
