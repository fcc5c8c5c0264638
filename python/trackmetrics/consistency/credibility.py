"""Does the claimed covariance match the errors of many runs, in size, shape and mean?"""

from typing import Any

import numpy as np

from trackmetrics import _check, _distributions
from trackmetrics._check import Floats
from trackmetrics._covariances import decorrelated
from trackmetrics.consistency._input import components, errors_of_runs, nees_check
from trackmetrics.consistency.results import CredibilityIndex, SignificanceTest


def noncredibility_index(
    errors: Any, covariances: Any, *, reference: str = "sample"
) -> CredibilityIndex:
    """Noncredibility index (NCI): by how many decibels claims and errors disagree, either way.

        nci = (10 / N) sum_i |log10 rho_i|    with    rho_i = e_i' P_i^-1 e_i / e_i' Sigma^-1 e_i

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs.
    covariances : array_like of shape (N, ..., d, d), or (d, d) for all
        Their claimed covariances.
    reference : "sample" or "expected"
        Sigma: the mean square error of these runs, or, in its place, the logarithm that a
        consistent filter's NEES has on average.

    Returns
    -------
    CredibilityIndex
        At least 0 dB; 0 is best. A consistent filter has more than 0 (0.7 dB for 50 runs of 4
        states with ``"sample"``), so there are no bounds.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`; with ``"sample"`` where there are fewer runs than states.

    References
    ----------
    Li, Zhao and Jilkov, "Practical measures and test for credibility of an estimator", 2001;
    Li and Zhao, "Measuring estimator's credibility: noncredibility index", FUSION 2006,
    doi:10.1109/ICIF.2006.301770.

    Examples
    --------
    >>> errors = [[2.0], [-2.0], [1.0], [-1.0]]
    >>> round(noncredibility_index(errors, [[1.0]]).value, 3)  # 10 log10 of the variance, 2.5
    3.979
    """
    logs = _log_ratios(errors, covariances, reference)
    return CredibilityIndex(np.abs(logs).mean(0), np.nan, np.nan, np.nan)


def inclination_index(
    errors: Any, covariances: Any, *, reference: str = "expected", confidence: float = 0.95
) -> CredibilityIndex:
    """Inclination index: by how many decibels a filter is optimistic (above 0) or pessimistic.

        inclination = (10 / N) sum_i log10 rho_i

    with rho_i as in :func:`noncredibility_index`.

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs.
    covariances : array_like of shape (N, ..., d, d), or (d, d) for all
        Their claimed covariances.
    reference : "expected" or "sample"
        What the claimed covariance is compared with.
    confidence : float
        Probability that a consistent filter is within the bounds.

    Returns
    -------
    CredibilityIndex
        In dB, 0 is consistent. With ``"expected"`` the bounds are ``+-1.96 sd / sqrt(N)``, where
        sd is
        the standard deviation of 10 log10 of a chi-square of d; with ``"sample"`` they are NaN.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`noncredibility_index`.

    References
    ----------
    Li and Zhao, "Measuring estimator's credibility: noncredibility index", FUSION 2006,
    doi:10.1109/ICIF.2006.301770.

    Examples
    --------
    >>> errors = [[2.0], [-2.0], [1.0], [-1.0]]
    >>> round(inclination_index(errors, [[1.0]], reference="sample").value, 3)
    3.979
    """
    _check.fraction("confidence", confidence)
    logs = _log_ratios(errors, covariances, reference)
    value, d = logs.mean(0), components(errors)
    if reference == "sample":
        return CredibilityIndex(value, np.nan, np.nan, np.nan)
    special = _distributions.special()
    deviation = _distributions.DECIBELS * np.sqrt(special.polygamma(1, d / 2) / len(logs))
    bound = _distributions.normal_quantile((1 + confidence) / 2) * deviation
    p_value = _distributions.normal_p_value(value / deviation)
    return CredibilityIndex(value, -bound, bound, p_value)


def _log_ratios(errors: Any, covariances: Any, reference: str) -> Floats:
    """10 log10 rho of every run."""
    if reference not in ("sample", "expected"):
        raise ValueError(f"reference must be 'sample' or 'expected', got {reference!r}")
    e, p = errors_of_runs(errors, covariances, runs=components(errors))
    claimed = nees_check(e, p, "errors", "covariances")
    d = e.shape[-1]
    if reference == "sample":
        # An error of exactly zero agrees with any covariance.
        with np.errstate(invalid="ignore"):
            ratio = claimed / _forms_by_step(e, _mean_square(e))
        agreed: Floats = _distributions.DECIBELS * np.log(np.where(np.isfinite(ratio), ratio, 1.0))
        return agreed
    expected = _distributions.chi2_log_mean(d)
    with np.errstate(divide="ignore"):
        logs: Floats = _distributions.DECIBELS * (np.log(claimed) - expected)
    return logs


def _forms_by_step(e: Floats, square: Floats) -> Floats:
    """The forms of all runs in the mean square error of their step, each step by itself."""
    d = e.shape[-1]
    steps = zip(e.reshape(len(e), -1, d).swapaxes(0, 1), square.reshape(-1, d, d), strict=True)
    forms = [nees_check(own, matrix, "errors", "the mean square error") for own, matrix in steps]
    return np.stack(forms, axis=1).reshape(e.shape[:-1])


def _mean_square(e: Floats) -> Floats:
    square: Floats = np.einsum("n...i,n...j->...ij", e, e) / len(e)
    return square


def covariance_test(errors: Any, covariances: Any, *, confidence: float = 0.95) -> SignificanceTest:
    """Likelihood ratio test that errors have their claimed covariance, in size and in shape.

        lambda = c N ( tr W - ln |W| - d )  ~  chi2(d (d + 1) / 2)

    with W the mean square of the whitened errors ``L^-1 e``, and the small-sample factor
    ``c = 1 - (2 d^2 + 3 d - 1) / (6 N (d + 1))``.

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs, more than d, with mean zero (see :func:`bias_test`).
    covariances : array_like of shape (N, ..., d, d), or (d, d) for all
        Their claimed covariances.
    confidence : float
        Probability that a consistent filter passes.

    Returns
    -------
    SignificanceTest
        A small p-value says that size or shape is wrong.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`, and where there are too few runs.

    References
    ----------
    Li and Zhao, "Testing estimator's credibility - part I: tests for MSE", FUSION 2006. The factor:
    Bartlett, "A note on the multiplying factors for various chi2 approximations", J. Royal
    Statistical Society B 16(2), 1954, doi:10.1111/j.2517-6161.1954.tb00174.x.

    Examples
    --------
    >>> import numpy as np
    >>> errors = np.random.default_rng(1).standard_normal((50, 3))
    >>> covariance_test(errors, np.eye(3)).is_consistent
    True
    >>> covariance_test(errors, 4 * np.eye(3)).is_consistent
    False
    """
    _check.fraction("confidence", confidence)
    e, p = errors_of_runs(errors, covariances, runs=components(errors) + 1)
    count, d = len(e), e.shape[-1]
    w = _mean_square(decorrelated(e, p))
    factor = 1 - (2 * d * d + 3 * d - 1) / (6 * count * (d + 1))
    logarithm = np.linalg.slogdet(w)[1]
    statistic = factor * count * np.maximum(0.0, np.trace(w, axis1=-2, axis2=-1) - logarithm - d)
    return _significance(statistic, d * (d + 1) // 2, confidence)


def bias_test(errors: Any, covariances: Any, *, confidence: float = 0.95) -> SignificanceTest:
    """Test that errors have mean zero, by their claimed covariances.

        N u' u  ~  chi2(d)    with    u the mean of the whitened errors L^-1 e

    which is ``N e' P^-1 e`` of the mean error e for one common covariance.

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs.
    covariances : array_like of shape (N, ..., d, d), or (d, d) for all
        Their claimed covariances.
    confidence : float
        Probability that an unbiased filter passes.

    Returns
    -------
    SignificanceTest
        A small p-value says biased, or that the covariances are too small: see
        :func:`hotelling_test`.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`, and where there are no runs.

    Examples
    --------
    >>> test = bias_test([[1.0, 0.0], [3.0, 0.0]], [[4.0, 0.0], [0.0, 1.0]])
    >>> test.statistic, test.dof
    (2.0, 2)
    """
    _check.fraction("confidence", confidence)
    e, p = errors_of_runs(errors, covariances)
    mean = decorrelated(e, p).mean(0)
    statistic = ((len(e) * mean)[..., None, :] @ mean[..., :, None])[..., 0, 0]
    return _significance(statistic, e.shape[-1], confidence)


def hotelling_test(errors: Any, *, confidence: float = 0.95) -> SignificanceTest:
    """Hotelling's test that errors have mean zero, whatever their covariance.

        (N - d) / (d (N - 1)) T^2  ~  F(d, N - d)    with    T^2 = N e' C^-1 e

    with e the mean error and C the sample covariance.

    Parameters
    ----------
    errors : array_like of shape (N, ..., d)
        Errors of N independent runs, more than d.
    confidence : float
        Probability that an unbiased filter passes.

    Returns
    -------
    SignificanceTest
        ``statistic`` is the F value, ``dof`` that of its numerator.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        Where errors are not finite, there are too few runs, or the errors do not span the state.

    References
    ----------
    Hotelling, "The generalization of Student's ratio", Annals of Mathematical Statistics 2(3),
    1931, doi:10.1214/aoms/1177732979.

    Examples
    --------
    >>> test = hotelling_test([[1.0], [2.0], [3.0]])  # the square of Student's t
    >>> round(test.statistic, 6), round(test.p_value, 4)
    (12.0, 0.0742)
    """
    _check.fraction("confidence", confidence)
    d = components(errors)
    e, _ = errors_of_runs(errors, np.eye(d), runs=d + 1)
    count = len(e)
    centred = np.moveaxis(e - e.mean(0), 0, -1)
    sample = centred @ centred.swapaxes(-1, -2) * (1 / (count - 1))
    form = nees_check(e.mean(0), sample, "errors", "the sample covariance")
    statistic = count * form * (count - d) / (d * (count - 1))
    p_value = _distributions.special().fdtrc(d, count - d, statistic)
    return SignificanceTest(statistic, d, p_value, p_value >= 1 - confidence)


def _significance(statistic: Any, dof: int, confidence: float) -> SignificanceTest:
    p_value = _distributions.chi2_sf(statistic, dof)
    return SignificanceTest(statistic, dof, p_value, p_value >= 1 - confidence)
