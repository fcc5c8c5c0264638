"""The chi-square and related laws, on whole arrays, through SciPy's special functions."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def upper_tail(values: Any, dof: Any) -> Floats:
    """Chance that a chi-square value is larger."""
    from scipy import special

    tail: Floats = special.chdtrc(dof, values)
    return tail


def lower_tail(values: Any, dof: Any) -> Floats:
    """Chance that a chi-square value is smaller."""
    from scipy import special

    tail: Floats = special.chdtr(dof, values)
    return tail


def quantile(chance: Any, dof: Any) -> Floats:
    """The value below which a chi-square value is with this chance."""
    from scipy import special

    value: Floats = 2.0 * special.gammaincinv(np.asarray(dof) / 2.0, chance)
    return value


def two_sided(values: Any, dof: Any) -> Floats:
    """Twice the smaller tail, at most 1."""
    return np.minimum(1.0, 2.0 * np.minimum(upper_tail(values, dof), lower_tail(values, dof)))


def ratio_tail(ratio: Any, dof: Any, other: Any) -> Floats:
    """Chance that an F value is larger."""
    from scipy import special

    tail: Floats = special.fdtrc(dof, other, ratio)
    return tail


def normal_two_sided(z: Any) -> Floats:
    """Chance that a normal value is further from 0."""
    from scipy import special

    tail: Floats = 2.0 * special.ndtr(-np.abs(z))
    return tail


def student_two_sided(t: Any, dof: Any) -> Floats:
    """Chance that a Student value is further from 0."""
    from scipy import special

    tail: Floats = 2.0 * special.stdtr(dof, -np.abs(t))
    return tail


def normal_scores(values: Floats, dof: Floats) -> Floats:
    """Standard normal values at the same chance as these chi-square values."""
    from scipy import special

    scores: Floats = special.ndtri(np.clip(lower_tail(values, dof), 1e-12, 1.0 - 1e-12))
    return scores


def holm(p_values: Floats) -> Floats:
    """P-values corrected for how many there are (Holm 1979)."""
    order = np.argsort(p_values, kind="stable")
    stepped = p_values[order] * np.arange(len(p_values), 0, -1)
    corrected = np.empty_like(p_values)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(stepped))
    return corrected
