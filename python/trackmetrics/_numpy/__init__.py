"""The NumPy twins of the Rust kernels: same names, same parameters, same errors, same numbers.

Each is short enough to be the explanation of its kernel. The files are the rooms of the Rust core,
so the listing of this folder is the list of kernels.
"""

from trackmetrics._numpy.accuracy import (
    estimation_error_bounds,
    monte_carlo_rmse,
    position_rmse,
    rmse,
    velocity_rmse,
)
from trackmetrics._numpy.assignment import bottleneck_assignment, linear_sum_assignment
from trackmetrics._numpy.consistency import (
    credibility_interval,
    mean_statistic,
    nees,
    nees_sequence,
    nis,
    nis_sequence,
)
from trackmetrics._numpy.diagnostics import (
    best_split_gains,
    nees_inflation,
    sampled_shapley_shares,
    scale_partitions,
    shapley_shares,
)
from trackmetrics._numpy.monte_carlo import consistency_sums, histograms, run_sums
from trackmetrics._numpy.point_sets import ospa, ospa_over_time
from trackmetrics._numpy.settings import set_simd, set_threads, simd, threads
from trackmetrics._numpy.tracking import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)
from trackmetrics._numpy.vessel import (
    vessel_advance,
    vessel_filter,
    vessel_gate,
    vessel_predict,
)
from trackmetrics._version import __version__

__all__ = [
    "__version__",
    "best_split_gains",
    "bottleneck_assignment",
    "consistency_sums",
    "credibility_interval",
    "estimation_error_bounds",
    "histograms",
    "identity_switches",
    "linear_sum_assignment",
    "mean_statistic",
    "monte_carlo_rmse",
    "mot_metrics",
    "nees",
    "nees_inflation",
    "nees_sequence",
    "nis",
    "nis_sequence",
    "ospa",
    "ospa_over_time",
    "position_rmse",
    "rmse",
    "run_sums",
    "sampled_shapley_shares",
    "scale_partitions",
    "set_simd",
    "set_threads",
    "shapley_shares",
    "simd",
    "threads",
    "track_fragmentation",
    "track_purity",
    "velocity_rmse",
    "vessel_advance",
    "vessel_filter",
    "vessel_gate",
    "vessel_predict",
]
