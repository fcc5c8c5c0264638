"""The columns of a log as files hold them: lists without missing ends, covariances as triangles.

Only what was logged is written; what was computed is computed again when the file is read, so that
a computed value never passes for evidence of what the estimator did.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.columns import Ragged, from_padded
from trackmetrics.logs.columns import Columns, Floats
from trackmetrics.logs.schema import (
    COVARIANCE_COLUMNS,
    OBSERVATION_COLUMNS,
    SCALAR_COLUMNS,
    STRING_COLUMNS,
)


def to_table(
    columns: Columns, tracks: Sequence[str], starts: Sequence[int], logged: Mapping[str, Any]
) -> dict[str, Any]:
    """Every column that was logged in some row, in the order of a file."""
    table: dict[str, Any] = {
        "track": np.repeat(np.array(tracks, object), np.diff(starts)),
        "time": columns.time,
    }
    for name in STRING_COLUMNS:
        column = getattr(columns, name)
        if column is not None:
            table[name] = column
    if columns.observed is not None:
        observed = columns.observed
        width = np.arange(1, observed.shape[1] + 1)
        lengths = np.where(observed >= 0, width, 0).max(axis=1, initial=0)
        table["observed"] = Ragged(observed[width <= lengths[:, None]], lengths)
    for name, rows in logged.items():
        if rows.any():
            table[name] = _cells(name, getattr(columns, name), rows)
    return table


def _cells(name: str, column: Floats, rows: NDArray[np.bool_]) -> Any:
    """The values of a column in the rows that were logged."""
    if not rows.all():
        column = np.where(rows.reshape((-1,) + (1,) * (column.ndim - 1)), column, np.nan)
    if name in SCALAR_COLUMNS:
        return column
    if column.ndim == 2:
        return from_padded(column)
    if name in OBSERVATION_COLUMNS:
        return from_padded(column.reshape(len(column), -1))
    return _matrices(column, name in COVARIANCE_COLUMNS)


def _matrices(column: Floats, is_symmetric: bool) -> Ragged:
    """Each matrix up to its last component, as its upper triangle where it is symmetric."""
    n = column.shape[1]
    diagonal = np.einsum("kii->ki", column)
    i, j = np.triu_indices(n) if is_symmetric else map(np.ravel, np.indices((n, n)))
    elements = np.take(column.reshape(len(column), -1), i * n + j, axis=1)
    if n and not np.isnan(diagonal[:, -1]).any():
        return Ragged(elements.ravel(), np.full(len(column), elements.shape[1]))
    sizes = np.where(np.isnan(diagonal), 0, np.arange(1, n + 1)).max(axis=1, initial=0)
    kept = np.maximum(i, j) < sizes[:, None]
    return Ragged(elements[kept], kept.sum(axis=1))


def by_element(columns: Mapping[str, Any]) -> dict[str, Any]:
    """The columns with each list element by element: ``x[0]``, ``x[1]``, ..."""
    flat: dict[str, Any] = {}
    for name, column in columns.items():
        if isinstance(column, Ragged):
            flat |= {f"{name}[{i}]": part for i, part in enumerate(_elements(column))}
        else:
            flat[name] = column
    return flat


def _elements(column: Ragged) -> Any:
    """The columns of the elements; a whole number stays one where other rows are shorter."""
    width = int(column.lengths.max(initial=0))
    if column.flat.dtype.kind != "i":
        return column.padded(width, np.nan).T
    padded = column.padded(width, 0).T.astype(str).astype(object)
    return [np.where(column.lengths > i, part, None) for i, part in enumerate(padded)]
