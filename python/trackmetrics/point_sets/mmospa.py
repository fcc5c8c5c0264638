"""The mean OSPA of an estimate over hypotheses, and estimates that make it small.

A hypothesis puts the states of all targets into one matrix, a column for each; hypotheses stand
along the last axis. Which column belongs to which target may differ between hypotheses.

Crouse, Willett and Bar-Shalom, "Developing a real-time track display that operators do not hate",
IEEE Trans. Signal Processing 59(7), 2011.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check, errors

__all__ = ["calc_mospa_error", "mmospa2tar_2d", "mmospa_approx"]

Floats = NDArray[np.float64]
Order = NDArray[np.int64]


def calc_mospa_error(x_est: Any, x: Any, w: Any) -> float:
    """Mean OSPA error of an estimate over weighted hypotheses, of order 2 and without a cutoff.

    For an estimate E of n targets, hypotheses X_k and weights w_k,

        error = sqrt(1/n sum_k w_k min over permutations q of sum_i |E_i - X_k,q(i)|^2)

    Parameters
    ----------
    x_est : array_like of shape (d, n)
        The estimate: the state of each target in a column.
    x : array_like of shape (d, n, K)
        The hypotheses.
    w : array_like of shape (K,)
        Their weights, at least 0, which should sum to 1: they are taken as they are.

    Returns
    -------
    float
        The error in the unit of the states, at least 0, which is best.

    Raises
    ------
    ValueError
        Where shapes do not fit or are empty, a number is not finite or a weight is negative.

    References
    ----------
    Crouse, Willett and Bar-Shalom, "Developing a real-time track display that operators do not
    hate", IEEE Trans. Signal Processing 59(7), 2011.

    Examples
    --------
    >>> import numpy as np
    >>> swapped = np.array([[1.0, 0.0], [0.0, 0.0]])[:, :, None]
    >>> calc_mospa_error([[0.0, 2.0], [0.0, 0.0]], swapped, [1.0])
    0.7071067811865476
    """
    hypotheses, weights = _hypotheses(x, w)
    estimate = _finite("x_est", x_est)
    if estimate.shape != hypotheses.shape[:2]:
        d, n, _ = hypotheses.shape
        raise errors.shape("x_est", estimate.shape, f"({d}, {n})")
    total = 0.0
    for k, weight in enumerate(weights):
        hypothesis = hypotheses[:, :, k]
        difference = estimate - hypothesis[:, _order(estimate, hypothesis)]
        total += weight * float(np.sum(difference * difference))
    return float(np.sqrt(total / estimate.shape[1]))


def mmospa2tar_2d(particles: Any) -> Floats:
    """The estimate of two targets in the plane with the least mean OSPA over particles.

    Sorted by the direction from one target to the other, the particles whose targets are swapped in
    the best estimate stand at the front: every place to cut is tried.

    Parameters
    ----------
    particles : array_like of shape (4, N)
        Particles of equal weight in columns: x and y of one target, x and y of the other.

    Returns
    -------
    ndarray of shape (4,)
        The estimate, in the particles' unit; either order of the two targets is as good.

    Raises
    ------
    ValueError
        Where there is no particle, the shape is not ``(4, N)`` or a number is not finite.

    Notes
    -----
    Exact for particles whose targets stand apart. Time grows as N log N.

    References
    ----------
    Crouse, Willett and Bar-Shalom, "Developing a real-time track display that operators do not
    hate", IEEE Trans. Signal Processing 59(7), 2011.

    Examples
    --------
    >>> mmospa2tar_2d([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
    array([0., 0., 1., 1.])
    """
    states = _finite("particles", particles)
    if states.ndim != 2 or states.shape[0] != 4 or not states.shape[1]:
        raise errors.shape("particles", states.shape, "(4, N), N at least 1")
    states = states[:, np.argsort(_direction(states), kind="stable")]
    wrong = states[0] > states[2]
    states[:, wrong] = states[np.ix_([2, 3, 0, 1], wrong)]
    mean = states.mean(axis=1)
    without, swapped, means = _swap_one_by_one(states, mean)
    best = _first_best(mean, without, swapped)
    result: Floats = mean if best < 0 else means[best].copy()
    return result


def mmospa_approx(x: Any, w: Any, num_scans: int = 1) -> tuple[Floats, Order]:
    """An estimate with a small mean OSPA over weighted hypotheses, found by ordering one at a time.

    The hypotheses enter one by one, each in the order of targets that fits the mean so far best.
    Further scans take each out again, order it against the rest and put it back, backwards and
    forwards.

    Parameters
    ----------
    x : array_like of shape (d, n, K)
        The hypotheses: the state of each of n targets in a column.
    w : array_like of shape (K,)
        Their weights, at least 0, which should sum to 1: they are taken as they are.
    num_scans : int
        How many scans, at least 1: the first forwards, each further one backwards and forwards.

    Returns
    -------
    estimate : ndarray of shape (d, n)
        The weighted mean of the ordered hypotheses, in the unit of the states.
    order_list : ndarray of int64, shape (n, K)
        For each hypothesis the column that was taken for each target.

    Raises
    ------
    ValueError
        Where shapes do not fit or are empty, a number is not finite, a weight is negative or
        ``num_scans`` is below 1.

    Notes
    -----
    A local optimum, found in O(K n^3) a scan. The first hypothesis gives the order of the targets.

    References
    ----------
    Crouse, Willett and Bar-Shalom, "Developing a real-time track display that operators do not
    hate", IEEE Trans. Signal Processing 59(7), 2011.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.array([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]]])
    >>> estimate, order = mmospa_approx(x, [0.5, 0.5])
    >>> estimate[0], order[:, 1]
    (array([0., 1.]), array([1, 0]))
    """
    hypotheses, weights = _hypotheses(x, w)
    num_scans = _check.whole("num_scans", num_scans)
    if num_scans < 1:
        raise errors.parameter("num_scans", "at least 1", num_scans)
    n, count = hypotheses.shape[1:]
    orders = np.tile(np.arange(n)[:, None], count)
    estimate = weights[0] * hypotheses[:, :, 0]
    for k in range(1, count):
        orders[:, k] = _order(estimate, hypotheses[:, :, k])
        estimate = estimate + weights[k] * hypotheses[:, orders[:, k], k]
    # The first hypothesis fixes the order; the last of a sweep is where the next begins.
    sweep = [*range(count - 2, 0, -1), *range(2, count)] * (num_scans - 1)
    for k in sweep:
        rest = estimate - hypotheses[:, orders[:, k], k] * weights[k]
        orders[:, k] = _order(rest, hypotheses[:, :, k])
        estimate = rest + weights[k] * hypotheses[:, orders[:, k], k]
    return estimate, orders


def _order(estimate: Floats, hypothesis: Floats) -> Order:
    """The column of the hypothesis for each target: the largest sum of inner products, which is the
    least sum of squared distances."""
    costs = np.ascontiguousarray(-(estimate.T @ hypothesis))
    columns: Order = _backend.kernels.linear_sum_assignment(costs, False)[1]
    return columns


def _direction(states: Floats) -> Floats:
    """The direction from one target to the other, up to its sign; NaN, which sorts last, where they
    stand together."""
    dx, dy = states[:2] - states[2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        angles: Floats = np.arctan(dy / dx)
    return angles


def _swap_one_by_one(states: Floats, mean: Floats) -> tuple[Floats, Floats, Floats]:
    """The means after each swap; with them, the mean without the particle swapped, and its part."""
    n = states.shape[1]
    # Contiguous: a product of strided rows would round differently.
    swapped = np.ascontiguousarray(states[[2, 3, 0, 1]].T / n)
    steps = np.empty((2 * n + 1, 4))
    steps[0], steps[1::2], steps[2::2] = mean, -states.T / n, swapped
    sums = np.add.accumulate(steps)
    return sums[1::2], swapped, sums[2::2]


def _first_best(mean: Floats, without: Floats, swapped: Floats) -> int:
    """Where the mean is longest first, -1 for no swap at all.

    Swapping everything is as good as nothing, so that rounding decides: what is close to the best
    is computed once more, term by term.
    """
    lengths = ((without + swapped) ** 2).sum(axis=1)
    close = lengths >= lengths.max() * (1 - 1e-9)
    best, longest = -1, float(mean @ mean)
    for j in np.flatnonzero(close):
        rest, part = without[j], swapped[j]
        length = float(rest @ rest + 2.0 * rest @ part + part @ part)
        if length > longest:
            best, longest = int(j), length
    return best


def _hypotheses(x: Any, w: Any) -> tuple[Floats, list[float]]:
    hypotheses, weights = _finite("x", x), _finite("w", w).ravel()
    if hypotheses.ndim != 3 or not hypotheses.size:
        raise errors.shape("x", hypotheses.shape, "(d, n, K), each at least 1")
    if len(weights) != hypotheses.shape[2]:
        raise errors.length("w", len(weights), "x", hypotheses.shape[2], "hypotheses")
    if (weights < 0).any():
        i = int(np.argmax(weights < 0))
        raise errors.parameter(f"w[{i}]", "at least 0", weights[i])
    return hypotheses, weights.tolist()


def _finite(argument: str, values: Any) -> Floats:
    array = np.array(_check.floats(argument, values))
    if not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0]
        raise errors.not_finite(argument, index, array[tuple(index)])
    return array
