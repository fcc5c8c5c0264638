"""Columns out of data frames (pandas, Polars, PyArrow: whatever narwhals reads), and back."""

from typing import Any

import numpy as np

from trackmetrics._tables.data_frames import as_float64, opened


def columns(frame: Any) -> dict[str, Any]:
    """Each column as an array; whole numbers and dates keep their kind."""
    native = opened(frame)
    return {name: _column(native[name]) for name in native.columns}


def _column(series: Any) -> Any:
    kind = series.dtype
    if kind.is_integer() and not series.null_count():
        return series.to_numpy().astype(np.int64)
    if kind.is_numeric():
        return np.asarray(as_float64(series), dtype=np.float64)
    if kind.is_temporal():
        return series.to_numpy()
    return np.array(series.to_list(), dtype=object)
