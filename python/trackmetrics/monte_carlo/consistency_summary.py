"""Statistics of errors over many runs, with intervals.

The error of a state is estimate minus truth; the error of a measurement is the innovation,
measurement minus prediction.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from trackmetrics._distributions import (
    DECIBELS,
    chi2_log_mean,
    chi2_quantile,
    clopper_pearson,
    normal_quantile,
    special,
)
from trackmetrics.monte_carlo.accumulators.histogram import quantiles
from trackmetrics.monte_carlo.run_tree import Floats
from trackmetrics.results import Result, to_json


@dataclass(frozen=True, repr=False)
class ErrorStatistics(Result):
    """Statistics over runs, step by step, of errors with their covariances.

    ``n`` is the dimension of the error, N the number of runs that counted at a step. NaN where none
    did.
    """

    dimension: int
    """n."""
    confidence: float
    """Of all intervals."""
    runs: NDArray[np.int64]
    """N of each step, ``(steps,)``."""
    mean: Floats
    """Mean of q / n: ANEES for states, ANIS for innovations, ``(steps,)``; 1 is consistent, more is
    optimistic."""
    interval: Floats
    """Acceptance interval of the mean for a consistent filter: ``(2,)``, or ``(steps, 2)`` where N
    varies."""
    deviation: Floats
    """Standard deviation of q over sqrt(2 n); 1 for a consistent filter."""
    rmse: Floats
    """Root mean square of each component, ``(steps, n)``, in its unit; 0 is best."""
    rmse_interval: Floats
    """Its interval for Gaussian errors, ``(steps, n, 2)``."""
    bias: Floats
    """Mean error of each component, ``(steps, n)``, in its unit: estimate minus truth for states,
    measurement minus prediction for innovations; 0 is best."""
    normalized_mean_error: Floats
    """Mean of e_j / sqrt(P_jj), ``(steps, n)``; same sign as ``bias``; within
    ``normalized_mean_error_bound`` of 0 for a consistent filter."""
    normalized_mean_error_bound: Floats
    """Its largest absolute value for a consistent filter, ``(steps,)``."""
    coverage: dict[float, Floats]
    """For each probability the share of errors inside that credibility region, ``(steps,)``."""
    covered: dict[float, NDArray[np.int64]]
    """For each probability how many errors lie inside that region, ``(steps,)``."""
    inclination: Floats
    """Mean of 10 log10 q less its expectation, in dB, ``(steps,)``; above 0 is optimistic."""
    inclination_bound: Floats
    """How far from 0 it lies for a consistent filter, ``(steps,)``."""
    noncredibility: Floats
    """Mean distance of 10 log10 q from its expectation, in dB, ``(steps,)``; a
    consistent filter has ``noncredibility_expected``, which is above 0."""
    noncredibility_expected: float
    """Noncredibility of a consistent filter, in dB."""
    histogram: NDArray[np.int64]
    """Counts of q, ``(steps, bins)``."""

    @classmethod
    def of(
        cls,
        row: Floats,
        d: int,
        under: NDArray[np.int64],
        histogram: NDArray[np.int64],
        levels: Sequence[float],
        confidence: float,
        *,
        sign: float,
    ) -> Self:
        """From the sums of an accumulator; ``sign`` is -1 where it sums truth minus estimate."""
        runs = under[0]
        steps, n = len(runs), runs.astype(np.float64)
        with np.errstate(invalid="ignore", divide="ignore"):
            forms = row[: 4 * steps].reshape(4, steps) / n
            of_states = row[4 * steps :].reshape(3, d, steps) / n
            e, squares, normalised = of_states.swapaxes(1, 2).copy()
            spread = np.sqrt(np.maximum(forms[1] - forms[0] ** 2, 0.0) * (n / (n - 1)) / (2 * d))
        shares = under[1:] / np.where(runs > 0, n, np.nan)
        decibels, variance, expected = _expected_decibels(d)
        z = float(normal_quantile((1 + confidence) / 2))
        with np.errstate(divide="ignore"):
            one = z / np.sqrt(n)
        one[runs == 0] = np.nan
        return cls(
            dimension=d,
            confidence=confidence,
            runs=runs,
            mean=forms[0] / d,
            interval=chi_square_mean_interval(n, d, confidence),
            deviation=spread,
            rmse=np.sqrt(squares),
            rmse_interval=_rmse_interval(np.sqrt(squares), n, confidence),
            # 0.0 + x, so that no bias is 0 and not -0.
            bias=0.0 + sign * e,
            normalized_mean_error=0.0 + sign * normalised,
            normalized_mean_error_bound=one,
            coverage=dict(zip(levels, shares, strict=True)),
            covered=dict(zip(levels, under[1:], strict=True)),
            inclination=forms[2] - decibels,
            inclination_bound=one * np.sqrt(variance),
            noncredibility=forms[3],
            noncredibility_expected=expected,
            histogram=histogram,
        )

    @cached_property
    def coverage_interval(self) -> dict[float, Floats]:
        """Of the coverage, by Clopper and Pearson, ``(steps, 2)``."""
        return {
            level: np.stack(clopper_pearson(inside, self.runs, self.confidence), -1)
            for level, inside in self.covered.items()
        }

    def quantiles(self, levels: Sequence[float]) -> Floats:
        """Quantiles of q, ``(levels, steps)``, from its histogram: wrong by at most 12 %, and by
        much less where many runs fall into a bin."""
        return quantiles(self.histogram, levels)

    def __repr__(self) -> str:
        return (
            f"ErrorStatistics(dimension={self.dimension}, steps={len(self.runs)}, "
            f"mean={np.nanmean(self.mean):.4g})"
        )

    def to_dict(self) -> dict[str, Any]:
        """The fields and the intervals of the coverage, ready for JSON."""
        return {**super().to_dict(), "coverage_interval": to_json(self.coverage_interval)}


@dataclass(frozen=True, repr=False)
class ConsistencySummary(Result):
    """Consistency and accuracy of a filter over many runs, step by step."""

    runs: int
    """How many runs."""
    states: ErrorStatistics | None
    """Of the errors of states, where truth was given."""
    innovations: ErrorStatistics | None
    """Of the innovations, where they were given."""

    @property
    def anees(self) -> Floats:
        """Average NEES over runs, normalised by the dimension, ``(steps,)``; 1 is consistent."""
        return self._states.mean

    @property
    def anees_interval(self) -> Floats:
        """Acceptance interval of the ANEES of a consistent filter, ``(2,)``."""
        return self._states.interval

    @property
    def rmse(self) -> Floats:
        """Root mean square error over runs, ``(steps, n)``."""
        return self._states.rmse

    @property
    def coverage(self) -> dict[float, Floats]:
        """Share of errors inside each credibility region, ``(steps,)``."""
        return self._states.coverage

    @property
    def anis(self) -> Floats:
        """Average NIS over runs, normalised by the dimension, ``(steps,)``; 1 is consistent."""
        if self.innovations is None:
            raise ValueError("no innovations were given")
        return self.innovations.mean

    @property
    def _states(self) -> ErrorStatistics:
        if self.states is None:
            raise ValueError("no truth was given")
        return self.states

    def __repr__(self) -> str:
        parts = [f"runs={self.runs}"]
        if self.states:
            parts.append(f"anees={np.mean(self.anees):.4g}")
        if self.innovations:
            parts.append(f"anis={np.nanmean(self.anis):.4g}")
        return f"ConsistencySummary({', '.join(parts)})"


def chi_square_mean_interval(runs: Floats, d: int, confidence: float) -> Floats:
    """Acceptance interval of the mean of q / d over N runs; one where N is the same."""
    tails = np.array([(1 - confidence) / 2, (1 + confidence) / 2])
    counts = runs[:1] if len(runs) and (runs == runs[0]).all() else runs
    dof = np.where(counts > 0, counts * d, np.nan)[:, None]
    interval: Floats = chi2_quantile(tails, dof) / dof
    first: Floats = interval[0]
    return first if len(interval) == 1 else interval


def _rmse_interval(rmse: Floats, runs: Floats, confidence: float) -> Floats:
    """For Gaussian errors of zero mean: N rmse^2 / sigma^2 is chi-square with N degrees."""
    tails = np.array([(1 + confidence) / 2, (1 - confidence) / 2])
    counts, place = np.unique(runs, return_inverse=True)  # mostly one: the quantiles are costly
    n = np.where(counts > 0, counts, np.nan)[:, None]
    factors: Floats = np.sqrt(n / chi2_quantile(tails, n))[place]
    interval: Floats = rmse[..., None] * factors[:, None, :]
    return interval


@cache
def _expected_decibels(d: int) -> tuple[float, float, float]:
    """Mean and variance of 10 log10 q, and its mean distance from the mean, for chi-square q.

    The mean absolute deviation is twice the integral of the upper tail above the mean.
    """
    c = float(chi2_log_mean(d))
    u, step = np.linspace(c, np.log(2 * d + 80.0 * np.sqrt(d) + 800.0), 4001, retstep=True)
    tail = special().gammaincc(d / 2, np.exp(u) / 2)
    simpson = step / 3 * (tail[0] + 4 * tail[1:-1:2].sum() + 2 * tail[2:-1:2].sum() + tail[-1])
    variance = float(DECIBELS**2 * special().polygamma(1, d / 2))
    return float(DECIBELS * c), variance, float(2 * DECIBELS * simpson)
