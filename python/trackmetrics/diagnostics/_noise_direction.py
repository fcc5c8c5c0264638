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
MOST = 6.0
"""Normal scores beyond this count as this."""


@dataclass(frozen=True)
class Direction:
    """A direction, and how significant it is."""

    cause: str | None
    p_value: float
    updates: int


def direction(log: EstimatorLog) -> Direction:
    """The direction of all tracks together, each with the same weight whatever its size: one lost
    track does not decide for the others."""
    sizes, correlations, updates = [], [], 0
    for track in log.tracks:
        own = _innovations(log[track])
        if len(own) < MIN_PAIRS_FOR_CORRELATION:
            continue
        updates += len(own)
        squared, dof = own.sums
        upper = chi_square_tail(squared, int(dof))
        sizes.append(_score(upper))
        correlations.append(float(np.clip(innovation_correlation(own).z, -MOST, MOST)))
    if not sizes:
        return Direction(None, float("nan"), updates)
    size, z = _combined(sizes), _combined(correlations)
    p_value, correlated = chi_square_tail(size**2, 1), chi_square_tail(z**2, 1)
    cause = CAUSES.get(("optimistic" if size > 0 else "pessimistic", int(np.sign(z))))
    significant = p_value < SIGNIFICANT and correlated < SIGNIFICANT
    return Direction(cause if significant else None, p_value, updates)


def _score(upper: float) -> float:
    """The normal score of an upper tail probability, within :data:`MOST`."""
    from scipy import special

    return float(np.clip(-special.ndtri(min(max(upper, 1e-15), 1 - 1e-15)), -MOST, MOST))


def _combined(scores: list[float]) -> float:
    return float(np.nansum(scores) / len(scores) ** 0.5)


def _innovations(columns: Columns) -> Innovations:
    assert columns.innovation is not None
    assert columns.S is not None
    rows = np.arange(len(columns))
    return innovations_at(rows, columns, columns.innovation, columns.S)
