"""Columns from data frames and back: pandas, Polars, PyArrow or whatever else narwhals reads."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trackmetrics._tables.data_frames import as_float64, opened, pandas
from trackmetrics._tables.errors import value
from trackmetrics._tables.polars_columns import data_frame, need_polars, polars, to_array
from trackmetrics.logs.serialization import by_element

LIBRARIES = ("polars", "pandas", "pyarrow")


def read(frame: Any) -> dict[str, Any]:
    """The columns of a data frame."""
    native = opened(frame)
    return {name: _column(native[name]) for name in native.columns}


def write(columns: Mapping[str, Any], library: str) -> Any:
    """A data frame of the columns; pandas, which has no lists, gets them element by element."""
    if library == "pandas":
        return pandas().DataFrame(by_element(columns))
    if library not in LIBRARIES:
        raise ValueError(f"library must be one of {', '.join(LIBRARIES)}, got {value(library)}")
    need_polars("to_frame")
    frame = data_frame(columns)
    return frame.to_arrow() if library == "pyarrow" else frame


def _column(series: Any) -> Any:
    kind = series.dtype
    if kind.is_numeric():
        return as_float64(series)
    if kind.is_temporal():
        return series.to_numpy()
    found = _by_polars(series)
    if found is not None:
        return found
    values = series.to_list()
    return np.array(values, object) if set(map(type, values)) <= {str, type(None)} else values


def _by_polars(series: Any) -> Any:
    """Columns of Polars and PyArrow without a Python object for each value; None for others."""
    pl = polars()
    if pl is None:
        return None
    native = series.to_native()
    if isinstance(native, pl.Series):
        return to_array(native)
    return to_array(pl.Series(native)) if type(native).__module__.startswith("pyarrow") else None
