"""Quantiles and tail probabilities of the chi-square, F, normal, t and Pearson III distributions.

SciPy's special functions, not its distribution objects: those cost forty times as much per call.
SciPy is imported where it is first needed.
"""

from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@cache
def special() -> ModuleType:
    """``scipy.special``."""
    import scipy.special

    module: ModuleType = scipy.special
    return module


def chi2_quantile(probability: Any, dof: Any) -> Any:
    """Quantile of the chi-square distribution."""
    return 2 * special().gammaincinv(0.5 * dof, probability)


def chi2_isf(probability: Any, dof: Any) -> Any:
    """Upper quantile of the chi-square distribution; keeps its digits for small probabilities."""
    return 2 * special().gammainccinv(0.5 * dof, probability)


def chi2_cdf(value: Any, dof: Any) -> Any:
    """Lower tail probability of the chi-square distribution."""
    return special().gammainc(0.5 * dof, 0.5 * value)


def chi2_sf(value: Any, dof: Any) -> Any:
    """Upper tail probability of the chi-square distribution."""
    return special().gammaincc(0.5 * dof, 0.5 * value)


def chi2_interval(dof: Any, confidence: float) -> tuple[Any, Any]:
    """The central interval that holds a chi-square with probability ``confidence``."""
    tail = 0.5 * (1 - confidence)
    return chi2_quantile(tail, dof), chi2_isf(tail, dof)


def chi2_p_value(value: Any, dof: Any) -> Any:
    """Two-sided p-value of a chi-square value."""
    return np.minimum(1.0, 2 * np.minimum(chi2_cdf(value, dof), chi2_sf(value, dof)))


def f_sf(ratio: Any, dof: Any, other: Any) -> Floats:
    """Upper tail probability of the F distribution."""
    tail: Floats = special().fdtrc(dof, other, ratio)
    return tail


def normal_p_value(z: Any) -> Floats:
    """Two-sided p-value of a standard normal value."""
    tail: Floats = 2.0 * special().ndtr(-np.abs(z))
    return tail


def t_p_value(t: Any, dof: Any) -> Floats:
    """Two-sided p-value of a t value."""
    tail: Floats = 2.0 * special().stdtr(dof, -np.abs(t))
    return tail


def chi2_to_z(values: Floats, dof: Floats) -> Floats:
    """Standard normal values with the same lower tail probability as these chi-square values."""
    scores: Floats = special().ndtri(np.clip(chi2_cdf(values, dof), 1e-12, 1.0 - 1e-12))
    return scores


def wilson_hilferty_z(ratios: Floats, dof: Floats) -> Floats:
    """Nearly standard normal values from chi-square values over their degrees of freedom.

    The cube root of Wilson and Hilferty (1931), doi:10.1073/pnas.17.12.684: a fifth of the cost of
    exact scores, where only their correlation is asked for.
    """
    spread = 2.0 / (9.0 * dof)
    scores: Floats = (np.cbrt(ratios) - (1.0 - spread)) / np.sqrt(spread)
    return scores


def pearson3_to_z(value: float, skewness: float) -> float:
    """Standard normal value with the tail probability of a Pearson III value of unit variance.

    By the chi-square of that skewness, moved and scaled (Pearson's type III); 0 is the normal.
    """
    if skewness <= 0:
        return value
    dof = 8 / skewness**2
    moved = max(0.0, dof + value * (2 * dof) ** 0.5)
    # Of either side the tail, so that far values keep their digits.
    if moved > dof:
        return -float(special().ndtri(max(chi2_sf(moved, dof), 1e-300)))
    return float(special().ndtri(max(chi2_cdf(moved, dof), 1e-300)))


def holm(p_values: Floats) -> Floats:
    """P-values corrected for how many there are (Holm 1979)."""
    order = np.argsort(p_values, kind="stable")
    stepped = p_values[order] * np.arange(len(p_values), 0, -1)
    corrected = np.empty_like(p_values)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(stepped))
    return corrected


def normal_quantile(probability: Any) -> Any:
    """The value that a standard normal variable stays below with this probability."""
    return special().ndtri(probability)


def clopper_pearson(hits: Any, trials: Any, confidence: float) -> tuple[Floats, Floats]:
    """Exact interval of a probability from ``hits`` out of ``trials``; NaN without trials."""
    k, n = np.asarray(hits, np.float64), np.asarray(trials, np.float64)
    tail = (1 - confidence) / 2
    lower = np.where(k > 0, special().betaincinv(np.maximum(k, 1), n - k + 1, tail), 0.0)
    upper = np.where(k < n, special().betaincinv(k + 1, np.maximum(n - k, 1), 1 - tail), 1.0)
    none = n == 0
    return np.where(none, np.nan, lower), np.where(none, np.nan, upper)


DECIBELS = 10.0 / np.log(10.0)
"""Decibels per natural logarithm."""


def chi2_log_mean(dof: Any) -> Any:
    """Mean of the natural logarithm of a chi-square variable: ``ln 2 + digamma(dof / 2)``."""
    return np.log(2.0) + special().digamma(dof / 2)
