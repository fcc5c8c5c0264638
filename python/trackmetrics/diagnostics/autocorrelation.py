"""The autocorrelation time of the NEES, by which its values are divided before they are tested.

NEES of one run are correlated in time. With e_k = A_k e_(k-1) + d_k the covariance of two NEES
follows from A and P; where these are not logged, the time is estimated from the values.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend
from trackmetrics._covariances import valid_components
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.diagnostics.segmentation import (
    best_partitions,
    select_edges,
    z_scores_within_segments,
)
from trackmetrics.diagnostics.thresholds import MIN_UPDATES_TO_JUDGE
from trackmetrics.diagnostics.trace import Pair, Partitions, Trace
from trackmetrics.logs.columns import Columns, Floats, Integers, has_value

Times = tuple[Floats | float, Partitions | None]
"""The autocorrelation times of the values of a track; its best partitions where they are known."""


def nees_traces(tracks: list[Columns], alpha: float) -> list[Trace | None]:
    """The NEES of every track over its autocorrelation time; None where there is none."""
    rows = [_rows_with_nees(columns) for columns in tracks]
    pairs = [_pair(columns, r) for columns, r in zip(tracks, rows, strict=True)]
    times = _autocorrelation_times(tracks, rows, pairs, alpha)
    return [
        Trace(v / tau, d / tau, r, c.time[r], False, _median(tau), best) if len(r) else None
        for c, (v, d), r, (tau, best) in zip(tracks, pairs, rows, times, strict=True)
    ]


def _rows_with_nees(columns: Columns) -> Integers:
    if columns.nees is None or columns.nees_dof is None:
        return np.empty(0, np.int64)
    return np.flatnonzero(~np.isnan(columns.nees))


def _pair(columns: Columns, rows: Integers) -> Pair:
    if columns.nees is None or columns.nees_dof is None:
        return np.empty(0), np.empty(0)
    return columns.nees[rows], columns.nees_dof[rows]


def _median(tau: Floats | float) -> float:
    """The median, the upper one of two; np.median costs ten times as much."""
    if isinstance(tau, float):
        return tau
    half = len(tau) // 2
    return float(np.partition(tau, half)[half])


def _autocorrelation_times(
    tracks: list[Columns], rows: list[Integers], pairs: list[Pair], alpha: float
) -> list[Times]:
    """From the model where A and P are logged, else from the values."""
    times: list[Times] = [(1.0, None)] * len(rows)
    modelled = [i for i, (c, r) in enumerate(zip(tracks, rows, strict=True)) if _has_model(c, r)]
    if modelled:
        of_model = _from_model([tracks[i] for i in modelled], [rows[i] for i in modelled])
        for i, tau in zip(modelled, of_model, strict=True):
            times[i] = tau, None
    without = set(range(len(rows))) - set(modelled)
    estimated = [i for i in sorted(without) if len(rows[i]) >= MIN_UPDATES_TO_JUDGE]
    of_values = _from_values([pairs[i] for i in estimated], alpha)
    for i, found in zip(estimated, of_values, strict=True):
        times[i] = found
    return times


def _from_model(tracks: list[Columns], rows: list[Integers]) -> list[Floats]:
    """The time of each value, from A and P."""
    steps = np.concatenate([transitions(c, r) for c, r in zip(tracks, rows, strict=True)])
    covariances = np.concatenate([_covariances_at(c, r) for c, r in zip(tracks, rows, strict=True)])
    valid = np.concatenate([_valid_errors(c, r) for c, r in zip(tracks, rows, strict=True)])
    starts = np.concatenate([[0], np.cumsum([len(r) for r in rows])]).astype(np.int64)
    mask = None if valid.all() else valid.astype(np.int64).ravel()
    tau = _backend.kernels.nees_inflation(steps, covariances, starts, mask)
    return [tau[a:b] for a, b in pairwise(starts)]


def _from_values(pairs: list[Pair], alpha: float) -> list[Times]:
    """One time for all values of a track: it scales every gain and moves no change point."""
    best = best_partitions(pairs)
    edges = select_edges(pairs, best, alpha)
    times = correlation_times(z_scores_within_segments(pairs, edges)).tolist()
    return [(t, Partitions(b.gains / t, b.cuts)) for t, b in zip(times, best, strict=True)]


def transitions(columns: Columns, rows: Integers) -> Floats:
    """The A of these updates; 0 (independent) where it is not logged or updates are left out."""
    assert columns.A is not None
    known = has_value(columns.A[rows])
    known[1:] &= np.diff(rows) == 1
    return np.where(known[:, None, None], np.nan_to_num(columns.A[rows]), 0.0)


def _has_model(columns: Columns, rows: Integers) -> bool:
    """Whether P is logged for every NEES and A for most (not for the first, or while tentative)."""
    if columns.A is None or columns.P is None or columns.nees_dof is None or not len(rows):
        return False
    if has_value(columns.A[rows]).mean() <= 0.5 or np.isnan(columns.P[rows]).any():
        return False
    return bool((_valid_errors(columns, rows).sum(axis=1) == columns.nees_dof[rows]).all())


def _covariances_at(columns: Columns, rows: Integers) -> Floats:
    assert columns.P is not None
    return columns.P[rows]


def _valid_errors(columns: Columns, rows: Integers) -> NDArray[np.bool_]:
    """The components of the errors that made these NEES; all where no error is logged."""
    assert columns.P is not None
    every = np.ones((len(rows), columns.P.shape[1]), bool)
    if columns.error is None:
        return every
    valid = valid_components(columns.error[rows], columns.P[rows])
    some = np.logical_or.reduce(valid, axis=1)
    return np.where(some[:, None], valid, every)
