"""Whether innovations are white: correlation of innovations over time and across runs."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics import _check, _distributions, errors
from trackmetrics._check import Floats
from trackmetrics._covariances import decorrelated
from trackmetrics.consistency._input import nees_check
from trackmetrics.consistency.results import WhitenessTest


def whiteness(
    innovations: Any,
    innovation_covariances: Any,
    *,
    lags: int | None = None,
    confidence: float = 0.95,
) -> WhitenessTest:
    """Is each innovation of a run independent of the earlier ones?

    Innovations are whitened by their own covariance, ``u = L^-1 v`` with ``S = L L'``; then

        rho(l) = sum_k u_k' u_(k+l) / sqrt( sum_k |u_k|^2 sum_k |u_(k+l)|^2 )  ~  N(0, 1 / n_l)

    with n_l pairs of components, and ``sum_l n_l rho(l)^2`` is a chi-square of as many degrees of
    freedom as there are lags: Ljung and Box's statistic, with the variance of each lag.

    Parameters
    ----------
    innovations : array_like of shape (..., K, m), or sequence of K vectors
        Innovations of consecutive updates; leading axes are tested one by one. Where measurement
        types are mixed, vectors may have different lengths: the leading components that two have
        in common are compared.
    innovation_covariances : array_like of shape (..., K, m, m), or sequence of K matrices
        Their covariances; ``(m, m)`` for all.
    lags : int, optional
        The longest lag; min(10, K / 5) and at least 1 by default.
    confidence : float
        Probability that white innovations pass.

    Returns
    -------
    WhitenessTest
        The correlation at each lag in [-1, 1], 0 is white, and the test of all of them.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nis`, and where there are fewer updates than ``lags + 2``.

    Notes
    -----
    Positive correlation with a NIS too large points to too little process noise or a manoeuvre,
    negative to too little measurement noise; with a NIS too small it is the other way round.
    A wrong scale of S does not matter.

    References
    ----------
    Ljung and Box, "On a measure of lack of fit in time series models", Biometrika 65(2), 1978,
    doi:10.1093/biomet/65.2.297.

    Examples
    --------
    >>> innovations = [[1.0], [1.0], [-1.0], [-1.0], [1.0], [1.0], [-1.0], [-1.0]]
    >>> test = whiteness(innovations, [[[1.0]]] * 8)
    >>> test.lags, test.correlation
    (array([1]), array([0.14285714]))
    """
    _check.fraction("confidence", confidence)
    u = _whitened_run(innovations, innovation_covariances)
    longest = _longest_lag(lags, u.shape[-2])
    numbers = np.arange(1, longest + 1)
    rows = [_lagged(u[..., :-lag, :], u[..., lag:, :]) for lag in numbers]
    correlation, pairs = (np.stack(column, axis=-1) for column in zip(*rows, strict=True))
    bound = _distributions.normal_quantile((1 + confidence) / 2) / np.sqrt(pairs)
    statistic = (pairs * correlation**2).sum(-1)
    p_value = _distributions.chi2_sf(statistic, longest)
    white = p_value >= 1 - confidence
    return WhitenessTest(numbers, correlation, bound, statistic, longest, p_value, white)


def _longest_lag(lags: int | None, count: int) -> int:
    longest = max(1, min(10, count // 5)) if lags is None else _check.whole("lags", lags)
    if longest < 1:
        raise errors.parameter("lags", "at least 1", longest)
    if count < longest + 2:
        raise ValueError(f"innovations has {count} updates, at least {longest + 2} are needed")
    return longest


def _whitened_run(innovations: Any, covariances: Any) -> Floats:
    """Whitened innovations, NaN where an update has fewer components than others."""
    innovations, covariances = _check.opened(innovations), _check.opened(covariances)
    if _is_mixed(innovations):
        return _whitened_mixed(innovations, covariances)
    v, s, _ = _check.states(("innovation_covariances", covariances), ("innovations", innovations))
    if v.ndim < 2:
        raise errors.shape("innovations", v.shape, "(..., K, m)")
    nees_check(v, s, "innovations", "innovation_covariances")
    return decorrelated(v, s)


def _is_mixed(innovations: Any) -> bool:
    """Whether vectors have different lengths."""
    if isinstance(innovations, np.ndarray) and innovations.dtype != object:
        return False
    if not isinstance(innovations, Sequence):
        return False
    shapes = {np.shape(_check.floats(f"innovations[{k}]", v)) for k, v in enumerate(innovations)}
    return len(shapes) > 1


def _whitened_mixed(innovations: Any, covariances: Any) -> Floats:
    if len(innovations) != len(covariances):
        raise errors.length(
            "innovation_covariances", len(covariances), "innovations", len(innovations), "updates"
        )
    u = np.full((len(innovations), max(map(np.size, innovations))), np.nan)
    for k, (row, v, s) in enumerate(zip(u, innovations, covariances, strict=True)):
        v = np.atleast_1d(_check.floats(f"innovations[{k}]", v))
        s = np.atleast_2d(_check.floats(f"innovation_covariances[{k}]", s))
        nees_check(v, s, f"innovations[{k}]", f"innovation_covariances[{k}]")
        row[: v.size] = decorrelated(v, s)
    return u


def _lagged(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Correlation of two sequences of vectors, and the number of pairs it is made of."""
    both = np.isfinite(a) & np.isfinite(b)
    a, b = np.where(both, a, 0.0), np.where(both, b, 0.0)
    size = np.sqrt((a * a).sum((-1, -2)) * (b * b).sum((-1, -2)))
    correlation = (a * b).sum((-1, -2)) / np.where(size > 0, size, 1.0)
    return correlation, np.maximum(1.0, both.sum((-1, -2)))


def whiteness_across_runs(
    innovations: Any, innovation_covariances: Any, *, lag: int = 1, confidence: float = 0.95
) -> WhitenessTest:
    """Is each innovation independent of an earlier one, at every time, over independent runs?

        rho(k) = sum_i u_i(k)' u_i(k+lag) / sqrt( sum_i |u_i(k)|^2 sum_i |u_i(k+lag)|^2 )
               ~ N(0, 1 / (N m))

    Parameters
    ----------
    innovations : array_like of shape (N, K, m)
        Innovations of N independent runs.
    innovation_covariances : array_like of shape (N, K, m, m), or (m, m) for all
        Their covariances.
    lag : int
        How many updates later.
    confidence : float
        Probability that white innovations pass.

    Returns
    -------
    WhitenessTest
        One correlation for each of the K - lag times; ``statistic`` sums their squares over their
        variances.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nis`, and where the lag does not fit.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> import numpy as np
    >>> v = np.array([[[1.0], [1.0]], [[1.0], [-1.0]]])
    >>> whiteness_across_runs(v, [[1.0]]).correlation
    array([0.])
    """
    _check.fraction("confidence", confidence)
    v, s, _ = _check.states(
        ("innovation_covariances", innovation_covariances), ("innovations", innovations)
    )
    nees_check(v, s, "innovations", "innovation_covariances")
    if v.ndim != 3:
        raise errors.shape("innovations", v.shape, "(N, K, m)")
    runs, count, m = v.shape
    lag = _check.whole("lag", lag)
    if not 1 <= lag < count:
        raise errors.parameter("lag", f"between 1 and {count - 1}", lag)
    u = decorrelated(v, s)
    a, b = u[:, :-lag], u[:, lag:]
    size = np.sqrt((a * a).sum((0, 2)) * (b * b).sum((0, 2)))
    correlation = (a * b).sum((0, 2)) / np.where(size > 0, size, 1.0)
    bound = _distributions.normal_quantile((1 + confidence) / 2) / np.sqrt(runs * m)
    statistic = runs * m * (correlation**2).sum()
    p_value = _distributions.chi2_sf(statistic, count - lag)
    white = p_value >= 1 - confidence
    return WhitenessTest(lag, correlation, bound, statistic, count - lag, p_value, white)
