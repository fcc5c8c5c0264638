"""What the statistics give back: a value, the acceptance interval, and how sure that is.

Fields are Python numbers for one sequence, and arrays where there are leading axes.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from trackmetrics.results import Result


def plain(value: Any) -> Any:
    """A Python number for an array without axes, the array otherwise."""
    array = np.asarray(value)
    return array if array.ndim else array.item()


@dataclass(frozen=True, eq=False)
class _Result(Result):
    """Frozen, with Python numbers instead of NumPy's."""

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))


@dataclass(frozen=True, eq=False)
class MeanTest(_Result):
    """A mean of NEES or NIS in units of its expectation, and its acceptance interval."""

    value: Any
    """The mean over its expectation: 1 if consistent; above 1 optimistic (covariance too small),
    below 1 pessimistic."""
    lower: Any
    """Lower bound of the acceptance interval at the confidence asked for."""
    upper: Any
    """The greatest."""
    dof: Any
    """Degrees of freedom behind the mean; fewer than were summed where values are correlated."""
    p_value: Any
    """Two-sided p-value."""
    is_consistent: Any
    """Whether the value lies within the bounds, both included."""


@dataclass(frozen=True, eq=False)
class SignificanceTest(_Result):
    """A statistic, its degrees of freedom, and its p-value."""

    statistic: Any
    """The larger, the worse."""
    dof: Any
    """Its degrees of freedom (of the numerator, for an F)."""
    p_value: Any
    """p-value."""
    is_consistent: Any
    """Whether the p-value is at least 1 - confidence."""


@dataclass(frozen=True, eq=False)
class NormalizedMeanError(_Result):
    """Mean errors of each state in claimed standard deviations."""

    value: Any
    """Mean of e_i / sqrt(P_ii): 0 is unbiased."""
    bound: Any
    """Half-width of the acceptance interval."""
    p_value: Any
    """Two-sided: how often an unbiased filter would be as far from 0."""
    is_consistent: Any
    """Whether the value is within the bound."""


@dataclass(frozen=True, eq=False)
class WhitenessTest(_Result):
    """Correlation of whitened innovations with later ones, and whether it is significant."""

    lags: Any
    """How many updates later."""
    correlation: Any
    """In [-1, 1] for each lag; 0 is white."""
    bound: Any
    """Half-width of the acceptance interval, lag by lag."""
    statistic: Any
    """The squares of all lags, each over its variance."""
    dof: Any
    """Degrees of freedom of the statistic: the number of lags."""
    p_value: Any
    """How often white innovations would give as large a statistic."""
    is_white: Any
    """Whether the p-value is at least 1 - confidence."""


@dataclass(frozen=True, eq=False)
class DecorrelatedNEES(_Result):
    """NEES of what each update added to the error: independent from update to update."""

    values: Any
    """One chi-square for each update."""
    dof: Any
    """Its degrees of freedom."""


@dataclass(frozen=True, eq=False)
class CredibilityIndex(_Result):
    """A mean log ratio of claimed to actual error, in decibels."""

    value: Any
    """0 dB is consistent."""
    lower: Any
    """Lower bound of the acceptance interval; NaN where no such interval is known."""
    upper: Any
    """The greatest; NaN where no such interval is known."""
    p_value: Any
    """Two-sided p-value; NaN where it is not known."""


@dataclass(frozen=True, eq=False)
class Coverage(_Result):
    """How many errors lie inside the credibility region, against its nominal probability."""

    probability: Any
    """Nominal probability of the region."""
    share: Any
    """What it holds."""
    lower: Any
    """The least share of all errors that the sample allows for (Clopper-Pearson)."""
    upper: Any
    """The greatest."""
    inside: Any
    """Errors inside; on the edge counts."""
    count: Any
    """All errors."""
    is_consistent: Any
    """Whether the nominal probability lies within the interval."""


@dataclass(frozen=True, eq=False)
class UniformityTest(_Result):
    """Are probabilities spread evenly over [0, 1], as a consistent filter's are?"""

    probabilities: Any
    """Where each value stands in its distribution."""
    ks_statistic: Any
    """Kolmogorov-Smirnov: the largest gap between the two distribution functions."""
    ks_p_value: Any
    """p-value: probability of as large a gap for a consistent filter."""
    cvm_statistic: Any
    """Cramer-von Mises: the mean squared gap, times the number of values."""
    cvm_p_value: Any
    """p-value: probability of as large a gap for a consistent filter."""
    is_consistent: Any
    """Whether both p-values are at least 1 - confidence."""


@dataclass(frozen=True, eq=False)
class CovarianceScale(_Result):
    """The number that covariances should be multiplied by."""

    scale: Any
    """Above 1 the filter is optimistic, below pessimistic."""
    lower: Any
    """The least scale that the values allow for."""
    upper: Any
    """The greatest."""
    dof: Any
    """Degrees of freedom behind it."""

    def __str__(self) -> str:
        if isinstance(self.scale, np.ndarray):
            return repr(self)
        return f"multiply P by {self.scale:.2g} [{self.lower:.2g}, {self.upper:.2g}]"


@dataclass(frozen=True, eq=False)
class UpdateIdentity(_Result):
    """Does a logged update add up?"""

    residual: Any
    """NEES- + v'R^-1 v - NIS - NEES+, zero for a linear update that was logged right."""
    holds: Any
    """Whether it is zero to within the tolerance, relative to the larger side."""
