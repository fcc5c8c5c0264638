"""Columns out of data frames (pandas, Polars, PyArrow: whatever narwhals reads), and back."""

from typing import Any

import numpy as np


def columns(frame: Any) -> dict[str, Any]:
    """Each column as an array; whole numbers and dates keep their kind."""
    try:
        import narwhals
    except ImportError:
        raise ModuleNotFoundError(
            "data frames need narwhals: pip install 'trackmetrics[frames]'", name="narwhals"
        ) from None
    try:
        native = narwhals.from_native(frame, eager_only=True)
    except TypeError:
        raise TypeError(
            "frame must be a data frame of pandas, Polars or PyArrow (a lazy one collected first), "
            f"got {type(frame).__module__}.{type(frame).__qualname__}"
        ) from None
    return {name: _column(native[name]) for name in native.columns}


def _column(series: Any) -> Any:
    kind = series.dtype
    if kind.is_integer() and not series.null_count():
        return series.to_numpy().astype(np.int64)
    if kind.is_numeric():
        import narwhals

        return np.asarray(series.cast(narwhals.Float64).to_numpy(), dtype=np.float64)
    if kind.is_temporal():
        return series.to_numpy()
    return np.array(series.to_list(), dtype=object)
