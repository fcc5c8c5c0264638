"""The names of ``pytcl.performance_evaluation.track_metrics``, at pytcl's place."""

from trackmetrics.point_sets import ospa, ospa_over_time
from trackmetrics.results import MOTMetrics, OSPAResult
from trackmetrics.tracking import identity_switches, mot_metrics, track_fragmentation, track_purity

__all__ = [
    "MOTMetrics",
    "OSPAResult",
    "identity_switches",
    "mot_metrics",
    "ospa",
    "ospa_over_time",
    "track_fragmentation",
    "track_purity",
]
