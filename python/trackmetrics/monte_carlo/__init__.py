"""Monte Carlo sweeps: many runs over a grid of settings, and accumulators that can be merged.

The same seed gives the same bits, however the runs are divided among workers and in whatever order
they are done.
"""

from trackmetrics import _deprecated
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.labels import LabelAccumulator, LabelSummary
from trackmetrics.monte_carlo.accumulators.point_sets import PointSetAccumulator, PointSetSummary
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.consistency_summary import ConsistencySummary, ErrorStatistics
from trackmetrics.monte_carlo.results import SweepResult
from trackmetrics.monte_carlo.selection import BestSetting
from trackmetrics.monte_carlo.setting_state import Failure
from trackmetrics.monte_carlo.sweep import SweepInterrupted, sweep

__all__ = [
    "Accumulator",
    "BestSetting",
    "ConsistencyAccumulator",
    "ConsistencySummary",
    "ErrorStatistics",
    "Failure",
    "LabelAccumulator",
    "LabelSummary",
    "PointSetAccumulator",
    "PointSetSummary",
    "ScoreAccumulator",
    "SweepInterrupted",
    "SweepResult",
    "sweep",
]

__getattr__ = _deprecated.module_getattr(__name__)
