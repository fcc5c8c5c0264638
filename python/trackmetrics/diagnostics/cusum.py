"""Page's cumulative sum test for a change of scale of chi-square values.

The log-likelihood ratio of scale s against 1 of a value c with m degrees of freedom is
l = -(m / 2) ln s + (c / 2) (1 - 1 / s). The sum g rises by l, never below 0, and an alarm is raised
above h = ln(n / alpha): by Ville's inequality each excursion from 0 passes h with probability
alpha / n at most, so that within n values the false-alarm probability is at most alpha.
Page (1954), doi:10.1093/biomet/41.1-2.100.
"""

from collections.abc import Sequence
from math import log

import numpy as np

from trackmetrics import _backend
from trackmetrics.diagnostics.thresholds import CUSUM_ALPHA, CUSUM_SCALE_HIGH
from trackmetrics.diagnostics.trace import Pair

Alarm = tuple[int, int]
"""Where the sum passes its threshold, and where it began to rise."""


def first_alarms(pairs: Sequence[Pair], alpha: float = CUSUM_ALPHA) -> list[Alarm | None]:
    """The first alarm for "too large" of each sequence."""
    if not pairs:
        return []
    starts = np.concatenate([[0], np.cumsum([len(values) for values, _ in pairs])])
    values, dof = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    alarms = _backend.kernels.first_alarms(
        values, dof, starts.astype(np.int64), CUSUM_SCALE_HIGH, alpha
    )
    return [(alarm, onset) if alarm >= 0 else None for alarm, onset in alarms.tolist()]


def alarm_of_fault(pair: Pair, alarm: Alarm | None, onset: int | None) -> Alarm | None:
    """The alarm that belongs to a fault which begins at ``onset``.

    An alarm before the fault is a false one; the sum is then started again at the onset.
    """
    if alarm is None or onset is None or alarm[0] >= onset:
        return alarm
    values, dof = pair
    (found,) = first_alarms([(values[onset:], dof[onset:])])
    return None if found is None else (found[0] + onset, found[1] + onset)


def rise(value: float, dof: float, scale: float) -> float:
    """The log-likelihood ratio of ``scale`` against 1 of one value."""
    return -(dof / 2) * log(scale) + (value / 2) * (1 - 1 / scale)
