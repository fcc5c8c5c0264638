"""Tails of the F, normal and Student laws on whole arrays; corrected p-values."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._chi2 import cdf, sf, special

Floats = NDArray[np.float64]


def ratio_tail(ratio: Any, dof: Any, other: Any) -> Floats:
    """Chance that an F value is larger."""
    tail: Floats = special().fdtrc(dof, other, ratio)
    return tail


def normal_two_sided(z: Any) -> Floats:
    """Chance that a normal value is further from 0."""
    tail: Floats = 2.0 * special().ndtr(-np.abs(z))
    return tail


def student_two_sided(t: Any, dof: Any) -> Floats:
    """Chance that a Student value is further from 0."""
    tail: Floats = 2.0 * special().stdtr(dof, -np.abs(t))
    return tail


def normal_scores(values: Floats, dof: Floats) -> Floats:
    """Standard normal values at the same chance as these chi-square values."""
    scores: Floats = special().ndtri(np.clip(cdf(values, dof), 1e-12, 1.0 - 1e-12))
    return scores


def nearly_normal(ratios: Floats, dof: Floats) -> Floats:
    """Nearly standard normal values from chi-square values over their degrees of freedom.

    The cube root of Wilson and Hilferty (1931), doi:10.1073/pnas.17.12.684: a fifth of the cost of
    exact scores, where only their correlation is asked for.
    """
    spread = 2.0 / (9.0 * dof)
    scores: Floats = (np.cbrt(ratios) - (1.0 - spread)) / np.sqrt(spread)
    return scores


def normal_score_of_skewed(value: float, skewness: float) -> float:
    """Standard normal value at the same chance as this one, of mean 0, variance 1 and a skewness.

    By the chi-square of that skewness, moved and scaled (Pearson's type III); 0 is the normal.
    """
    if skewness <= 0:
        return value
    dof = 8 / skewness**2
    moved = max(0.0, dof + value * (2 * dof) ** 0.5)
    # Of either side the tail, so that far values keep their digits.
    if moved > dof:
        return -float(special().ndtri(max(sf(moved, dof), 1e-300)))
    return float(special().ndtri(max(cdf(moved, dof), 1e-300)))


def holm(p_values: Floats) -> Floats:
    """P-values corrected for how many there are (Holm 1979)."""
    order = np.argsort(p_values, kind="stable")
    stepped = p_values[order] * np.arange(len(p_values), 0, -1)
    corrected = np.empty_like(p_values)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(stepped))
    return corrected
