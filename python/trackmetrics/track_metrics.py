"""The names of ``pytcl.performance_evaluation.track_metrics``, at pytcl's place."""

from trackmetrics.point_sets import ospa, ospa_over_time
from trackmetrics.results import OSPAResult

__all__ = [
    "OSPAResult",
    "ospa",
    "ospa_over_time",
]
