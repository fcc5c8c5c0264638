"""The NumPy reference implementations of the Rust kernels: same names, same parameters, same
errors, same numbers.

Each is short enough to be the explanation of its kernel. The files are the modules of the Rust
core, so the listing of this folder is the list of kernels.
"""

from trackmetrics._numpy.accuracy import (
    estimation_error_bounds,
    monte_carlo_rmse,
    position_rmse,
    rmse,
    velocity_rmse,
)
from trackmetrics._numpy.assignment import (
    auction,
    bottleneck_assignment,
    linear_sum_assignment,
    linear_sum_assignment_batch,
)
from trackmetrics._numpy.clear_mot import (
    clear_mot,
)
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
    first_alarms,
    nees_inflation,
    sampled_shapley_shares,
    scale_partitions,
    shapley_shares,
)
from trackmetrics._numpy.distances import (
    mahalanobis_distances,
    point_distances,
)
from trackmetrics._numpy.identities import (
    hota,
    identities,
)
from trackmetrics._numpy.monte_carlo import (
    consistency_sums,
    histograms,
    run_sums,
)
from trackmetrics._numpy.noise_likelihood import (
    noise_likelihood,
)
from trackmetrics._numpy.point_sets import (
    gospa,
    gospa_from_distances,
    gospa_over_time,
    ospa,
    ospa_assignment,
    ospa_from_distances,
    ospa_over_time,
)
from trackmetrics._numpy.settings import (
    set_simd,
    set_threads,
    simd,
    threads,
)
from trackmetrics._numpy.similar_pairs import (
    box_pairs,
    matrix_pairs,
    position_pairs,
)
from trackmetrics._numpy.tracking import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)
from trackmetrics._numpy.trajectories import (
    ospa2,
)
from trackmetrics._numpy.vessel import (
    vessel_advance,
    vessel_filter,
    vessel_gate,
    vessel_predict,
)
from trackmetrics._version import (
    __version__,
)

__all__ = [
    "__version__",
    "auction",
    "best_split_gains",
    "bottleneck_assignment",
    "box_pairs",
    "clear_mot",
    "consistency_sums",
    "credibility_interval",
    "estimation_error_bounds",
    "first_alarms",
    "gospa",
    "gospa_from_distances",
    "gospa_over_time",
    "histograms",
    "hota",
    "identities",
    "identity_switches",
    "linear_sum_assignment",
    "linear_sum_assignment_batch",
    "mahalanobis_distances",
    "matrix_pairs",
    "mean_statistic",
    "monte_carlo_rmse",
    "mot_metrics",
    "nees",
    "nees_inflation",
    "nees_sequence",
    "nis",
    "nis_sequence",
    "noise_likelihood",
    "ospa",
    "ospa2",
    "ospa_assignment",
    "ospa_from_distances",
    "ospa_over_time",
    "point_distances",
    "position_pairs",
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
