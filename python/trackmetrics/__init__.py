"""Metrics and consistency diagnostics for target tracking and state estimation.

A Rust core under a thin Python package: the functions of ``pytcl.performance_evaluation`` with the
same names and the same numbers. Truth comes first, then estimates; what is undefined is NaN.

>>> import trackmetrics
>>> trackmetrics.ospa([[0.0, 0.0], [10.0, 10.0]], [[1.0, 0.0], [10.0, 11.0]], c=100, p=2).ospa
1.0
"""

from trackmetrics._backend import backend, set_threads, threads, use_backend
from trackmetrics._version import __version__
from trackmetrics.accuracy import (
    estimation_error_bounds,
    monte_carlo_rmse,
    position_rmse,
    rmse,
    velocity_rmse,
)
from trackmetrics.assignment import (
    auction,
    bottleneck_assignment,
    linear_sum_assignment,
    linear_sum_assignment_batch,
)
from trackmetrics.compat import patch_pytcl, unpatch_pytcl
from trackmetrics.consistency import (
    average_nees,
    consistency_test,
    credibility_interval,
    nees,
    nees_sequence,
    nis,
    nis_sequence,
)
from trackmetrics.mospa import calc_mospa_error, mmospa2tar_2d, mmospa_approx
from trackmetrics.point_sets import ospa, ospa_over_time
from trackmetrics.results import (
    AuctionAssignment,
    BottleneckAssignment,
    ConsistencyResult,
    MOTMetrics,
    OSPAResult,
)
from trackmetrics.tracking import identity_switches, mot_metrics, track_fragmentation, track_purity

__all__ = [
    "AuctionAssignment",
    "BottleneckAssignment",
    "ConsistencyResult",
    "MOTMetrics",
    "OSPAResult",
    "__version__",
    "auction",
    "average_nees",
    "backend",
    "bottleneck_assignment",
    "calc_mospa_error",
    "consistency_test",
    "credibility_interval",
    "estimation_error_bounds",
    "identity_switches",
    "linear_sum_assignment",
    "linear_sum_assignment_batch",
    "mmospa2tar_2d",
    "mmospa_approx",
    "monte_carlo_rmse",
    "mot_metrics",
    "nees",
    "nees_sequence",
    "nis",
    "nis_sequence",
    "ospa",
    "ospa_over_time",
    "patch_pytcl",
    "position_rmse",
    "rmse",
    "set_threads",
    "threads",
    "track_fragmentation",
    "track_purity",
    "unpatch_pytcl",
    "use_backend",
    "velocity_rmse",
]
