"""Whiteness of the innovations: their correlation with those of the next few updates.

The innovations of a consistent filter are white. Behind a filter that reacts too slowly they are
positively autocorrelated over several updates, behind one that reacts too fast negatively over one
or two: each has its own weights over the lags, and the more significant of the two sums counts.
"""

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _distributions
from trackmetrics.diagnostics.innovations import Innovations
from trackmetrics.diagnostics.results import InnovationCorrelation
from trackmetrics.diagnostics.thresholds import MAX_ROBUST_DEVIATIONS, MIN_PAIRS_FOR_CORRELATION
from trackmetrics.logs.columns import Floats

POSITIVE_WEIGHTS = (1.0, 0.5, 0.25)
"""Weights of the lags in the sum that finds positive autocorrelation."""
NEGATIVE_WEIGHTS = (1.0, 0.3)
"""Weights of the lags in the sum that finds negative autocorrelation."""


def innovation_correlation(innovations: Innovations) -> InnovationCorrelation:
    """The correlation of the components that an update shares with the next few."""
    white, valid = innovations.whitened, innovations.valid
    half = len(white) // 2
    second_half_scale = float((white[half:][valid[half:]] ** 2).mean())
    # One huge pair of values proves no correlation.
    most = MAX_ROBUST_DEVIATIONS * float(np.median(np.abs(white[valid]))) / 0.6745
    white = np.clip(white, -most, most)
    lags = _lags(white, valid)
    positive, negative = _weighted(lags, POSITIVE_WEIGHTS), _weighted(lags, NEGATIVE_WEIGHTS)
    is_positive = positive > -negative
    z, weights = (positive, POSITIVE_WEIGHTS) if is_positive else (negative, NEGATIVE_WEIGHTS)
    second_half_z = _weighted(_lags(white[half:], valid[half:]), weights)
    lag1, pairs = lags[0] if lags else (float("nan"), int((valid[:-1] & valid[1:]).sum()))
    p_value = float(_distributions.normal_p_value(z))
    return InnovationCorrelation(lag1, z, p_value, pairs, second_half_z, second_half_scale)


def sign(correlation: InnovationCorrelation, alpha: float) -> int:
    """The sign of a correlation that is significant; 0 of one that is not."""
    return int(np.sign(correlation.z)) if correlation.p_value < alpha else 0


def variance_inflation(correlation: InnovationCorrelation) -> float:
    """The factor by which the correlation widens the variance of a mean, decaying geometrically."""
    lag1 = min(max(correlation.lag1, 0.0), 0.9)
    return (1 + lag1) / (1 - lag1)


def _lags(white: Floats, valid: NDArray[np.bool_]) -> list[tuple[float, int]]:
    """The correlation at each lag and its number of pairs, as long as there are enough pairs."""
    found = []
    for lag in range(1, min(len(POSITIVE_WEIGHTS), len(white) - 1) + 1):
        shared = valid[:-lag] & valid[lag:]
        before, after = white[:-lag][shared], white[lag:][shared]
        power = 0.5 * float(before @ before + after @ after)
        if len(before) < MIN_PAIRS_FOR_CORRELATION or power <= 0:
            break
        found.append((float(before @ after) / power, len(before)))
    return found


def _weighted(lags: list[tuple[float, int]], weights: tuple[float, ...]) -> float:
    """The weighted sum of correlations as a standard normal value of equal tail probability.

    The sum is a quadratic form with positive skewness: its third cumulant comes from lags of which
    two add up to another. It is approximated by a shifted chi-square with that skewness.
    """
    parts = list(zip(weights, lags, strict=False))
    if not parts:
        return 0.0
    used = [w for w, _ in parts]
    variance = sum(w * w for w in used)
    z = sum(w * r * n**0.5 for w, (r, n) in parts) / variance**0.5
    triples = sum(
        a * b * used[i + j + 1]
        for i, a in enumerate(used)
        for j, b in enumerate(used)
        if i + j + 1 < len(used)
    )
    skewness = 6 * triples / variance**1.5 / lags[0][1] ** 0.5
    return _distributions.pearson3_to_z(z, skewness)
