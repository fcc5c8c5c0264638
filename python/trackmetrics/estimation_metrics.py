"""The functions of ``pytcl.performance_evaluation.estimation_metrics``, under its module path."""

from trackmetrics.accuracy import (
    estimation_error_bounds,
    monte_carlo_rmse,
    position_rmse,
    rmse,
    velocity_rmse,
)
from trackmetrics.consistency import (
    average_nees,
    consistency_test,
    credibility_interval,
    nees,
    nees_sequence,
    nis,
    nis_sequence,
)
from trackmetrics.results import ConsistencyResult

__all__ = [
    "ConsistencyResult",
    "average_nees",
    "consistency_test",
    "credibility_interval",
    "estimation_error_bounds",
    "monte_carlo_rmse",
    "nees",
    "nees_sequence",
    "nis",
    "nis_sequence",
    "position_rmse",
    "rmse",
    "velocity_rmse",
]
