"""Do NEES and NIS follow their whole distribution, and what is a claim worth as a forecast?"""

from typing import Any

import numpy as np

from trackmetrics import _check, _deprecated, _distributions
from trackmetrics._check import Floats
from trackmetrics.consistency._input import degrees, nees_check, statistics
from trackmetrics.consistency.results import Coverage, UniformityTest


@_deprecated.parameters(df="dof")
def coverage(
    values: Any, dof: Any, probability: Any = 0.95, *, confidence: float = 0.95
) -> Coverage:
    """Share of independent errors inside their credibility region, with its exact interval.

    An error is inside the region of probability p where its NEES is at most ``chi2.ppf(p, dof)``.

    Parameters
    ----------
    values : array_like
        NEES of independent runs, or NIS of one, of any shape.
    dof : float or array_like of the same shape
        Degrees of freedom of each value.
    probability : float or array_like
        Nominal probability of the region, between 0 and 1.
    confidence : float
        Of the Clopper-Pearson interval.

    Returns
    -------
    Coverage
        Of the shape of ``probability``. Less than nominal is optimistic, more pessimistic.

    Raises
    ------
    ValueError
        For values that are negative or not finite, none at all, or numbers out of range.

    References
    ----------
    Clopper and Pearson, "The use of confidence or fiducial limits illustrated in the case of the
    binomial", Biometrika 26(4), 1934, doi:10.1093/biomet/26.4.404. Ivanov, Ali-Loytty and Piche,
    "Evaluating the consistency of estimation", ICL-GNSS 2014, doi:10.1109/ICL-GNSS.2014.6934171.

    Examples
    --------
    >>> test = coverage([0.5, 1.0, 2.0, 7.0], dof=2)
    >>> test.share, round(test.lower, 3), round(test.upper, 3), test.is_consistent
    (0.75, 0.194, 0.994, True)
    """
    _check.fraction("confidence", confidence)
    array = statistics("values", values)
    dof = degrees(dof, array.shape)
    nominal = _check.floats("probability", probability)
    if not ((nominal > 0) & (nominal < 1)).all():
        raise ValueError("probability must be between 0 and 1, both excluded")
    # One region after the other: what is compared is the value, so that its edge is inside.
    regions = [(array <= _distributions.chi2_quantile(p, dof)).sum() for p in nominal.ravel()]
    inside = np.array(regions, dtype=np.int64).reshape(nominal.shape)
    lower, upper = _distributions.clopper_pearson(inside, array.size, confidence)
    fair = (lower <= nominal) & (nominal <= upper)
    return Coverage(nominal, inside / array.size, lower, upper, inside, array.size, fair)


@_deprecated.parameters(df="dof")
def coverage_curve(
    values: Any, dof: Any, probabilities: Any = None, *, confidence: float = 0.95
) -> Coverage:
    """The coverage of every region: observed fraction against nominal probability.

    Parameters
    ----------
    values, dof, confidence
        As in :func:`coverage`.
    probabilities : array_like, optional
        Nominal probabilities of the regions; 0.01, 0.02, ... 0.99 by default.

    Returns
    -------
    Coverage
        Arrays; the shares of a consistent filter lie on the diagonal.

    Raises
    ------
    ValueError
        As :func:`coverage`.

    Examples
    --------
    >>> import numpy as np
    >>> coverage_curve(np.arange(1.0, 9.0), 4, [0.25, 0.5, 0.75]).share
    array([0.125, 0.375, 0.625])
    """
    nominal = np.arange(1, 100) / 100 if probabilities is None else probabilities
    return coverage(values, dof, np.atleast_1d(nominal), confidence=confidence)


@_deprecated.parameters(df="dof")
def pit_test(values: Any, dof: Any, *, confidence: float = 0.95) -> UniformityTest:
    """Probability integral transform: are NEES or NIS values spread as their chi-square is?

        u = F(value; dof)  ~  uniform on [0, 1]

    tested by the largest gap between the two distribution functions (Kolmogorov-Smirnov) and by
    the mean squared one (Cramer-von Mises).

    Parameters
    ----------
    values : array_like
        NEES of independent runs, or NIS of one, of any shape.
    dof : float or array_like of the same shape
        Degrees of freedom of each value.
    confidence : float
        Probability that a consistent filter passes, in each test.

    Returns
    -------
    UniformityTest
        The probabilities u and both tests.

    Raises
    ------
    ValueError
        As :func:`coverage`.

    Notes
    -----
    On the NEES of one run both reject consistent filters too often (14 % at a nominal 5 %), since
    it is correlated. P-values are those of many values with Stephens's corrections for few, good to
    a hundredth from five values on.

    References
    ----------
    Stephens, "EDF statistics for goodness of fit and some comparisons", J. American Statistical
    Association 69, 1974, doi:10.1080/01621459.1974.10480196.

    Examples
    --------
    >>> import numpy as np
    >>> test = pit_test(-2 * np.log(np.arange(0.5, 20) / 20), dof=2)
    >>> round(test.ks_statistic, 3), test.is_consistent
    (0.025, True)
    """
    _check.fraction("confidence", confidence)
    array = statistics("values", values)
    u = _distributions.chi2_cdf(array, degrees(dof, array.shape))
    count, ranked = array.size, np.sort(u, axis=None)
    steps = np.arange(count + 1) / count
    gap = max((steps[1:] - ranked).max(), (ranked - steps[:-1]).max())
    root = np.sqrt(count)
    ks_p = _distributions.special().kolmogorov((root + 0.12 + 0.11 / root) * gap)
    square = 1 / (12 * count) + ((ranked - (steps[1:] + steps[:-1]) / 2) ** 2).sum()
    cvm_p = _cramer_von_mises_sf((square - 0.4 / count + 0.6 / count**2) * (1 + 1 / count))
    fair = min(ks_p, cvm_p) >= 1 - confidence
    return UniformityTest(u, gap, ks_p, square, cvm_p, fair)


def _cramer_von_mises_sf(square: float) -> float:
    """How often the limiting statistic is larger (Csorgo and Faraway 1996, equation 1.2)."""
    if square <= 0.01:
        return 1.0
    special = _distributions.special()
    k = np.arange(20)
    y = (4 * k + 1) ** 2 / (16 * square)
    weights = special.poch(0.5, k) / special.factorial(k) * np.sqrt(4 * k + 1)
    # kve holds exp(y) K(y): two factors exp(-y) are left.
    terms = weights * np.exp(-2 * y) * special.kve(0.25, y)
    return float(np.clip(1 - terms.sum() / (np.pi * np.sqrt(square)), 0.0, 1.0))


@_deprecated.parameters(df="dof")
def excess_nll(nees_values: Any, dof: Any) -> Floats:
    """Negative log likelihood of the truth, over what a consistent filter expects of it.

        excess = (nees - d) / 2

    which is the negative log likelihood ``(nees + ln |2 pi P|) / 2`` less its expectation.

    Parameters
    ----------
    nees_values : array_like
        NEES values.
    dof : float or array_like of the same shape
        Number of states.

    Returns
    -------
    ndarray
        In nats; 0 on average where the filter is consistent, above where it is optimistic.

    Raises
    ------
    ValueError
        As :func:`coverage`.

    Examples
    --------
    >>> excess_nll([2.0, 6.0], dof=4)
    array([-1.,  1.])
    """
    array = statistics("nees_values", nees_values)
    return (array - degrees(dof, array.shape)) / 2


def gaussian_crps(errors: Any, covariances: Any) -> Floats:
    """Continuous ranked probability score of each state's Gaussian forecast.

        crps = s ( z (2 Phi(z) - 1) + 2 phi(z) - 1 / sqrt(pi) )    with    s^2 = P_jj, z = e_j / s

    Parameters
    ----------
    errors : array_like of shape (..., d)
        Errors.
    covariances : array_like of shape (..., d, d), or (d, d) for all
        Their claimed covariances.

    Returns
    -------
    ndarray of shape (..., d)
        In the units of the states, at least 0, less is better: small errors and consistent
        covariances both help. A consistent Gaussian filter expects ``s / sqrt(pi)``.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`.

    References
    ----------
    Gneiting and Raftery, "Strictly proper scoring rules, prediction, and estimation", J. American
    Statistical Association 102, 2007, doi:10.1198/016214506000001437.

    Examples
    --------
    >>> gaussian_crps([0.0, 2.0], [[1.0, 0.0], [0.0, 4.0]]).round(4)
    array([0.2337, 1.2049])
    """
    e, p, _ = _check.states(("covariances", covariances), ("errors", errors))
    nees_check(e, p, "errors", "covariances")
    special = _distributions.special()
    s = np.sqrt(np.diagonal(p, axis1=-2, axis2=-1))
    z = e / s
    density = np.exp(-z * z / 2) / np.sqrt(2 * np.pi)
    scores: Floats = s * (z * (2 * special.ndtr(z) - 1) + 2 * density - 1 / np.sqrt(np.pi))
    return scores
