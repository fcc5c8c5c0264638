"""Monte Carlo sweeps: many runs over a grid of settings, and accumulators that can be merged.

However the runs are cut, in whatever order they come, on however many machines: the same seed gives
the same bits.
"""

from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.labels import LabelAccumulator, LabelSummary
from trackmetrics.monte_carlo.accumulators.point_sets import PointSetAccumulator, PointSetSummary
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.consistency_summary import ConsistencySummary, FormStatistics
from trackmetrics.monte_carlo.results import SweepResult
from trackmetrics.monte_carlo.selection import Best
from trackmetrics.monte_carlo.setting_state import Failure
from trackmetrics.monte_carlo.sweep import SweepInterrupted, sweep

__all__ = [
    "Accumulator",
    "Best",
    "ConsistencyAccumulator",
    "ConsistencySummary",
    "Failure",
    "FormStatistics",
    "LabelAccumulator",
    "LabelSummary",
    "PointSetAccumulator",
    "PointSetSummary",
    "ScoreAccumulator",
    "SweepInterrupted",
    "SweepResult",
    "sweep",
]
