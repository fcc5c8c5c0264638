"""Quantiles and tails of the distributions that consistency is judged by.

SciPy's special functions, not its distribution objects: those cost forty times as much a call.
SciPy is imported where it is first needed.
"""

from functools import cache
from types import ModuleType
from typing import Any


@cache
def special() -> ModuleType:
    """``scipy.special``."""
    import scipy.special

    module: ModuleType = scipy.special
    return module


def quantile(probability: Any, dof: Any) -> Any:
    """The value that a chi-square of ``dof`` degrees of freedom stays below so often."""
    return 2 * special().gammaincinv(0.5 * dof, probability)


def upper_quantile(probability: Any, dof: Any) -> Any:
    """The value that a chi-square exceeds so often; keeps its digits for small probabilities."""
    return 2 * special().gammainccinv(0.5 * dof, probability)


def cdf(value: Any, dof: Any) -> Any:
    """How often a chi-square stays below ``value``."""
    return special().gammainc(0.5 * dof, 0.5 * value)


def sf(value: Any, dof: Any) -> Any:
    """How often a chi-square exceeds ``value``."""
    return special().gammaincc(0.5 * dof, 0.5 * value)


def interval(dof: Any, confidence: float) -> tuple[Any, Any]:
    """The central interval that holds a chi-square with probability ``confidence``."""
    tail = 0.5 * (1 - confidence)
    return quantile(tail, dof), upper_quantile(tail, dof)


def p_value(value: Any, dof: Any) -> Any:
    """Two-sided: how often a chi-square is as far out, on either side."""
    import numpy as np

    return np.minimum(1.0, 2 * np.minimum(cdf(value, dof), sf(value, dof)))
