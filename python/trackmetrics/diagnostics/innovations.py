"""What the innovations of a settled stretch say: a bias, a correlation in time, and so a cause.

An honest filter's innovations have mean zero and are white. A constant mean is a bias of that
sensor; neighbours that pull the same way say that the filter follows too slowly, neighbours that
alternate that it follows too fast.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _distributions
from trackmetrics.logs.columns import Floats, Words
from trackmetrics.logs.derived import whitened
from trackmetrics.logs.validation import completed

LEAST_UPDATES = 8
LEAST_PAIRS = 8

CAUSES: Mapping[tuple[str, int], str] = {
    ("high", 1): "process noise too small",
    ("high", -1): "measurement noise too small",
    ("low", 1): "measurement noise too large",
    ("low", -1): "process noise too large",
}


@dataclass(frozen=True)
class Innovations:
    """The innovations of some updates of a track, NaN where a component is missing."""

    values: Floats
    covariances: Floats
    types: Words

    def __len__(self) -> int:
        """How many updates."""
        return len(self.values)

    @cached_property
    def there(self) -> NDArray[np.bool_]:
        """Which components there are."""
        known: NDArray[np.bool_] = ~np.isnan(self.values)
        return known

    @cached_property
    def white(self) -> Floats:
        """Whitened update by update, 0 where a component is missing."""
        return whitened(self.values, self.covariances, self.there)

    @property
    def scale(self) -> tuple[float, float]:
        """The NIS of all updates together, and its degrees of freedom."""
        return float((self.white**2).sum()), float(self.there.sum())


@dataclass(frozen=True)
class Offset:
    """The mean innovation of one component of one measurement type."""

    type: str
    component: int
    value: float
    z: float
    p_value: float


@dataclass(frozen=True)
class Correlation:
    """The correlation of whitened innovations with the next few."""

    lag1: float
    z: float
    """In standard deviations: positive where they pull the same way, negative where they alternate;
    whichever of the two weighted sums over the lags is further out."""
    p_value: float
    pairs: int
    late_z: float
    """The same sum over the second half alone."""
    late_scale: float
    """Mean square of the whitened innovations of the second half."""

    @property
    def memory(self) -> float:
        """By how much it widens the variance of a mean, were it to fade geometrically."""
        lag1 = min(max(self.lag1, 0.0), 0.9)
        return (1 + lag1) / (1 - lag1)

    def sign(self, level: float) -> int:
        """Its sign where it is significant, else 0."""
        return int(np.sign(self.z)) if self.p_value < level else 0

    def lasting_sign(self, level: float, high: bool) -> int:
        """Its sign where the second half agrees with it, and is itself too large (or too small):
        what a bad start leaves behind fades."""
        sign = self.sign(level)
        lasts = LASTING < self.late_scale < LOST if high else self.late_scale < 1 / LASTING
        return sign if sign * self.late_z > 0 and lasts else 0


def offsets(innovations: Innovations, memory: float = 1.0) -> list[Offset]:
    """The mean of every component of every measurement type that has 8 values, Holm-corrected.

    By generalised least squares with the claimed covariances; the variance is widened where the
    residuals are wider than claimed or correlated in time (Newey and West 1987,
    doi:10.2307/1913610), and by at least the factor ``memory``.
    """
    found = []
    for kind in sorted(set(innovations.types)):
        rows = innovations.types == kind
        found += _offsets_of(
            str(kind), innovations.values[rows], innovations.covariances[rows], memory
        )
    if not found:
        return []
    corrected = _distributions.holm(np.array([o.p_value for o in found]))
    return [
        Offset(o.type, o.component, o.value, o.z, float(p))
        for o, p in zip(found, corrected, strict=True)
    ]


def _offsets_of(kind: str, values: Floats, covariances: Floats, memory: float) -> list[Offset]:
    tested = np.flatnonzero((~np.isnan(values)).sum(axis=0) >= LEAST_UPDATES)
    if not len(tested):
        return []
    values, covariances = values[:, tested], covariances[:, tested[:, None], tested]
    means, variances = _weighted_means(values, covariances)
    residuals = (values - means) / np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    known = [r[~np.isnan(r)] for r in residuals.T]
    spread = _excess_spread(known)
    memories = np.array([max(memory, _memory(r)) for r in known])
    z = means / np.sqrt(variances * spread * memories)
    # A variance that is claimed needs no Student; one that is estimated does.
    p = np.where(
        spread > 1,
        _distributions.t_p_value(z, np.array([len(r) - 1.0 for r in known])),
        _distributions.normal_p_value(z),
    )
    columns = zip(tested.tolist(), means.tolist(), z.tolist(), p.tolist(), strict=True)
    return [Offset(kind, *column) for column in columns]


def _weighted_means(values: Floats, covariances: Floats) -> tuple[Floats, Floats]:
    """Generalised least squares over the components that each row has; means, their variances."""
    there = ~np.isnan(values)
    weights = np.linalg.inv(completed(covariances, there))
    weights = np.where(there[:, :, None] & there[:, None, :], weights, 0.0)
    variance = np.linalg.inv(weights.sum(axis=0))
    means = variance @ np.einsum("kij,kj->i", weights, np.where(there, values, 0.0))
    return means, variance.diagonal()


NOTABLE = 0.05
"""Chance below which residuals count as wider than claimed."""


def _excess_spread(residuals: list[Floats]) -> Floats:
    """The variance of unit residuals where it is significantly above 1, else 1."""
    squares = np.array([float(r @ r) for r in residuals])
    counts = np.array([float(len(r)) for r in residuals])
    wide = _distributions.chi2_sf(squares, counts - 1) < NOTABLE
    return np.where(wide, np.maximum(1.0, squares / counts), 1.0)


def _memory(residuals: Floats) -> float:
    """By how much correlation in time widens the variance of a mean; at least 1.

    With Bartlett weights up to the cube root of n, over the lags whose correlation is notable.
    """
    n = len(residuals)
    power = max(float(residuals @ residuals), 1e-300)
    longest = max(1, round(n ** (1 / 3)))
    memory = 1.0
    for lag in range(1, min(longest, n - 1) + 1):
        shared = float(residuals[:-lag] @ residuals[lag:]) / power
        if abs(shared) > 2 / n**0.5:
            memory += 2 * (1 - lag / (longest + 1)) * shared
    return max(1.0, memory)


def without(innovations: Innovations, biases: list[Offset]) -> Innovations:
    """The innovations without these offsets."""
    values = innovations.values.copy()
    for bias in biases:
        values[innovations.types == bias.type, bias.component] -= bias.value
    return Innovations(values, innovations.covariances, innovations.types)


CLIPPED = 3.0
"""Robust deviations at which an innovation is clipped: one huge pair proves no correlation."""


def correlation(innovations: Innovations) -> Correlation:
    """How the components that an update shares with the next few agree with these."""
    white, there = innovations.white, innovations.there
    half = len(white) // 2
    late_scale = float((white[half:][there[half:]] ** 2).mean())
    most = CLIPPED * float(np.median(np.abs(white[there]))) / 0.6745
    white = np.clip(white, -most, most)
    lags = _lags(white, there)
    slow, fast = _weighted(lags, SLOW), _weighted(lags, FAST)
    z, weights = (slow, SLOW) if slow > -fast else (fast, FAST)
    late_z = _weighted(_lags(white[half:], there[half:]), weights)
    lag1, pairs = lags[0] if lags else (float("nan"), int((there[:-1] & there[1:]).sum()))
    return Correlation(lag1, z, float(_distributions.normal_p_value(z)), pairs, late_z, late_scale)


SLOW, FAST = (1.0, 0.5, 0.25), (1.0, 0.3)
"""Weights of the lags. A filter that follows too slowly leaves innovations that pull the same way
for several updates; behind one that follows too fast they alternate once and are forgotten."""
LASTING = 1.1
"""Scale that the second half must exceed for a cause to be named."""
LOST = 30.0
"""Scale above which a filter has lost its target, and no noise explains it."""


def _lags(white: Floats, there: NDArray[np.bool_]) -> list[tuple[float, int]]:
    """Correlation with each of the next updates, and over how many pairs, while there are any."""
    found = []
    for lag in range(1, min(len(SLOW), len(white) - 1) + 1):
        shared = there[:-lag] & there[lag:]
        before, after = white[:-lag][shared], white[lag:][shared]
        power = 0.5 * float(before @ before + after @ after)
        if len(before) < LEAST_PAIRS or power <= 0:
            break
        found.append((float(before @ after) / power, len(before)))
    return found


def _weighted(lags: list[tuple[float, int]], weights: tuple[float, ...]) -> float:
    """The weighted sum of correlations, as a standard normal value at the same chance.

    The sum is a quadratic form, and leans towards large values: its third cumulant comes from lags
    of which two add up to another. A chi-square with that skewness stands for it.
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
