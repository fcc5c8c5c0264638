"""What an accumulator of consistency says, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache, cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from trackmetrics.monte_carlo.accumulators.histogram import quantiles
from trackmetrics.monte_carlo.run_tree import Floats

_DECIBELS = 10.0 / np.log(10.0)


@dataclass(frozen=True, repr=False)
class ErrorStatistics:
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
    """Where the mean lies for a consistent filter: ``(2,)``, or ``(steps, 2)`` where N varies."""
    deviation: Floats
    """Standard deviation of q over sqrt(2 n); 1 for a consistent filter."""
    rmse: Floats
    """Root mean square of each component, ``(steps, n)``, in its unit; 0 is best."""
    rmse_interval: Floats
    """Its interval for Gaussian errors, ``(steps, n, 2)``."""
    bias: Floats
    """Mean error of each component, ``(steps, n)``: estimate minus truth, so that +1 is an estimate
    that is too large by 1. For innovations their mean, as they were given."""
    normalized_mean_error: Floats
    """Mean of e_j / sqrt(P_jj) with the sign of ``bias``, ``(steps, n)``; within
    ``normalized_mean_error_bound`` of 0 for a consistent filter."""
    normalized_mean_error_bound: Floats
    """``(steps,)``."""
    coverage: dict[float, Floats]
    """For each probability the share of errors inside that credibility region, ``(steps,)``."""
    covered: dict[float, NDArray[np.int64]]
    """For each probability how many errors lie inside that region, ``(steps,)``."""
    inclination: Floats
    """Mean of 10 log10 q less its expectation, in dB, ``(steps,)``; above 0 is optimistic."""
    inclination_bound: Floats
    """How far from 0 it lies for a consistent filter, ``(steps,)``."""
    noncredibility: Floats
    """Mean distance of 10 log10 q from its expectation, in dB, ``(steps,)``; 0 never is reached: an
    consistent filter has ``noncredibility_expected``."""
    noncredibility_expected: float
    """For a consistent filter."""
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
        """From the sums of an accumulator; ``sign`` turns its mean error into that of ``bias``.

        Accumulators keep sums of truth minus estimate.
        """
        runs = under[0]
        steps, n = len(runs), runs.astype(np.float64)
        with np.errstate(invalid="ignore", divide="ignore"):
            forms = row[: 4 * steps].reshape(4, steps) / n
            of_states = row[4 * steps :].reshape(3, d, steps) / n
            e, squares, normalised = of_states.swapaxes(1, 2).copy()
            spread = np.sqrt(np.maximum(forms[1] - forms[0] ** 2, 0.0) * (n / (n - 1)) / (2 * d))
        shares = under[1:] / np.where(runs > 0, n, np.nan)
        decibels, variance, expected = _expected_decibels(d)
        z = _normal_quantile(confidence)
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
            level: clopper_pearson(inside, self.runs, self.confidence)
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
        """The fields and the intervals of the coverage, arrays as lists."""
        names = [*(field.name for field in fields(self)), "coverage_interval"]
        return {name: _plain(getattr(self, name)) for name in names}


@dataclass(frozen=True, repr=False)
class ConsistencySummary:
    """What many runs say of a filter, step by step."""

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
        """Where the ANEES of a consistent filter lies, ``(2,)``."""
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

    def to_dict(self) -> dict[str, Any]:
        """The fields, arrays as lists."""
        return {
            "runs": self.runs,
            "states": self.states and self.states.to_dict(),
            "innovations": self.innovations and self.innovations.to_dict(),
        }


def chi_square_mean_interval(runs: Floats, d: int, confidence: float) -> Floats:
    """Where the mean of q / d over N runs lies for a consistent filter; one where N is the same."""
    from scipy.special import gammaincinv

    tails = np.array([(1 - confidence) / 2, (1 + confidence) / 2])
    counts = runs[:1] if len(runs) and (runs == runs[0]).all() else runs
    freedom = np.where(counts > 0, counts * d, np.nan)[:, None]
    interval: Floats = 2 * gammaincinv(freedom / 2, tails) / freedom
    first: Floats = interval[0]
    return first if len(interval) == 1 else interval


def clopper_pearson(hits: NDArray[np.int64], runs: NDArray[np.int64], confidence: float) -> Floats:
    """The exact interval of a probability, ``(..., 2)``."""
    from scipy.special import betaincinv

    tail = (1 - confidence) / 2
    n, k = runs.astype(np.float64), hits.astype(np.float64)
    low = np.where(k > 0, betaincinv(np.maximum(k, 1), n - k + 1, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1, np.maximum(n - k, 1), 1 - tail), 1.0)
    interval: Floats = np.stack([low, high], -1)
    interval[runs == 0] = np.nan
    return interval


def _rmse_interval(rmse: Floats, runs: Floats, confidence: float) -> Floats:
    """For Gaussian errors of zero mean: N rmse^2 / sigma^2 is chi-square with N degrees."""
    from scipy.special import gammaincinv

    tails = np.array([(1 + confidence) / 2, (1 - confidence) / 2])
    counts, place = np.unique(runs, return_inverse=True)  # mostly one: the quantiles are costly
    n = np.where(counts > 0, counts, np.nan)[:, None]
    factors: Floats = np.sqrt(n / (2 * gammaincinv(n / 2, tails)))[place]
    interval: Floats = rmse[..., None] * factors[:, None, :]
    return interval


def _normal_quantile(confidence: float) -> float:
    from scipy.special import ndtri

    return float(ndtri((1 + confidence) / 2))


@cache
def _expected_decibels(d: int) -> tuple[float, float, float]:
    """For chi-square q with d degrees: mean and variance of 10 log10 q, and its mean distance from
    the mean.

    E|ln q - c| = 2 E[(ln q - c) over q > e^c]; by parts that is 2 times the integral of
    P(q > e^u) over u > c, a smooth function on a short interval.
    """
    from scipy.special import digamma, gammaincc, polygamma

    c = np.log(2.0) + digamma(d / 2)
    u, step = np.linspace(c, np.log(2 * d + 80.0 * np.sqrt(d) + 800.0), 4001, retstep=True)
    tail = gammaincc(d / 2, np.exp(u) / 2)
    simpson = step / 3 * (tail[0] + 4 * tail[1:-1:2].sum() + 2 * tail[2:-1:2].sum() + tail[-1])
    variance = float(_DECIBELS**2 * polygamma(1, d / 2))
    return float(_DECIBELS * c), variance, float(2 * _DECIBELS * simpson)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return value
