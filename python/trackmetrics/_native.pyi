"""The Rust kernels, as Python sees them; ``_numpy`` has a reference implementation of each."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.results import OSPAResult

__version__: str

def auction(
    cost_matrix: NDArray[np.float64], epsilon: float | None, maximize: Any
) -> tuple[NDArray[np.int64], NDArray[np.int64], float, float]: ...
def first_alarms(
    values: NDArray[np.float64],
    dof: NDArray[np.float64],
    starts: NDArray[np.int64],
    scale: float,
    alpha: float,
) -> NDArray[np.int64]: ...
def best_split_gains(
    draws: NDArray[np.float64], dof: NDArray[np.float64], least: int
) -> NDArray[np.float64]: ...
def bottleneck_assignment(
    cost_matrix: NDArray[np.float64],
) -> tuple[float, NDArray[np.int64], NDArray[np.int64]]: ...
def consistency_sums(
    truth: Any,
    estimates: Any,
    covariances: Any,
    periods: Any,
    first_run: int,
    decibels: float,
    thresholds: Any,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]: ...
def credibility_interval(
    errors: Any, covariances: Any, threshold: float, symmetry: float
) -> float: ...
def estimation_error_bounds(covariances: Any, sigma: float) -> Any: ...
def gospa(
    x: Any, y: Any, c: float, p: float, alpha: float
) -> tuple[tuple[float, float, float, float, int, int], NDArray[np.int64]]: ...
def gospa_from_distances(
    distances: NDArray[np.float64], c: float, p: float, alpha: float
) -> tuple[tuple[float, float, float, float, int, int], NDArray[np.int64]]: ...
def gospa_over_time(
    x: Any, y: Any, c: float, p: float, alpha: float
) -> tuple[list[NDArray[np.float64]], list[NDArray[np.int64]]]: ...
def histograms(values: Any) -> NDArray[np.int64]: ...
def identity_switches(
    true_labels: NDArray[np.int64],
    estimated_labels: NDArray[np.int64],
    time_indices: NDArray[np.int64] | None,
) -> int: ...
def linear_sum_assignment(
    cost_matrix: NDArray[np.float64], maximize: Any
) -> tuple[NDArray[np.int64], NDArray[np.int64]]: ...
def linear_sum_assignment_batch(costs: Any, maximize: Any) -> Any: ...
def mahalanobis_distances(
    x: Any, y: Any, covariances: NDArray[np.float64]
) -> NDArray[np.float64]: ...
def mean_statistic(nees_or_nis_values: Any) -> tuple[float, int]: ...
def monte_carlo_rmse(errors: Any, axes: Any) -> Any: ...
def mot_metrics(
    ground_truth: Any, estimates: Any, threshold: float
) -> tuple[float, float, int, int, int, int]: ...
def nees(
    true_state: Any,
    estimated_state: Any,
    covariance: Any,
    symmetry: float,
    periods: Any,
    nan_where_invalid: bool,
) -> Any: ...
def nees_inflation(
    transitions: NDArray[np.float64],
    covariances: NDArray[np.float64],
    starts: NDArray[np.int64],
    known: NDArray[np.int64] | None,
) -> NDArray[np.float64]: ...
def nees_sequence(
    true_states: Any,
    estimated_states: Any,
    covariances: Any,
    symmetry: float,
    periods: Any,
    nan_where_invalid: bool,
) -> Any: ...
def nis(
    innovation: Any,
    innovation_covariance: Any,
    symmetry: float,
    periods: Any,
    nan_where_invalid: bool,
) -> Any: ...
def nis_sequence(
    innovations: Any,
    innovation_covariances: Any,
    symmetry: float,
    periods: Any,
    nan_where_invalid: bool,
) -> Any: ...
def noise_likelihood(
    innovations: NDArray[np.float64],
    observations: NDArray[np.float64],
    measurement_noises: NDArray[np.float64],
    types: NDArray[np.int64],
    transitions: NDArray[np.float64],
    process_noises: NDArray[np.float64],
    corrections: NDArray[np.float64],
    periods: NDArray[np.float64],
    initial: NDArray[np.float64],
    starts: NDArray[np.int64],
    process_factors: NDArray[np.float64],
    measurement_factors: NDArray[np.float64],
    initial_factor: float,
    tail_dof: float,
    tail_scales: NDArray[np.float64],
    derivatives: bool,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def ospa(x: Any, y: Any, c: float, p: float) -> OSPAResult: ...
def ospa2(
    truth: Any,
    truth_steps: NDArray[np.int64],
    tracks: Any,
    track_steps: NDArray[np.int64],
    first: NDArray[np.int64],
    beyond: NDArray[np.int64],
    c: float,
    p: float,
    q: float,
    base: str,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
def ospa_assignment(x: Any, y: Any, c: float, p: float) -> NDArray[np.int64]: ...
def ospa_from_distances(distances: NDArray[np.float64], c: float, p: float) -> OSPAResult: ...
def ospa_over_time(x: Any, y: Any, c: float, p: float) -> NDArray[np.float64]: ...
def point_distances(x: Any, y: Any, metric: str) -> NDArray[np.float64]: ...
def position_rmse(true_states: Any, estimated_states: Any, position_indices: Any) -> float: ...
def rmse(true_states: Any, estimated_states: Any, axes: Any) -> Any: ...
def run_sums(values: Any, first_run: int) -> NDArray[np.float64]: ...
def sampled_shapley_shares(
    errors: NDArray[np.float64], covariances: NDArray[np.float64], orders: NDArray[np.int64]
) -> NDArray[np.float64]: ...
def scale_partitions(
    values: NDArray[np.float64],
    dof: NDArray[np.float64],
    starts: NDArray[np.int64],
    least: int,
    most: int,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]: ...
def set_simd(width: str) -> None: ...
def set_threads(threads: int) -> None: ...
def shapley_shares(
    errors: NDArray[np.float64], covariances: NDArray[np.float64]
) -> NDArray[np.float64]: ...
def simd() -> str: ...
def threads() -> int: ...
def track_fragmentation(
    true_labels: NDArray[np.int64],
    estimated_labels: NDArray[np.int64],
    time_indices: NDArray[np.int64] | None,
) -> int: ...
def track_purity(true_labels: NDArray[np.int64], estimated_labels: NDArray[np.int64]) -> float: ...
def velocity_rmse(true_states: Any, estimated_states: Any, velocity_indices: Any) -> float: ...
def vessel_advance(
    x: NDArray[np.float64],
    times: NDArray[np.float64],
    motion: tuple[float, float, float, float],
) -> NDArray[np.float64]: ...
def vessel_filter(
    life: NDArray[np.float64],
    x: NDArray[np.float64],
    P: NDArray[np.float64],
    starts: NDArray[np.int64],
    times: NDArray[np.float64],
    z: NDArray[np.float64],
    observed: NDArray[np.int64],
    sigmas: NDArray[np.float64],
    motion: tuple[float, float, float, float],
    rules: tuple[int, float, bool, float],
) -> tuple[tuple[Any, ...], tuple[Any, ...]]: ...
def vessel_gate(
    x: NDArray[np.float64],
    P: NDArray[np.float64],
    times: NDArray[np.float64],
    z: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    gate: float,
    motion: tuple[float, float, float, float],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]: ...
def vessel_predict(
    x: NDArray[np.float64],
    P: NDArray[np.float64],
    times: NDArray[np.float64],
    motion: tuple[float, float, float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...

_Codes = NDArray[np.int64]
_Floats = NDArray[np.float64]
_SideColumns = tuple[_Codes, _Codes, int]
_PairColumns = tuple[_Codes, _Codes, _Floats, _Floats]

def box_pairs(
    truth: _Floats, tracks: _Floats, truth_starts: _Codes, track_starts: _Codes, keep_all: bool
) -> _PairColumns: ...
def clear_mot(
    truth: _SideColumns,
    tracks: _SideColumns,
    pairs: _PairColumns,
    rules: tuple[bool, bool, bool],
    limit: float,
) -> tuple[_Codes, _Floats, _Codes, _Codes, float]: ...
def hota(
    truth: _SideColumns, tracks: _SideColumns, pairs: _PairColumns, thresholds: _Floats
) -> tuple[_Codes, _Floats, _Floats, _Floats, _Floats]: ...
def identities(
    truth: _SideColumns, tracks: _SideColumns, pairs: _PairColumns, by_distance: bool, limit: float
) -> tuple[_Codes, _Codes, _Codes, _Codes, int]: ...
def matrix_pairs(
    matrices: _Floats, truth_starts: _Codes, track_starts: _Codes, keep_all: bool
) -> _PairColumns: ...
def position_pairs(
    truth: _Floats, tracks: _Floats, truth_starts: _Codes, track_starts: _Codes, threshold: float
) -> _PairColumns: ...
