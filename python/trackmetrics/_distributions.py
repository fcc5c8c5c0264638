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
    """The value that a chi-square of ``dof`` degrees of freedom stays below so often."""
    return 2 * special().gammaincinv(0.5 * dof, probability)


def chi2_isf(probability: Any, dof: Any) -> Any:
    """The value that a chi-square exceeds so often; keeps its digits for small probabilities."""
    return 2 * special().gammainccinv(0.5 * dof, probability)


def chi2_cdf(value: Any, dof: Any) -> Any:
    """How often a chi-square stays below ``value``."""
    return special().gammainc(0.5 * dof, 0.5 * value)


def chi2_sf(value: Any, dof: Any) -> Any:
    """How often a chi-square exceeds ``value``."""
    return special().gammaincc(0.5 * dof, 0.5 * value)


def chi2_interval(dof: Any, confidence: float) -> tuple[Any, Any]:
    """The central interval that holds a chi-square with probability ``confidence``."""
    tail = 0.5 * (1 - confidence)
    return chi2_quantile(tail, dof), chi2_isf(tail, dof)


def chi2_p_value(value: Any, dof: Any) -> Any:
    """Two-sided: how often a chi-square is as far out, on either side."""
    return np.minimum(1.0, 2 * np.minimum(chi2_cdf(value, dof), chi2_sf(value, dof)))


def f_sf(ratio: Any, dof: Any, other: Any) -> Floats:
    """Chance that an F value is larger."""
    tail: Floats = special().fdtrc(dof, other, ratio)
    return tail


def normal_p_value(z: Any) -> Floats:
    """Chance that a normal value is further from 0."""
    tail: Floats = 2.0 * special().ndtr(-np.abs(z))
    return tail


def t_p_value(t: Any, dof: Any) -> Floats:
    """Chance that a Student value is further from 0."""
    tail: Floats = 2.0 * special().stdtr(dof, -np.abs(t))
    return tail


def chi2_to_z(values: Floats, dof: Floats) -> Floats:
    """Standard normal values at the same chance as these chi-square values."""
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
    """Standard normal value at the same chance as this one, of mean 0, variance 1 and a skewness.

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
