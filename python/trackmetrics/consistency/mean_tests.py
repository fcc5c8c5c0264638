"""Means of NEES and NIS with acceptance intervals.

A sum of independent chi-squares is a chi-square of all their degrees of freedom; a weighted or
correlated sum is taken as ``g chi2(h)`` with the right mean and variance (Satterthwaite).
"""

from typing import Any

import numpy as np

from trackmetrics import _check, _deprecated, _distributions, errors
from trackmetrics._check import Floats
from trackmetrics.consistency._input import degrees, errors_of_runs, statistics
from trackmetrics.consistency.results import CovarianceScale, MeanTest, NormalizedMeanError


def mean_test(total: Any, mean: Any, variance: Any, confidence: float) -> MeanTest:
    """Of a sum whose expectation and variance are known, taken as a scaled chi-square."""
    _check.fraction("confidence", confidence)
    scale, dof = variance / (2 * mean), 2 * mean**2 / variance
    lower, upper = _distributions.chi2_interval(dof, confidence)
    lower, upper = scale * lower / mean, scale * upper / mean
    value, p = total / mean, _distributions.chi2_p_value(total / scale, dof)
    return MeanTest(value, lower, upper, dof, p, (lower <= value) & (value <= upper))


@_deprecated.parameters(df="dof")
def anees(nees_values: Any, dof: float, *, axis: int = 0, confidence: float = 0.95) -> MeanTest:
    """Average NEES over independent runs, normalised by the number of states.

        anees = sum_i nees_i / (N d)  ~  chi2(N d) / (N d)

    Parameters
    ----------
    nees_values : array_like of shape (N, ...)
        NEES of N independent runs; other axes (times, tracks) are tested one by one.
    dof : float
        Number of states d.
    axis : int
        The axis of the runs.
    confidence : float
        Probability that a consistent filter passes, at each time by itself.

    Returns
    -------
    MeanTest
        1 if consistent; above 1 optimistic (covariance too small), below 1 pessimistic; with N d
        degrees of freedom.

    Raises
    ------
    ValueError
        For values that are negative or not finite, none at all, or ``dof`` not positive.

    Notes
    -----
    The runs must be independent. Steps of one run are not: see :func:`nees_over_time`.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> test = anees([4.0, 6.0, 5.0, 5.0, 4.0, 6.0, 5.0, 5.0, 5.0, 5.0], dof=5)
    >>> test.value, round(test.lower, 3), round(test.upper, 3), test.is_consistent
    (1.0, 0.647, 1.428, True)
    """
    return _independent("nees_values", nees_values, dof, axis, confidence)


@_deprecated.parameters(df="dof")
def average_nis(nis_values: Any, dof: Any, *, axis: int = -1, confidence: float = 0.95) -> MeanTest:
    """NIS of one run averaged over time, over its expectation; dofs may be mixed.

        sum_k nis_k / sum_k m_k  ~  chi2(sum_k m_k) / sum_k m_k

    Parameters
    ----------
    nis_values : array_like of shape (..., K)
        NIS of consecutive updates; leading axes are tested one by one.
    dof : float or array_like of shape (..., K)
        Number of measured components of each update.
    axis : int
        The axis of time.
    confidence : float
        Probability that a consistent filter passes.

    Returns
    -------
    MeanTest
        1 if consistent; above 1 optimistic (covariance too small), below 1 pessimistic.

    Raises
    ------
    ValueError
        For values that are negative or not finite, none at all, or ``dof`` not positive.

    Notes
    -----
    Exact: the innovations of a consistent linear filter are independent. Test that by
    :func:`whiteness`.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> test = average_nis([2.0, 4.0, 1.0, 5.0], dof=[2, 4, 2, 4])
    >>> test.value, test.dof, test.is_consistent
    (1.0, 12.0, True)
    """
    return _independent("nis_values", nis_values, dof, axis, confidence)


def _independent(argument: str, values: Any, dof: Any, axis: int, confidence: float) -> MeanTest:
    array = statistics(argument, values)
    axis = _check.axis_of(array, axis)
    dof = degrees(dof, array.shape).sum(axis)
    return mean_test(array.sum(axis), dof, 2 * dof, confidence)


@_deprecated.parameters(df="dof")
def moving_average_nis(
    nis_values: Any, dof: Any, window: int, *, confidence: float = 0.95
) -> MeanTest:
    """NIS averaged over a moving window, over its expectation, with pointwise bounds.

    Parameters
    ----------
    nis_values : array_like of shape (..., K)
        NIS of consecutive updates.
    dof : float or array_like of shape (..., K)
        Number of measured components of each update.
    window : int
        How many updates are averaged.
    confidence : float
        Probability that a consistent filter is inside, at each point by itself.

    Returns
    -------
    MeanTest
        Arrays of shape (..., K - window + 1); the first stands for updates 0 .. window - 1.

    Raises
    ------
    ValueError
        As :func:`average_nis`, and where the window does not fit.

    Notes
    -----
    Neighbouring values share all but one update. Somewhere along a run a consistent filter leaves a
    pointwise 95 % band far more often than in 5 % of runs (37 % for 60 updates and a window of 20).

    Examples
    --------
    >>> moving_average_nis([2.0, 2.0, 8.0, 2.0], dof=2, window=2).value
    array([1. , 2.5, 2.5])
    """
    array = statistics("nis_values", nis_values)
    window = _check.whole("window", window)
    if not 1 <= window <= array.shape[-1]:
        raise errors.parameter("window", f"between 1 and {array.shape[-1]}", window)
    dof = _windows(degrees(dof, array.shape), window)
    return mean_test(_windows(array, window), dof, 2 * dof, confidence)


def _windows(values: Floats, window: int) -> Floats:
    result: Floats = np.lib.stride_tricks.sliding_window_view(values, window, -1).sum(-1)
    return result


@_deprecated.parameters(df="dof")
def fading_memory_nis(
    nis_values: Any, dof: Any, factor: float, *, confidence: float = 0.95
) -> MeanTest:
    """NIS averaged with a fading memory, over its expectation, with pointwise bounds.

        f_k = factor f_(k-1) + nis_k  ~  g chi2(h)

    with g and h from the mean and the variance; for a long run of m components each,
    g = 1 / (1 + factor) and h = m (1 + factor) / (1 - factor).

    Parameters
    ----------
    nis_values : array_like of shape (..., K)
        NIS of consecutive updates.
    dof : float or array_like of shape (..., K)
        Number of measured components of each update.
    factor : float
        How much of the memory is kept, between 0 and 1.
    confidence : float
        Probability that a consistent filter is inside, at each point by itself.

    Returns
    -------
    MeanTest
        Arrays of shape (..., K); the start of the run is accounted for.

    Raises
    ------
    ValueError
        As :func:`average_nis`, and for a factor that is not between 0 and 1.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 11.2, doi:10.1002/0471221279.

    Examples
    --------
    >>> fading_memory_nis([2.0, 2.0, 8.0], dof=2, factor=0.5).value.round(3)
    array([1.   , 1.   , 2.714])
    """
    array = statistics("nis_values", nis_values)
    _check.fraction("factor", factor)
    dof = degrees(dof, array.shape)
    faded = [_faded(values, f) for values, f in ((array, factor), (dof, factor), (dof, factor**2))]
    return mean_test(faded[0], faded[1], 2 * faded[2], confidence)


def _faded(values: Floats, factor: float) -> Floats:
    faded = np.array(values)
    for k in range(1, values.shape[-1]):
        faded[..., k] += factor * faded[..., k - 1]
    return faded


def normalized_mean_error(
    errors: Any, covariances: Any, *, confidence: float = 0.95
) -> NormalizedMeanError:
    """Mean error of each state over independent runs, in claimed standard deviations (NMEE).

        nmee_j = (1 / N) sum_i e_ij / sqrt(P_i,jj)  ~  N(0, 1 / N)

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs: errors = estimate - truth.
    covariances : array_like of shape (N, ..., d, d), or (d, d) for all
        Their claimed covariances.
    confidence : float
        Probability that an unbiased state passes, each by itself.

    Returns
    -------
    NormalizedMeanError
        Of shape (..., d): 0 is unbiased.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`, and where there are no runs.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> test = normalized_mean_error([[1.0, 3.0], [-1.0, 3.0]], [[1.0, 0.0], [0.0, 4.0]])
    >>> test.value, test.is_consistent
    (array([0. , 1.5]), array([ True, False]))
    """
    e, p = errors_of_runs(errors, covariances)
    _check.fraction("confidence", confidence)
    special = _distributions.special()
    value = (e / np.sqrt(np.diagonal(p, axis1=-2, axis2=-1))).mean(0)
    bound = special.ndtri((1 + confidence) / 2) / np.sqrt(len(e))
    p_value = 2 * special.ndtr(-np.abs(value) * np.sqrt(len(e)))
    return NormalizedMeanError(value, bound, p_value, np.abs(value) <= bound)


@_deprecated.parameters(df="dof")
def covariance_scale(
    values: Any,
    dof: Any,
    *,
    axis: int | None = None,
    correlation_time: float = 1.0,
    confidence: float = 0.95,
) -> CovarianceScale:
    """The number that claimed covariances should be multiplied by, with its interval.

        scale = N / M    in    [N / chi2.ppf((1 + c) / 2, M), N / chi2.ppf((1 - c) / 2, M)]

    where N is the sum of the values and M that of their degrees of freedom.

    Parameters
    ----------
    values : array_like
        Independent NEES values (for P), or NIS values (for S).
    dof : float or array_like of the same shape
        Their degrees of freedom.
    axis : int, optional
        What to sum over; everything by default.
    correlation_time : float
        How many values count as one (see :func:`correlation_time`): widens the interval for NEES
        of consecutive times.
    confidence : float
        Of the interval.

    Returns
    -------
    CovarianceScale
        Above 1 the filter is optimistic, below pessimistic. ``str`` of it is the advice in words.

    Raises
    ------
    ValueError
        For values that are negative or not finite, none at all, ``dof`` not positive, or a
        correlation time below 1.

    Examples
    --------
    >>> import numpy as np
    >>> print(covariance_scale(2.8 * np.full(15, 4.0), dof=4))
    multiply P by 2.8 [2, 4.2]
    """
    array = statistics("values", values)
    _check.fraction("confidence", confidence)
    correlation_time = _check.number("correlation_time", correlation_time)
    if not correlation_time >= 1:
        raise errors.parameter("correlation_time", "at least 1", correlation_time)
    axis = None if axis is None else _check.axis_of(array, axis)
    total = array.sum(axis) / correlation_time
    dof = degrees(dof, array.shape).sum(axis) / correlation_time
    lower, upper = _distributions.chi2_interval(dof, confidence)
    return CovarianceScale(total / dof, total / upper, total / lower, dof)
