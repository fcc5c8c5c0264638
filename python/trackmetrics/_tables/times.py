"""What stands for a time, as seconds.

Numbers are seconds unless their size says otherwise: Unix milliseconds, microseconds and
nanoseconds are recognised by their magnitude, and so is ``YYYYMMDDHHMMSS``. Text is ISO 8601 (with
or without a zone; without one it is UTC), Go's ``2024-07-09 22:00:00 +0000 UTC``, or a date with
slashes or dots, whose order the whole column decides. Dates become seconds since 1970.
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.errors import value
from trackmetrics._tables.polars_columns import polars

EPOCH = "1970-01-01T00:00:00Z"
UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_RANGES = (("ms", 1e11, 1e14), ("us", 1e14, 1e17), ("ns", 1e17, 1e20))
"""Unix times of the years 1973 to 5138 in each unit."""
_COMPACT = (19_700_101_000_000, 22_000_101_000_000)
_ZONE = r"\s*(Z|UTC|[+-]\d\d:?\d\d)?(?:\s+[A-Z]{3,4})?"
_CLOCK = r"(\d\d?):(\d\d)(?::(\d\d(?:[.,]\d+)?))?"
_YEAR_FIRST = re.compile(rf"^\s*(\d{{4}})[-/](\d\d?)[-/](\d\d?)(?:[T ]{_CLOCK})?{_ZONE}\s*$")
_YEAR_LAST = re.compile(rf"^\s*(\d\d?)[/.-](\d\d?)[/.-](\d{{4}})(?:[T ]{_CLOCK})?{_ZONE}\s*$")


@dataclass(frozen=True, eq=False)
class Times:
    """Times in seconds, and what was found out about them."""

    seconds: NDArray[np.float64]
    epoch: str | None = None
    """Moment of time 0 in ISO 8601; None where the log does not say."""
    note: str = ""
    """What was recognised, for the notes of the log; empty for plain seconds."""


def to_seconds(
    values: Any,
    argument: str = "time",
    unit: str | None = None,
    date_order: str | None = None,
    *,
    strict: bool = True,
) -> Times:
    """Times of any form as seconds; ``unit`` insists on the unit of numbers.

    Text that is no time is an error, or NaN unless ``strict``.
    """
    if date_order not in (None, "dmy", "mdy"):
        raise ValueError(f"date_order must be 'dmy' or 'mdy', got {value(date_order)}")
    array = _as_array(argument, values)
    if array.dtype.kind == "M":
        return Times(_from_datetimes(argument, array), EPOCH)
    if array.dtype.kind in "biuf":
        return _from_numbers(array, unit)
    return _from_text(argument, array, date_order, strict)


def _as_array(argument: str, values: Any) -> NDArray[Any]:
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array: NDArray[Any] = np.asarray(values)
    if array.dtype.kind in "US":
        return array.astype(object)
    if array.dtype != object:
        return array
    present = next((v for v in array.ravel() if v is not None and v == v), None)
    if hasattr(present, "timestamp"):
        return np.array([_naive_utc(v) for v in array], "M8[us]")
    if present is None or isinstance(present, str):
        return array
    try:
        return np.array([np.nan if v is None else float(v) for v in array])
    except (TypeError, ValueError):
        raise ValueError(f"{argument} must hold times, got {value(present)}") from None


def _naive_utc(moment: Any) -> Any:
    """A datetime without its zone, in UTC; None is not a time."""
    if moment is None or moment != moment:
        return np.datetime64("NaT")
    offset = moment.utcoffset()
    if offset is not None:
        moment = (moment - offset).replace(tzinfo=None)
    return np.datetime64(moment.to_datetime64() if hasattr(moment, "to_datetime64") else moment)


def _from_datetimes(argument: str, array: NDArray[Any]) -> NDArray[np.float64]:
    missing = np.isnat(array)
    if missing.any():
        raise ValueError(f"{argument}[{int(np.argmax(missing))}] is missing")
    unit = np.datetime_data(array.dtype)[0]
    if unit not in UNITS:
        array, unit = array.astype("M8[s]"), "s"
    whole = array.astype(np.int64)
    per_second = int(UNITS[unit])
    # Whole seconds and the rest by themselves keep the digits that a float has.
    return whole // per_second + (whole % per_second) / per_second


def _from_numbers(array: NDArray[Any], unit: str | None) -> Times:
    numbers = array.astype(np.float64)
    finite = numbers[np.isfinite(numbers)]
    if unit is not None:
        return Times(numbers)
    if len(finite) and ((finite >= _COMPACT[0]) & (finite < _COMPACT[1])).all():
        text = np.array([f"{v:014.0f}" for v in finite]) if len(finite) < 1000 else None
        seconds = _from_compact(numbers)
        if text is not None or np.isfinite(seconds[np.isfinite(numbers)]).all():
            return Times(seconds, EPOCH, "times are read as YYYYMMDDHHMMSS")
    for name, least, most in _RANGES:
        if len(finite) and ((finite >= least) & (finite < most)).all():
            note = f"times are read as Unix {_NAMES[name]}; time_unit= says otherwise"
            return Times(numbers / UNITS[name], EPOCH, note)
    return Times(numbers)


_NAMES = {"ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}


def _from_compact(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    whole = np.nan_to_num(numbers).astype(np.int64)
    parts = []
    for size in (100, 100, 100, 100, 100):
        whole, part = np.divmod(whole, size)
        parts.append(part.astype(np.float64))
    second, minute, hour, day, month = parts
    seconds = _seconds(whole.astype(np.float64), month, day, hour, minute, second)
    return np.where(np.isnan(numbers), np.nan, seconds)


def _seconds(
    year: NDArray[np.float64],
    month: NDArray[np.float64],
    day: NDArray[np.float64],
    hour: NDArray[np.float64],
    minute: NDArray[np.float64],
    second: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Seconds since 1970; NaN for what is no date."""
    months = ((year - 1970) * 12 + month - 1).astype("M8[M]")
    days = months.astype("M8[D]") + (day - 1).astype("m8[D]")
    valid = (month >= 1) & (month <= 12) & (days.astype("M8[M]") == months) & (day >= 1)
    valid &= (hour < 24) & (minute < 60) & (second < 61)
    clock = hour * 3600.0 + minute * 60.0 + second
    seconds: NDArray[np.float64] = days.astype(np.int64) * 86400.0 + clock
    return np.where(valid, seconds, np.nan)


def _from_text(argument: str, array: NDArray[Any], date_order: str | None, strict: bool) -> Times:
    if all(v is None or _is_number(v) for v in array[:1000]):
        try:
            numbers = np.array([np.nan if v is None else float(v) for v in array])
        except ValueError:
            pass
        else:
            return _from_numbers(numbers, None)
    dates = (v for v in array if _YEAR_FIRST.match(str(v)) or _YEAR_LAST.match(str(v)))
    first = next(dates, "")
    year_last = _YEAR_LAST.match(str(first)) is not None
    groups = _groups(array, _YEAR_LAST if year_last else _YEAR_FIRST)
    a, b, c, hour, minute, second = (groups[:, k] for k in range(6))
    if year_last:
        day, month = _day_and_month(argument, a, b, date_order)
        year = c
    else:
        year, month, day = a, b, c
    clock = (np.nan_to_num(part) for part in (hour, minute, second))
    seconds = _seconds(np.nan_to_num(year), np.nan_to_num(month), np.nan_to_num(day), *clock)
    seconds = seconds - groups[:, 6]
    if strict and np.isnan(seconds).any():
        row = int(np.argmax(np.isnan(seconds)))
        raise ValueError(f"{argument}[{row}] is no time: {value(array[row])}")
    return Times(seconds, EPOCH)


def _is_number(cell: Any) -> bool:
    try:
        float(cell)
    except (TypeError, ValueError):
        return False
    return True


def _day_and_month(
    argument: str, a: NDArray[np.float64], b: NDArray[np.float64], order: str | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Which of the two numbers is the day: one that is above 12 somewhere."""
    first, second = bool((a > 12).any()), bool((b > 12).any())
    if order is None and first == second:
        why = "both are above 12 somewhere" if first else "neither is ever above 12"
        raise ValueError(
            f"{argument}: day and month cannot be told apart ({why}): give date_order='dmy' or "
            "date_order='mdy'"
        )
    day_first = order == "dmy" if order is not None else first
    return (a, b) if day_first else (b, a)


def _groups(array: NDArray[Any], pattern: re.Pattern[str]) -> NDArray[np.float64]:
    """``(rows, 7)``: three numbers of the date, hour, minute, second, zone in seconds."""
    pl = polars()
    if pl is None:
        rows = [pattern.match(str(v)) for v in array]
        nothing = (None,) * 7
        cells = [m.groups() if m else nothing for m in rows]
        numbers = [[_number(c) for c in row[:6]] + [_offset(row[6])] for row in cells]
        return np.array(numbers, np.float64).reshape(len(array), 7)
    series = pl.Series(array.tolist(), dtype=pl.String)
    # Rust's regular expressions do not know Python's ``\Z``; these patterns are common to both.
    frame = series.str.extract_groups(pattern.pattern).struct.unnest()
    parts = [
        frame[name].str.replace(",", ".", literal=True).cast(pl.Float64, strict=False)
        for name in frame.columns[:6]
    ]
    zone = frame[frame.columns[6]]
    known = zone.unique().to_list()
    offsets = zone.replace_strict(known, [_offset(z) for z in known], return_dtype=pl.Float64)
    return np.column_stack([part.to_numpy() for part in [*parts, offsets]])


def _number(cell: str | None) -> float:
    return np.nan if cell is None else float(cell.replace(",", "."))


def _offset(zone: str | None) -> float:
    """Seconds that a zone is ahead of UTC."""
    if zone in (None, "Z", "UTC"):
        return 0.0
    assert zone is not None
    digits = zone[1:].replace(":", "")
    seconds = int(digits[:2]) * 3600 + int(digits[2:]) * 60
    return float(-seconds if zone[0] == "-" else seconds)
