"""From a log to the linear model of its prediction errors: F, Q, H, R, corrections, row by row."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._angles import wrap
from trackmetrics._covariances import fill_missing_with_identity
from trackmetrics.diagnostics._noise_fit import ErrorModel, Floats, Integers
from trackmetrics.diagnostics._noise_groups import grouped
from trackmetrics.logs.columns import Columns
from trackmetrics.logs.derived import component_periods
from trackmetrics.logs.log import EstimatorLog

NOT_A_COVARIANCE = 1e-6
"""Relative size of a negative eigenvalue above which a derived noise is no covariance."""


@dataclass(frozen=True)
class LinearModel:
    """The model of a filter, or its Jacobians: what a log without ``A`` or ``H`` does not say.

    ``F`` is an ``(n, n)`` array, a ``(rows, n, n)`` array, or a function of the updated state and
    the time since that update, ``F(x, dt)``. ``H`` is an ``(m, n)`` array, a dictionary of arrays
    by measurement type, or a function of the predicted state and the measurement type,
    ``H(x_pred, measurement_type)``. Either may be None where the log has it.

    >>> LinearModel(F=[[1.0, 1.0], [0.0, 1.0]], H=[[1.0, 0.0]]).H
    [[1.0, 0.0]]
    """

    F: Any = None
    """Transition matrix, or the Jacobian of the motion at the updated state."""
    H: Any = None
    """Observation matrix, or the Jacobian of the measurement at the predicted state."""


@dataclass(frozen=True)
class LogModel:
    """The error model of a log, and where its rows come from."""

    errors: ErrorModel
    rows: Integers
    """Row of the log of each row of the model."""
    tracks: Integers
    """Track of the log of each piece of the model."""
    names: tuple[str, ...]
    """Names of the log's tracks."""
    unwrapped: NDArray[np.bool_]
    """Rows at which the filter used the residual of an angle beyond half its period."""


class NotEnoughError(ValueError):
    """The log does not hold what the likelihood needs; the message says what is missing."""


def log_model(
    log: EstimatorLog,
    process: str | Mapping[str, Sequence[str | int]],
    measurement: str,
    model: LinearModel | None,
) -> LogModel:
    """The error model of a log; raises :class:`NotEnoughError` where something is missing."""
    columns = log.columns
    if columns.innovation is None:
        raise NotEnoughError("the log has no innovations (column innovation, or z and x_pred)")
    types, names = _types(columns, measurement)
    H = _observations(log, model)
    P_pred, P = _covariances(columns, H)
    R = _measurement_noises(columns, H, P_pred)
    F = _transitions(log, model, H, R, P_pred, P)
    Q, linked = _process_noises(log, F, P_pred, P)
    corrections = _corrections(log, H, P_pred)
    usable = _complete(P_pred) & _active(columns)
    known = _complete(corrections)
    pieces, tracks = _pieces(log, usable, linked, known)
    if not pieces:
        raise NotEnoughError("no update of the log has P_pred, H (or observed) and S")
    rows = np.concatenate([np.arange(a, b) for a, b in pieces])
    lengths = [b - a for a, b in pieces]
    starts = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    innovations = _innovations(columns, H, R)
    groups, process_names = grouped(log, Q[rows], process, starts)
    periods = component_periods(columns, log.states, log.measurement_angles)
    assert periods is not None
    errors = ErrorModel(
        innovations=_plain(innovations[rows]),
        H=_plain(np.nan_to_num(H[rows])),
        R=_plain(np.nan_to_num(R[rows])),
        types=types[rows],
        F=_plain(np.nan_to_num(F[rows])),
        Q=_plain(groups),
        corrections=_plain(np.nan_to_num(corrections[rows])),
        periods=_plain(periods[rows, : innovations.shape[1]]),
        initial=_plain(P_pred[rows[starts[:-1]]]),
        starts=starts,
        process=process_names,
        measurement=names,
    )
    unwrapped = _unwrapped(columns, H, P_pred, periods, corrections)[rows]
    return LogModel(errors, rows, np.array(tracks, np.int64), log.tracks, unwrapped)


def _unwrapped(
    columns: Columns, H: Floats, P_pred: Floats, periods: Floats, corrections: Floats
) -> NDArray[np.bool_]:
    """Rows whose correction is that of the residual as it is, not that of the wrapped one."""
    assert columns.innovation is not None
    beyond = np.asarray((np.abs(columns.innovation) > periods / 2).any(axis=1))
    there = _there(columns, H)
    for k in np.flatnonzero(beyond):
        if columns.S is None or np.isnan(P_pred[k]).any():
            continue
        h, S = H[k][there[k]], columns.S[k][np.ix_(there[k], there[k])]
        nu = columns.innovation[k][there[k]]
        gain = np.linalg.solve(S, h @ P_pred[k]).T
        used = np.abs(corrections[k] - gain @ nu).sum()
        inside = np.abs(corrections[k] - gain @ wrap(nu, periods[k][there[k]])).sum()
        beyond[k] = used <= inside
    return beyond


def _complete(column: Floats) -> NDArray[np.bool_]:
    """Which rows lack no element."""
    return np.asarray(~np.isnan(column.reshape(len(column), -1)).any(axis=1))


def _plain(values: Floats) -> Floats:
    return np.ascontiguousarray(values, np.float64)


def _active(columns: Columns) -> NDArray[np.bool_]:
    if columns.status is None:
        return np.ones(len(columns), bool)
    active: NDArray[np.bool_] = columns.status != "tentative"
    return active


def _rejected(columns: Columns) -> NDArray[np.bool_]:
    """Rows whose measurement the filter did not use: they leave its state as predicted."""
    if columns.status is None:
        return np.zeros(len(columns), bool)
    return np.asarray(columns.status == "rejected", np.bool_)


def _types(columns: Columns, measurement: str) -> tuple[Integers, tuple[str, ...]]:
    if measurement not in ("by_type", "all"):
        raise ValueError(f"measurement must be 'by_type' or 'all', got {measurement!r}")
    if measurement == "all" or columns.measurement_type is None:
        return np.zeros(len(columns), np.int64), ("all",)
    listed = [str(kind) for kind in columns.measurement_type]
    names = tuple(dict.fromkeys(listed))
    return np.array([names.index(kind) for kind in listed], np.int64), names


def _observations(log: EstimatorLog, model: LinearModel | None) -> Floats:
    """``(rows, m, n)``: of the log, of the model, or from the states that are observed."""
    columns = log.columns
    assert columns.innovation is not None
    rows, m = columns.innovation.shape
    n = _state_count(log)
    logged = getattr(columns, "H", None)
    H = np.full((rows, m, n), np.nan)
    if logged is not None:
        H[:, : logged.shape[1]] = logged
    if model is not None and model.H is not None:
        _fill_observations(H, columns, model.H)
    if columns.observed is not None:
        picked = columns.observed[:, :m]
        selection = np.where(picked[:, :, None] == np.arange(n), 1.0, 0.0)
        known = (picked >= 0)[:, :, None] & np.isnan(H)
        H = np.where(known, selection, H)
    if np.isnan(H).all():
        raise NotEnoughError("the log has neither H nor observed: give model=LinearModel(H=...)")
    return H


def _state_count(log: EstimatorLog) -> int:
    for name in ("P_pred", "P", "A", "x"):
        column = getattr(log.columns, name)
        if column is not None:
            return int(column.shape[1])
    raise NotEnoughError("the log has no covariance of the state (column P_pred or P)")


def _fill_observations(H: Floats, columns: Columns, given: Any) -> None:
    for k in range(len(H)):
        kind = None if columns.measurement_type is None else columns.measurement_type[k]
        if callable(given):
            if columns.x_pred is None:
                raise NotEnoughError("model.H is a function of x_pred, which the log does not have")
            value = given(columns.x_pred[k], kind)
        else:
            value = given.get(kind) if isinstance(given, Mapping) else given
        if value is None or not np.isnan(H[k]).all():
            continue
        matrix = np.atleast_2d(np.asarray(value, float))
        if matrix.shape[0] > H.shape[1] or matrix.shape[1] != H.shape[2]:
            raise ValueError(
                f"model.H of row {k} has shape {matrix.shape}, "
                f"expected up to {H.shape[1]} rows of {H.shape[2]} states"
            )
        H[k, : len(matrix)] = matrix


def _there(columns: Columns, H: Floats) -> NDArray[np.bool_]:
    """Which components of each row have an innovation and a row of H."""
    assert columns.innovation is not None
    there: NDArray[np.bool_] = ~np.isnan(columns.innovation) & ~np.isnan(H).any(axis=2)
    return there


def _covariances(columns: Columns, H: Floats) -> tuple[Floats, Floats]:
    """Predicted and updated covariances, each from the other where only one was logged."""
    shape = (len(columns), H.shape[2], H.shape[2])
    P_pred = np.full(shape, np.nan) if columns.P_pred is None else columns.P_pred.copy()
    P = np.full(shape, np.nan) if columns.P is None else columns.P.copy()
    there, h = _seen(columns, H)
    if columns.R is not None:
        noise = _complete_or_absent(columns.R, there)
        k = np.flatnonzero(~_complete(P_pred) & _complete(P) & noise)
        gained = _transposed(h[k]) @ np.linalg.solve(
            fill_missing_with_identity(columns.R[k], there[k]), h[k]
        )
        P_pred[k] = np.linalg.inv(np.linalg.inv(P[k]) - gained)
    if columns.S is not None:
        known = _complete_or_absent(columns.S, there)
        P = np.where((_rejected(columns) & ~_complete(P))[:, None, None], P_pred, P)
        k = np.flatnonzero(_complete(P_pred) & ~_complete(P) & known)
        shared = h[k] @ P_pred[k]
        gain = np.linalg.solve(fill_missing_with_identity(columns.S[k], there[k]), shared)
        P[k] = P_pred[k] - _transposed(shared) @ gain
    return P_pred, P


def _seen(columns: Columns, H: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Which components there are, and H with zeros in the rows of the others."""
    there = _there(columns, H)
    return there, np.where(there[:, :, None], H, 0.0)


def _transposed(matrices: Floats) -> Floats:
    return matrices.swapaxes(1, 2)


def _complete_or_absent(matrices: Floats, there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which rows have every element of the components that are there."""
    needed = there[:, :, None] & there[:, None, :]
    return np.asarray(~(np.isnan(matrices) & needed).any(axis=(1, 2)))


def _measurement_noises(columns: Columns, H: Floats, P_pred: Floats) -> Floats:
    """R as logged, or S - H P_pred H'."""
    R = np.full((len(columns), H.shape[1], H.shape[1]), np.nan)
    if columns.S is not None:
        h = np.nan_to_num(H)
        R = columns.S - h @ P_pred @ h.swapaxes(1, 2)
    if columns.R is not None:
        R = np.where(np.isnan(columns.R), R, columns.R)
    return R


def _transitions(
    log: EstimatorLog, model: LinearModel | None, H: Floats, R: Floats, P_pred: Floats, P: Floats
) -> Floats:
    """F of each row from the update before: of the model, or (I - K H)^-1 A."""
    columns = log.columns
    if model is not None and model.F is not None:
        return _given_transitions(log, model.F, P_pred.shape[1])
    if columns.A is None:
        raise NotEnoughError("the log has no A: give model=LinearModel(F=...)")
    there, h = _seen(columns, H)
    F = np.full(P_pred.shape, np.nan)
    k = np.flatnonzero(there.any(axis=1) & _complete_or_absent(R, there) & ~_rejected(columns))
    # (I - K H)^-1 = I + P_pred H' R^-1 H.
    seen = np.linalg.solve(fill_missing_with_identity(R[k], there[k]), h[k] @ columns.A[k])
    F[k] = columns.A[k] + P_pred[k] @ _transposed(h[k]) @ seen
    F[_rejected(columns)] = columns.A[_rejected(columns)]
    k = np.flatnonzero(~there.any(axis=1) & _complete(P) & _complete(P_pred))
    F[k] = P_pred[k] @ np.linalg.solve(P[k], columns.A[k])
    return F


def _given_transitions(log: EstimatorLog, given: Any, n: int) -> Floats:
    columns = log.columns
    if not callable(given):
        matrices = np.broadcast_to(np.asarray(given, float), (len(columns), n, n))
        return matrices.copy()
    F = np.full((len(columns), n, n), np.nan)
    for t in range(len(log.tracks)):
        for k in range(log.rows(t).start + 1, log.rows(t).stop):
            x = None if columns.x is None else columns.x[k - 1]
            F[k] = given(x, float(columns.time[k] - columns.time[k - 1]))
    return F


def _process_noises(
    log: EstimatorLog, F: Floats, P_pred: Floats, P: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Q = P_pred - F P F' of each row from the update before, and where it is known."""
    Q = np.full(P_pred.shape, np.nan)
    Q[1:] = P_pred[1:] - F[1:] @ P[:-1] @ F[1:].swapaxes(1, 2)
    Q[list(log.starts[:-1])] = np.nan
    known = _complete(Q)
    Q = (Q + Q.swapaxes(1, 2)) / 2
    d = np.sqrt(np.where(known[:, None], P_pred.diagonal(axis1=1, axis2=2), 1.0))
    scaled = np.where(known[:, None, None], Q, 0.0) / (d[:, :, None] * d[:, None, :])
    values, vectors = np.linalg.eigh(scaled)
    bad = values[:, 0] < -NOT_A_COVARIANCE
    if bad.any():
        k = int(np.argmax(bad))
        raise ValueError(
            f"P_pred[{log.columns.row[k]}] is smaller than F P F' of the update before: "
            "A (or model.F), P and P_pred do not belong to one filter"
        )
    positive = (vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.swapaxes(1, 2)
    Q[known] = (positive * d[:, :, None] * d[:, None, :])[known]
    return Q, known


def _corrections(log: EstimatorLog, H: Floats, P_pred: Floats) -> Floats:
    """Updated minus predicted state; where not logged, gain times innovation."""
    columns = log.columns
    corrections = np.full(P_pred.shape[:2], np.nan)
    if columns.S is not None and columns.innovation is not None:
        there, h = _seen(columns, H)
        k = np.flatnonzero(_complete(P_pred) & _complete_or_absent(columns.S, there))
        nu = np.where(there[k], columns.innovation[k], 0.0)[..., None]
        whitened = np.linalg.solve(fill_missing_with_identity(columns.S[k], there[k]), nu)
        corrections[k] = (P_pred[k] @ _transposed(h[k]) @ whitened)[..., 0]
        corrections[_rejected(columns)] = 0.0
    if columns.x is not None and columns.x_pred is not None:
        moved = columns.x - columns.x_pred
        if len(log.states):
            periods = np.array([s.period or np.nan for s in log.states])
            moved = wrap(moved, np.broadcast_to(periods, moved.shape))
        corrections = np.where(_complete(moved)[:, None], moved, corrections)
    return corrections


def _innovations(columns: Columns, H: Floats, R: Floats) -> Floats:
    """The innovations whose H and R are known."""
    assert columns.innovation is not None
    known = ~np.isnan(H).any(axis=2) & ~np.isnan(R.diagonal(axis1=1, axis2=2))
    return np.where(known, columns.innovation, np.nan)


def _pieces(
    log: EstimatorLog,
    usable: NDArray[np.bool_],
    linked: NDArray[np.bool_],
    known: NDArray[np.bool_],
) -> tuple[list[tuple[int, int]], list[int]]:
    """Runs of rows of one track, each linked to the row before; and their tracks."""
    pieces, tracks = [], []
    for t in range(len(log.tracks)):
        first = None
        rows = log.rows(t)
        for k in range(rows.start, rows.stop):
            follows = first is not None and usable[k] and linked[k] and known[k - 1]
            if first is not None and not follows:
                pieces.append((first, k))
                tracks.append(t)
                first = None
            if first is None and usable[k]:
                first = k
        if first is not None:
            pieces.append((first, rows.stop))
            tracks.append(t)
    return pieces, tracks
