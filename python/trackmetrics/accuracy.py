"""How far are estimates from the truth?"""

from typing import Any

from trackmetrics import _backend, _check
from trackmetrics._check import Floats
from trackmetrics.errors import NotPlain


def rmse(true_states: Any, estimated_states: Any, axis: Any = None) -> Any:
    """Root mean square error over all elements, or over some axes.

        rmse = sqrt( mean over the axes of (true_states - estimated_states)^2 )

    Parameters
    ----------
    true_states, estimated_states : array_like of one shape
        Truth and estimates, in the same units; usually ``(N, d)``.
    axis : int or tuple of int, optional
        What to average over; everything by default. For ``(N, d)``, 0 gives one error for each
        component, 1 one for each state.

    Returns
    -------
    float or ndarray
        At least 0, 0 is best, in the units of the states; the axes that are left, or a float where
        none is.

    Raises
    ------
    ValueError
        Where shapes differ (nothing is broadcast), an axis does not exist, or there is nothing to
        average.

    Notes
    -----
    NaN propagates. Integers are computed in double precision and never overflow.

    Examples
    --------
    >>> rmse([[0, 0], [1, 1]], [[3, 0], [1, 5]])
    2.5
    >>> rmse([[0, 0], [1, 1]], [[1, 0], [2, 5]], axis=1)
    array([0.70710678, 2.91547595])
    """
    kernel = _backend.kernels.rmse
    axes = _check.axes(axis)
    try:
        return kernel(true_states, estimated_states, axes)
    except NotPlain:
        truth = _check.floats("true_states", true_states)
        return kernel(truth, _check.floats("estimated_states", estimated_states), axes)


def position_rmse(true_states: Any, estimated_states: Any, position_indices: Any) -> float:
    """Root mean square error of the position components, over all states and components.

    Parameters
    ----------
    true_states, estimated_states : array_like of one shape (..., d)
        Truth and estimates, in the same units.
    position_indices : sequence of int
        Which components are positions. A number, a slice or a mask will do as well.

    Returns
    -------
    float
        At least 0, 0 is best, in the unit of the positions.

    Raises
    ------
    ValueError
        Where shapes differ, an index is outside the state, or there is nothing to average.

    Notes
    -----
    The mean is over components too: the root mean square *distance* in k dimensions is sqrt(k)
    times as large. NaN propagates.

    Examples
    --------
    >>> position_rmse([[0.0, 1.0, 0.0, 1.0]], [[3.0, 1.0, 4.0, 1.0]], [0, 2])
    3.5355339059327378
    """
    kernel = _backend.kernels.position_rmse
    return _rmse_of(kernel, true_states, estimated_states, "position_indices", position_indices)


def velocity_rmse(true_states: Any, estimated_states: Any, velocity_indices: Any) -> float:
    """Root mean square error of the velocity components, over all states and components.

    Parameters
    ----------
    true_states, estimated_states : array_like of one shape (..., d)
        Truth and estimates, in the same units.
    velocity_indices : sequence of int
        Which components are velocities. A number, a slice or a mask will do as well.

    Returns
    -------
    float
        At least 0, 0 is best, in the unit of the velocities; a mean over components as in
        :func:`position_rmse`.

    Raises
    ------
    ValueError
        As in :func:`position_rmse`.

    Examples
    --------
    >>> velocity_rmse([[0.0, 1.0, 0.0, 1.0]], [[3.0, 1.0, 4.0, 3.0]], [1, 3])
    1.4142135623730951
    """
    kernel = _backend.kernels.velocity_rmse
    return _rmse_of(kernel, true_states, estimated_states, "velocity_indices", velocity_indices)


def _rmse_of(kernel: Any, truth: Any, estimates: Any, argument: str, indices: Any) -> float:
    truth = _check.floats("true_states", truth)
    estimates = _check.floats("estimated_states", estimates)
    length = truth.shape[-1] if truth.ndim else 0
    return float(kernel(truth, estimates, _check.indices(argument, indices, length)))


def monte_carlo_rmse(errors: Any, axis: Any = 0) -> Any:
    """Root mean square of errors over Monte Carlo runs.

    Parameters
    ----------
    errors : array_like
        Errors, truth less estimate; usually ``(runs, N, d)``.
    axis : int, tuple of int or None
        The axis of the runs; None for all axes.

    Returns
    -------
    float or ndarray
        At least 0, 0 is best; the axes that are left, or a float where none is.

    Raises
    ------
    ValueError
        Where the axis does not exist, or there is nothing to average.

    Notes
    -----
    NaN propagates. Integers are computed in double precision and never overflow.

    Examples
    --------
    >>> monte_carlo_rmse([[[3, 1]], [[4, 1]], [[5, 1]], [[0, 1]]])
    array([[3.53553391, 1.        ]])
    """
    kernel = _backend.kernels.monte_carlo_rmse
    axes = _check.axes(axis)
    try:
        return kernel(errors, axes)
    except NotPlain:
        return kernel(_check.floats("errors", errors), axes)


def estimation_error_bounds(covariances: Any, sigma: float = 2.0) -> Floats:
    """What a filter says its errors will seldom exceed: ``sigma`` standard deviations.

        bounds = sigma sqrt(diag P)

    Parameters
    ----------
    covariances : array_like of shape (..., d, d)
        Covariances of the estimates' errors.
    sigma : float
        How many standard deviations; 2 holds about 95 % of Gaussian errors.

    Returns
    -------
    ndarray of shape (..., d)
        Bounds in the units of the states.

    Raises
    ------
    ValueError
        Where matrices are not square, a variance is negative or not finite, or ``sigma`` is not
        finite.

    Examples
    --------
    >>> estimation_error_bounds([[[1.0, 0.0], [0.0, 4.0]]])
    array([[2., 4.]])
    """
    kernel = _backend.kernels.estimation_error_bounds
    try:
        bounds = kernel(covariances, sigma)
    except NotPlain:
        covariances = _check.floats("covariances", covariances)
        bounds = kernel(covariances, _check.number("sigma", sigma))
    result: Floats = bounds
    return result
