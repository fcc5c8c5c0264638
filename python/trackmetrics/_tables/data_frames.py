"""Data frames of other libraries: opened by narwhals, made by pandas."""

from importlib import import_module
from typing import Any


def opened(frame: Any) -> Any:
    """A data frame of pandas, Polars, PyArrow or whatever else narwhals reads."""
    try:
        import narwhals
    except ImportError:
        raise ModuleNotFoundError(
            "data frames need narwhals: pip install 'trackmetrics[frames]'", name="narwhals"
        ) from None
    try:
        return narwhals.from_native(frame, eager_only=True)
    except TypeError:
        raise TypeError(
            "frame must be a data frame of pandas, Polars or PyArrow (a lazy one collected first), "
            f"got {type(frame).__module__}.{type(frame).__qualname__}"
        ) from None


def as_float64(series: Any) -> Any:
    """A column of numbers as float64; what is missing is NaN."""
    import narwhals

    return series.cast(narwhals.Float64).to_numpy()


def pandas() -> Any:
    """The module pandas, imported when a frame is first asked for."""
    try:
        return import_module("pandas")
    except ModuleNotFoundError as error:
        if error.name != "pandas":
            raise
        raise ModuleNotFoundError(
            "this needs pandas: pip install 'trackmetrics[pandas]'", name="pandas"
        ) from None
