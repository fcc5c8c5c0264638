"""Between columns and Polars: the only file that knows how Polars holds them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.columns import Ragged


def polars() -> Any:
    """The module, or None where it is not installed."""
    try:
        import polars
    except ImportError:
        return None
    return polars


def need_polars(for_what: str) -> Any:
    """The module; an error that names the extra where it is not installed."""
    found = polars()
    if found is None:
        raise ModuleNotFoundError(
            f"{for_what} needs Polars: pip install 'trackmetrics[files]'", name="polars"
        )
    return found


def to_array(series: Any) -> Any:
    """A column as float64 (missing: NaN), text (missing: None), datetime64 or :class:`Ragged`."""
    pl = polars()
    kind = series.dtype
    if isinstance(kind, pl.List | pl.Array):
        return _ragged(series)
    if kind.is_numeric() or kind == pl.Boolean:
        values = series.cast(pl.Float64).to_numpy()
        return np.ascontiguousarray(values, np.float64)
    if kind == pl.Null:
        return np.full(len(series), np.nan)
    if kind.is_temporal():
        return series.to_numpy()
    return np.array(series.to_list(), object)


def _ragged(series: Any) -> Ragged:
    pl = polars()
    nested = isinstance(series.dtype.inner, pl.List | pl.Array)
    if nested:
        inner = series.explode()
        sizes = _lengths(inner)
        counts = _lengths(series)
        owner = np.repeat(np.arange(len(series)), np.maximum(counts, 1))
        lengths = np.bincount(owner, weights=sizes, minlength=len(series)).astype(np.int64)
        flat = inner.filter(pl.Series(sizes > 0)).explode()
    else:
        lengths = _lengths(series)
        flat = series.filter(pl.Series(lengths > 0)).explode()
    return Ragged(to_array(flat), lengths, nested)


def _lengths(series: Any) -> NDArray[np.int64]:
    pl = polars()
    if isinstance(series.dtype, pl.Array):
        series = series.arr.to_list()
    lengths: NDArray[np.int64] = series.list.len().fill_null(0).to_numpy().astype(np.int64)
    return lengths


def data_frame(columns: Mapping[str, Any]) -> Any:
    """A Polars data frame of columns."""
    return polars().DataFrame({name: from_array(column) for name, column in columns.items()})


def from_array(column: Any) -> Any:
    """A Polars series of a column; NaN and None become null."""
    pl = polars()
    if isinstance(column, Ragged):
        return _lists(column)
    if column.dtype == object:
        return pl.Series(column.tolist(), dtype=pl.String)
    series = pl.Series(column)
    return series.fill_nan(None) if column.dtype.kind == "f" else series


def _lists(column: Ragged) -> Any:
    """One list a row, null where it is empty, without a loop over the rows."""
    pl = polars()
    values = from_array(column.flat)
    same = column.lengths[0] if len(column) else 0
    if len(column) and same and (column.lengths == same).all():
        return values.reshape((len(column), int(same))).cast(pl.List(values.dtype))
    rows = np.repeat(np.arange(len(column)), column.lengths)
    frame = pl.DataFrame({"row": rows, "value": values})
    lists = frame.group_by("row", maintain_order=True).agg("value")
    every = pl.DataFrame({"row": np.arange(len(column))})
    return every.join(lists, on="row", how="left", maintain_order="left")["value"]
