"""Monte Carlo sweeps: many runs over a grid of settings, and accumulators that can be merged.

However the runs are cut, in whatever order they come, on however many machines: the same seed gives
the same bits.
"""

from trackmetrics.monte_carlo.accumulator import Accumulator
from trackmetrics.monte_carlo.choice import Best
from trackmetrics.monte_carlo.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.labels import LabelAccumulator, LabelSummary
from trackmetrics.monte_carlo.point_sets import PointSetAccumulator, PointSetSummary
from trackmetrics.monte_carlo.results import SweepResult
from trackmetrics.monte_carlo.scores import ScoreAccumulator
from trackmetrics.monte_carlo.statistics import ConsistencySummary, FormStatistics
from trackmetrics.monte_carlo.sweep import SweepInterrupted, sweep
from trackmetrics.monte_carlo.tally import Failure

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
