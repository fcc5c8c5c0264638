"""What a format can hold of a track table, checked before a file is written."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def refuse_others(title: str, columns: Mapping[str, Any], held: Collection[str]) -> None:
    """Refuse a table with a column that the format does not hold."""
    names = [name for name, column in columns.items() if column is not None and name != "other"]
    for name in (*names, *columns["other"]):
        if name not in held:
            raise ValueError(
                f"{title} files have no column {name}: leave it out with table.without({name!r})"
            )


def whole(name: str, column: NDArray[Any]) -> NDArray[np.int64]:
    """A column of whole numbers; an error that names the first row with anything else."""
    if column.dtype.kind in "iu":
        return column.astype(np.int64)
    for row, value in enumerate(column.tolist()):
        if isinstance(value, bool) or not isinstance(value, int | float) or value != int(value):
            raise ValueError(f"{name}[{row}] must be a whole number in this format, got {value!r}")
    return column.astype(np.int64)


def column_or(column: Any, length: int, default: float) -> NDArray[Any]:
    """A column, or a default for each row where there is none."""
    if column is None:
        return np.full(length, default)
    array: NDArray[Any] = np.asarray(column)
    if array.dtype.kind == "f":
        wrong = np.flatnonzero(~np.isfinite(array))
        if len(wrong):
            row = int(wrong[0])
            raise ValueError(f"row {row}: a text file needs a finite number, got {array[row]}")
    return array
