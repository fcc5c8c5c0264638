"""Columns from data frames: pandas, Polars, PyArrow or whatever else narwhals reads."""

from typing import Any

import numpy as np

from trackmetrics._tables.polars_columns import polars, to_array


def read(frame: Any) -> dict[str, Any]:
    """The columns of a data frame."""
    import narwhals

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
    if kind.is_numeric():
        return series.cast(_float64()).to_numpy()
    if kind.is_temporal():
        return series.to_numpy()
    pl = polars()
    if pl is not None and kind.is_nested():
        return to_array(pl.Series(series.to_list()))
    values = series.to_list()
    return (
        np.array(values, object) if all(isinstance(v, str) or v is None for v in values) else values
    )


def _float64() -> Any:
    import narwhals

    return narwhals.Float64
