"""Which noise is too small or too large, from innovations and their covariances alone.

Innovations that exceed their covariance point to a noise that is too small; if consecutive ones
agree in sign it is the process noise, if they alternate the measurement noise. No number follows:
for that the gains of the filter are needed.
"""

from dataclasses import dataclass

import numpy as np

from trackmetrics.diagnostics._noise_fit import chi_square_tail
from trackmetrics.diagnostics.innovations import CAUSES, LEAST_PAIRS, Innovations, correlation
from trackmetrics.logs.columns import Columns, components
from trackmetrics.logs.log import EstimatorLog

SIGNIFICANT = 0.01


@dataclass(frozen=True)
class Direction:
    """A direction, and how significant it is."""

    cause: str | None
    p_value: float
    updates: int


def direction(log: EstimatorLog) -> Direction:
    """The direction of all tracks together: squared innovations and correlations are pooled."""
    squared, dof, score, count, updates = 0.0, 0.0, 0.0, 0, 0
    for track in log.tracks:
        own = _innovations(log[track])
        if len(own) < LEAST_PAIRS:
            continue
        total, size = own.scale
        squared, dof, updates = squared + total, dof + size, updates + len(own)
        found = correlation(own)
        if np.isfinite(found.z) and found.p_value < 1:
            score, count = score + found.z, count + 1
    if not dof:
        return Direction(None, float("nan"), updates)
    upper = chi_square_tail(squared, int(dof))
    p_value = min(1.0, 2 * min(upper, 1 - upper))
    label = "high" if upper < 0.5 else "low"
    z = score / max(count, 1) ** 0.5
    correlated = chi_square_tail(z * z, 1)
    cause = CAUSES.get((label, int(np.sign(z))))
    significant = p_value < SIGNIFICANT and correlated < SIGNIFICANT
    return Direction(cause if significant else None, p_value, updates)


def _innovations(columns: Columns) -> Innovations:
    assert columns.innovation is not None
    assert columns.S is not None
    there = components(columns.innovation, columns.S)
    rows = there.any(axis=1)
    values = np.where(there, columns.innovation, np.nan)[rows]
    kinds = columns.measurement_type
    types = np.full(len(values), "", object) if kinds is None else kinds[rows]
    return Innovations(values, columns.S[rows], types)
