"""What the innovations of a settled stretch say: a bias, a correlation in time, and so a cause.

An honest filter's innovations have mean zero and are white. A constant mean is a bias of that
sensor; neighbours that pull the same way say that the filter follows too slowly, neighbours that
alternate that it follows too fast.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trackmetrics.diagnostics import chisquare
from trackmetrics.diagnostics.checking import unit_diagonal
from trackmetrics.diagnostics.columns import Floats, Integers, Words, lengths

LEAST_UPDATES = 8

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

    def sign(self, level: float) -> int:
        """Its sign where it is significant, else 0."""
        return int(np.sign(self.z)) if self.p_value < level else 0


def offsets(innovations: Innovations) -> list[Offset]:
    """The mean of every component of every measurement type that has 8 updates, Holm-corrected.

    By generalised least squares with the claimed covariances; the variance is widened where the
    residuals are wider than claimed, and by their correlation in time (Newey and West 1987).
    """
    found = []
    widths = lengths(innovations.values)
    for kind in sorted(set(innovations.types)):
        rows = np.flatnonzero((innovations.types == kind) & (widths > 0))
        if len(rows) >= LEAST_UPDATES and len(set(widths[rows])) == 1:
            m = int(widths[rows[0]])
            s = innovations.covariances[rows, :m, :m]
            found += _offsets_of(str(kind), innovations.values[rows, :m], s)
    if not found:
        return []
    corrected = chisquare.holm(np.array([o.p_value for o in found]))
    return [
        Offset(o.type, o.component, o.value, o.z, float(p))
        for o, p in zip(found, corrected, strict=True)
    ]


def _offsets_of(kind: str, values: Floats, covariances: Floats) -> list[Offset]:
    weights = np.linalg.inv(covariances)
    variance = np.linalg.inv(weights.sum(axis=0))
    means = variance @ np.einsum("kij,kj->i", weights, values)
    residuals = (values - means) / np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    z = means / np.sqrt(variance.diagonal() * widening(residuals))
    p = chisquare.student_two_sided(z, len(values) - 1)
    return [Offset(kind, j, float(means[j]), float(z[j]), float(p[j])) for j in range(len(means))]


def widening(residuals: Floats) -> Floats:
    """By how much the variance of a mean exceeds that of independent unit residuals; at least 1."""
    n = len(residuals)
    spread = np.maximum((residuals**2).mean(axis=0), 1e-300)
    longest = max(1, round(n ** (1 / 3)))
    memory = np.ones(residuals.shape[1])
    for lag in range(1, min(longest, n - 1) + 1):
        shared = (residuals[:-lag] * residuals[lag:]).sum(axis=0) / n / spread
        memory += 2 * (1 - lag / (longest + 1)) * shared
    widened: Floats = np.maximum(1.0, spread) * np.maximum(1.0, memory)
    return widened


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


def correlation(innovations: Innovations) -> Correlation:
    """Lag-1 correlation over the components that neighbours share."""
    white, there = whitened(innovations), ~np.isnan(innovations.values)
    shared = there[:-1] & there[1:]
    before, after = white[:-1][shared], white[1:][shared]
    pairs = int(shared.sum())
    power = 0.5 * float(before @ before + after @ after)
    if pairs < LEAST_UPDATES or power <= 0:
        return Correlation(float("nan"), 0.0, 1.0, pairs)
    lag1 = float(before @ after) / power
    z = lag1 * float(np.sqrt(pairs))
    return Correlation(lag1, z, float(chisquare.normal_two_sided(z)), pairs)


def rows_of(innovations: Innovations, rows: Integers) -> Innovations:
    """Some of the updates."""
    return Innovations(
        innovations.values[rows], innovations.covariances[rows], innovations.types[rows]
    )
