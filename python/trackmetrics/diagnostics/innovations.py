"""What the innovations of a settled stretch say: a bias, a correlation in time, and so a cause.

An honest filter's innovations have mean zero and are white. A constant mean is a bias of that
sensor; neighbours that pull the same way say that the filter follows too slowly, neighbours that
alternate that it follows too fast.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _chi2
from trackmetrics.diagnostics import laws
from trackmetrics.diagnostics.checking import unit_diagonal
from trackmetrics.diagnostics.columns import Floats, Words, lengths

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
    """The innovations of some updates of a track, padded with NaN."""

    values: Floats
    covariances: Floats
    types: Words

    def __len__(self) -> int:
        """How many updates."""
        return len(self.values)


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
    """The correlation of whitened innovations with the next."""

    lag1: float
    z: float
    p_value: float
    pairs: int
    late_z: float
    """The same in standard deviations, of the second half alone."""
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
    """The mean of every component of every measurement type that has 8 updates, Holm-corrected.

    By generalised least squares with the claimed covariances; the variance is widened where the
    residuals are wider than claimed or correlated in time (Newey and West 1987,
    doi:10.2307/1913610), and by at least the factor ``memory``.
    """
    found = []
    widths = lengths(innovations.values)
    for kind in sorted(set(innovations.types)):
        rows = np.flatnonzero((innovations.types == kind) & (widths > 0))
        if len(rows) >= LEAST_UPDATES and len(set(widths[rows])) == 1:
            m = int(widths[rows[0]])
            s = innovations.covariances[rows, :m, :m]
            found += _offsets_of(str(kind), innovations.values[rows, :m], s, memory)
    if not found:
        return []
    corrected = laws.holm(np.array([o.p_value for o in found]))
    return [
        Offset(o.type, o.component, o.value, o.z, float(p))
        for o, p in zip(found, corrected, strict=True)
    ]


def _offsets_of(kind: str, values: Floats, covariances: Floats, memory: float) -> list[Offset]:
    weights = np.linalg.inv(covariances)
    variance = np.linalg.inv(weights.sum(axis=0))
    means = variance @ np.einsum("kij,kj->i", weights, values)
    residuals = (values - means) / np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    spread = _excess_spread(residuals)
    z = means / np.sqrt(variance.diagonal() * spread * np.maximum(memory, _memory(residuals)))
    # A variance that is claimed needs no Student; one that is estimated does.
    p = np.where(
        spread > 1,
        laws.student_two_sided(z, len(values) - 1),
        laws.normal_two_sided(z),
    )
    return [Offset(kind, j, float(means[j]), float(z[j]), float(p[j])) for j in range(len(means))]


NOTABLE = 0.05
"""Chance below which residuals count as wider than claimed."""


def _excess_spread(residuals: Floats) -> Floats:
    """The variance of unit residuals where it is significantly above 1, else 1."""
    squares = (residuals**2).sum(axis=0)
    wide = _chi2.sf(squares, len(residuals) - 1) < NOTABLE
    return np.where(wide, np.maximum(1.0, squares / len(residuals)), 1.0)


def _memory(residuals: Floats) -> Floats:
    """By how much correlation in time widens the variance of a mean; at least 1.

    With Bartlett weights up to the cube root of n, over the lags whose correlation is notable.
    """
    n = len(residuals)
    power = np.maximum((residuals**2).sum(axis=0), 1e-300)
    longest = max(1, round(n ** (1 / 3)))
    memory = np.ones(residuals.shape[1])
    for lag in range(1, min(longest, n - 1) + 1):
        shared = (residuals[:-lag] * residuals[lag:]).sum(axis=0) / power
        notable = np.abs(shared) > 2 / np.sqrt(n)
        memory += np.where(notable, 2 * (1 - lag / (longest + 1)) * shared, 0.0)
    return np.maximum(1.0, memory)


def without(innovations: Innovations, biases: list[Offset]) -> Innovations:
    """The innovations without these offsets."""
    values = innovations.values.copy()
    for bias in biases:
        values[innovations.types == bias.type, bias.component] -= bias.value
    return Innovations(values, innovations.covariances, innovations.types)


def whitened(innovations: Innovations) -> Floats:
    """L^-1 of each innovation with S = L L', 0 in the padding."""
    s, v = innovations.covariances, innovations.values
    d = np.sqrt(np.where(np.isnan(s), np.eye(s.shape[1]), s).diagonal(axis1=1, axis2=2))
    factor = np.linalg.cholesky(unit_diagonal(s))
    white: Floats = np.linalg.solve(factor, (np.nan_to_num(v) / d)[..., None])[..., 0]
    return white


CLIPPED = 3.0
"""Robust deviations at which an innovation is clipped: one huge pair proves no correlation."""


def correlation(innovations: Innovations) -> Correlation:
    """Lag-1 correlation over the components that neighbours share."""
    white, there = whitened(innovations), ~np.isnan(innovations.values)
    half = len(white) // 2
    late_scale = float((white[half:][there[half:]] ** 2).mean())
    most = CLIPPED * float(np.median(np.abs(white[there]))) / 0.6745
    white = np.clip(white, -most, most)
    lag1, z, pairs = _lag1(white, there)
    _, late_z, _ = _lag1(white[half:], there[half:])
    return Correlation(lag1, z, float(laws.normal_two_sided(z)), pairs, late_z, late_scale)


LASTING = 1.1
"""Scale that the second half must exceed for a cause to be named."""
LOST = 30.0
"""Scale above which a filter has lost its target, and no noise explains it."""


def _lag1(white: Floats, there: NDArray[np.bool_]) -> tuple[float, float, int]:
    """Correlation with the next, in standard deviations, and over how many pairs."""
    shared = there[:-1] & there[1:]
    before, after = white[:-1][shared], white[1:][shared]
    pairs = int(shared.sum())
    power = 0.5 * float(before @ before + after @ after)
    if pairs < LEAST_PAIRS or power <= 0:
        return float("nan"), 0.0, pairs
    lag1 = float(before @ after) / power
    return lag1, lag1 * float(np.sqrt(pairs)), pairs
