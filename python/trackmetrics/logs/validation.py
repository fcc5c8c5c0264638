"""What can be wrong with the values of a log, and the message that names the row."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from trackmetrics._covariance_rule import SYMMETRY, failing_minors
from trackmetrics._covariances import (
    fill_missing_with_identity,
    for_blocks,
    row_blocks,
    surely_definite,
)
from trackmetrics._tables.errors import value
from trackmetrics.logs.columns import Columns, Floats, Integers, has_value
from trackmetrics.logs.schema import (
    COVARIANCE_COLUMNS,
    DOF_COLUMNS,
    NUMERIC_COLUMNS,
    SCALAR_COLUMNS,
    STATUSES,
)


def check_values(columns: Columns, timed: bool) -> None:
    """Refuse the first value that no estimator can have logged."""
    if timed and not np.isfinite(columns.time).all():
        row = int(np.argmin(np.isfinite(columns.time)))
        raise ValueError(f"time[{row}] is not finite: {float(columns.time[row])!r}")
    for name in NUMERIC_COLUMNS:
        column = getattr(columns, name)
        if column is not None:
            _check_finite(name, column)
    _check_numbers(columns)
    _check_status(columns)
    _check_something_there(columns)


def _check_finite(name: str, column: Floats) -> None:
    """No infinity; of a matrix a missing component misses its whole row and column,
    of H its row."""
    for block in row_blocks(len(column)):
        part = column[block]
        with np.errstate(over="ignore", invalid="ignore"):
            if np.isfinite(part.sum()):
                continue
        bad = np.isinf(part)
        if part.ndim == 3:
            bad |= np.isnan(part) & ~_missing(name, part)
        if not bad.any():
            continue
        index = np.argwhere(bad)[0]
        index[0] += block.start
        place = "".join(f"[{int(i)}]" for i in index)
        raise ValueError(f"{name}{place} is not finite: {float(column[tuple(index)])!r}")


def _missing(name: str, matrices: Floats) -> NDArray[np.bool_]:
    """Elements of components that are missing altogether; a transition is whole or missing."""
    absent: NDArray[np.bool_] = np.isnan(matrices)
    if name == "H":
        return np.broadcast_to(absent.all(axis=2, keepdims=True), absent.shape)
    gone: NDArray[np.bool_] = np.logical_and(absent.all(axis=2), absent.all(axis=1))
    if name == "A":
        gone = np.logical_and(gone, np.logical_and.reduce(gone, axis=1)[:, None])
    return gone[:, :, None] | gone[:, None, :]


def _check_numbers(columns: Columns) -> None:
    """NIS and NEES are not negative, degrees of freedom are positive and there for every NIS."""
    for name in SCALAR_COLUMNS:
        column = getattr(columns, name)
        if column is None:
            continue
        bad = column <= 0 if name in DOF_COLUMNS else column < 0
        values = getattr(columns, name.removesuffix("_dof"))
        if values is not None:
            bad &= ~np.isnan(values)
        if bad.any():
            row = int(np.argmax(bad))
            needed = "positive" if name in DOF_COLUMNS else "at least 0"
            raise ValueError(f"{name}[{row}] must be {needed}, got {float(column[row])!r}")
    if columns.std is not None and (columns.std < 0).any():
        row, state = (int(i) for i in np.argwhere(columns.std < 0)[0])
        got = float(columns.std[row, state])
        raise ValueError(f"std[{row}][{state}] must be at least 0, got {got!r}")
    if columns.nis is None or columns.innovation is not None or columns.z is not None:
        return
    if columns.nis_dof is None:
        raise ValueError("nis needs its degrees of freedom: give nis_dof")
    lonely = ~np.isnan(columns.nis) & np.isnan(columns.nis_dof)
    if lonely.any():
        raise ValueError(f"nis_dof[{int(np.argmax(lonely))}] is missing, nis is not")


def _check_status(columns: Columns) -> None:
    if columns.status is None:
        return
    bad = ~np.isin(columns.status.astype(str), [*STATUSES, "None"])
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(
            f"status[{row}] must be 'tentative', 'active' or 'rejected', "
            f"got {value(columns.status[row])}"
        )


def _check_something_there(columns: Columns) -> None:
    """A row that holds no value is an error, unless it says that its track is tentative."""
    there = np.zeros(len(columns), bool)
    for name in NUMERIC_COLUMNS:
        column = getattr(columns, name)
        if column is not None and name not in (*DOF_COLUMNS, "H"):
            there |= has_value(column)
    if columns.status is not None:
        there |= columns.status == "tentative"
    if not there.all():
        row = int(np.argmin(there))
        names = [
            n for n in NUMERIC_COLUMNS if n not in DOF_COLUMNS and getattr(columns, n) is not None
        ]
        raise ValueError(
            f"row {row} holds no value ({', '.join(names)} missing): "
            "leave it out, or give its status as 'tentative'"
        )


def check_covariances(columns: Columns) -> None:
    """Every covariance that is there is symmetric and positive definite."""
    for name in COVARIANCE_COLUMNS:
        column = getattr(columns, name)
        if column is None or column.shape[1] == 0:
            continue
        for_blocks(partial(_check_block, name, column, columns.row), len(column))


def _check_block(name: str, column: Floats, row: Integers, block: slice) -> None:
    rows = block.start + np.flatnonzero(has_value(column[block]))
    if len(rows):
        p = column[block] if len(rows) == block.stop - block.start else column[rows]
        _check_symmetric(name, p, row[rows])
        _check_definite(name, p, row[rows])


def _check_symmetric(name: str, p: Floats, rows: Integers) -> None:
    transposed = p.swapaxes(1, 2)
    if (p == transposed).all():
        return
    d = np.sqrt(np.abs(np.einsum("kii->ki", p)))
    bad = np.abs(p - transposed) > SYMMETRY * d[:, :, None] * d[:, None, :]
    if bad.any():
        k, i, j = (int(v) for v in np.argwhere(bad)[0])
        raise ValueError(
            f"{name}[{rows[k]}] is not symmetric: elements [{i}, {j}] and [{j}, {i}] differ"
        )


def _check_definite(name: str, p: Floats, rows: Integers) -> None:
    doubtful = np.flatnonzero(~surely_definite(p))
    minors = failing_minors(fill_missing_with_identity(p[doubtful]))
    if minors.any():
        k = int(np.argmax(minors > 0))
        raise np.linalg.LinAlgError(
            f"{name}[{rows[doubtful[k]]}] is not positive definite (leading minor {minors[k]})"
        )
