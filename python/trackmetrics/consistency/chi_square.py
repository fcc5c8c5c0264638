"""Chi-square tests of mean NEES and NIS, and the coverage of credibility regions."""

from typing import Any

from trackmetrics import _backend, _check, _distributions, errors
from trackmetrics._covariance_rule import SYMMETRY
from trackmetrics.errors import NotPlain
from trackmetrics.results import ConsistencyResult


def consistency_test(
    nees_or_nis_values: Any, df: float, confidence: float = 0.95
) -> ConsistencyResult:
    """Chi-square test of the mean of N independent NEES or NIS values.

        lower, upper = chi2.ppf((1 -+ confidence) / 2, N df) / N

    Parameters
    ----------
    nees_or_nis_values : array_like
        The values, of any shape; N is their number.
    df : float
        Degrees of freedom of one value: the number of states, or of measured components.
    confidence : float
        Probability that a consistent filter passes, between 0 and 1.

    Returns
    -------
    ConsistencyResult
        Whether the mean lies within the bounds (inclusive), the mean, and the bounds.

    Raises
    ------
    ValueError
        Where there are no values, one is negative or not finite, ``df`` is not positive, or
        ``confidence`` is not between 0 and 1.

    Notes
    -----
    The values must be independent. NIS values of one run are, if the filter is right. NEES values
    of one run are not: the test then rejects a consistent filter in 14-23 % of runs where 5 % are
    nominal. Test NEES across runs, at one time each.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> import numpy as np
    >>> result = consistency_test(np.random.default_rng(1).chisquare(4, size=100), df=4)
    >>> result.is_consistent, round(result.lower_bound, 3), round(result.upper_bound, 3)
    (True, 3.465, 4.573)
    """
    kernel = _backend.kernels.mean_statistic
    try:
        mean, count = kernel(nees_or_nis_values)
    except NotPlain:
        mean, count = kernel(_check.floats("nees_or_nis_values", nees_or_nis_values))
    df = _check.number("df", df)
    if not df > 0:
        raise errors.parameter("df", "positive", df)
    _check.fraction("confidence", confidence)
    tail = (1 - confidence) / 2
    lower = float(_distributions.chi2_quantile(tail, count * df)) / count
    upper = float(_distributions.chi2_quantile(1 - tail, count * df)) / count
    return ConsistencyResult(lower <= mean <= upper, mean, lower, upper, mean)


def credibility_interval(errors: Any, covariances: Any, interval: float = 0.95) -> float:
    """Share of errors that lie inside the credibility region of their covariance.

    The region of probability p is the ellipsoid ``e' P^-1 e <= chi2.ppf(p, d)``.

    Parameters
    ----------
    errors : array_like of shape (..., N, d)
        Errors, truth less estimate.
    covariances : array_like of shape (..., N, d, d), or (d, d) for all
        The covariances that the filter claims for them.
    interval : float
        The probability p of the region, between 0 and 1.

    Returns
    -------
    float
        In [0, 1], about ``interval`` where the filter is consistent; less is optimistic, more
        pessimistic. An error on the edge is inside.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As in :func:`nees`, and where there are no errors or ``interval`` is not between 0 and 1.

    Examples
    --------
    >>> credibility_interval([[0.1, 0.0], [0.0, 0.2], [3.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]], 0.5)
    0.6666666666666666
    """
    _check.fraction("interval", interval)
    kernel = _backend.kernels.credibility_interval
    e, p, symmetry = errors, covariances, SYMMETRY
    try:
        return float(kernel(e, p, _threshold(interval, e), symmetry))
    except NotPlain:
        e, p, symmetry = _check.states(("covariances", covariances), ("errors", errors))
        return float(kernel(e, p, _threshold(interval, e), symmetry))


def _threshold(interval: float, errors: Any) -> float:
    """The edge of the region, as a quadratic form."""
    shape = getattr(errors, "shape", None)
    return float(_distributions.chi2_quantile(interval, shape[-1])) if shape else 0.0
