"""Which noise is too small or too large, from innovations and their covariances alone.

Innovations that exceed their covariance point to a noise that is too small; if consecutive ones
agree in sign it is the process noise, if they alternate the measurement noise. No number follows:
for that the gains of the filter are needed.
"""

from dataclasses import dataclass

import numpy as np

from trackmetrics.diagnostics._noise_fit import chi_square_tail
from trackmetrics.diagnostics.cause import CAUSES
from trackmetrics.diagnostics.innovations import Innovations, innovations_at
from trackmetrics.diagnostics.thresholds import MIN_PAIRS_FOR_CORRELATION
from trackmetrics.diagnostics.whiteness import innovation_correlation
from trackmetrics.logs.columns import Columns
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
        if len(own) < MIN_PAIRS_FOR_CORRELATION:
            continue
        total, size = own.sums
        squared, dof, updates = squared + total, dof + size, updates + len(own)
        found = innovation_correlation(own)
        if np.isfinite(found.z) and found.p_value < 1:
            score, count = score + found.z, count + 1
    if not dof:
        return Direction(None, float("nan"), updates)
    upper = chi_square_tail(squared, int(dof))
    p_value = min(1.0, 2 * min(upper, 1 - upper))
    label = "optimistic" if upper < 0.5 else "pessimistic"
    z = score / max(count, 1) ** 0.5
    correlated = chi_square_tail(z * z, 1)
    cause = CAUSES.get((label, int(np.sign(z))))
    significant = p_value < SIGNIFICANT and correlated < SIGNIFICANT
    return Direction(cause if significant else None, p_value, updates)


def _innovations(columns: Columns) -> Innovations:
    assert columns.innovation is not None
    assert columns.S is not None
    rows = np.arange(len(columns))
    return innovations_at(rows, columns, columns.innovation, columns.S)
