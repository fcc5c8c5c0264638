"""What stands for a time, as seconds.

Numbers are seconds unless their size says otherwise: Unix milliseconds, microseconds and
nanoseconds are recognised by their magnitude, and so is ``YYYYMMDDHHMMSS``. Text is ISO 8601 (with
or without a zone; without one it is UTC), Go's ``2024-07-09 22:00:00 +0000 UTC``, or a date with
slashes or dots, whose order the whole column decides. Dates become seconds since 1970.
"""

import datetime
import re
from collections.abc import Callable
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
_ZONE = r"\s*(Z|UTC|[+-]\d\d(?::?\d\d)?)?(?:\s+[A-Z]{3,4})?\s*$"
_CLOCK = r"(?:[T ]\s*(\d\d?):(\d\d)(?::(\d\d(?:[.,]\d+)?))?\s*([AaPp][Mm])?)?"
_COMPACT_CLOCK = r"(?:T(\d\d)(\d\d)(\d\d(?:[.,]\d+)?)?([AaPp][Mm])?)"
_FORMS = {
    "year first": rf"^\s*(\d{{4}})[-/.](\d\d?)[-/.](\d\d?){_CLOCK}{_ZONE}",
    "year last": rf"^\s*(\d\d?)[/.-](\d\d?)[/.-](\d{{4}}){_CLOCK}{_ZONE}",
    "month by name": rf"^\s*(\d\d?)[- ]([A-Za-z]{{3}})[a-z]*[- ](\d{{4}}){_CLOCK}{_ZONE}",
    "compact": rf"^\s*(\d{{4}})(\d\d)(\d\d){_COMPACT_CLOCK}{_ZONE}",
}
"""Patterns of dates, all of the same groups; common to Python's and Rust's regular expressions."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


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
    """Times of any form as seconds.

    If ``unit`` is given, numbers are returned unchanged, in that unit: it prevents that large ones
    are read as Unix milliseconds and the like. Dates are seconds in any case. Text that is no time
    is an error, or NaN unless ``strict``.
    """
    if date_order not in (None, "dmy", "mdy"):
        raise ValueError(f"date_order must be 'dmy' or 'mdy', got {value(date_order)}")
    array = _as_array(argument, values)
    if array.dtype.kind == "M":
        return Times(_from_datetimes(argument, array), EPOCH)
    if array.dtype.kind == "m":
        return Times(_from_datetimes(argument, array))
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
    if isinstance(present, datetime.timedelta | np.timedelta64):
        return np.array([np.timedelta64("NaT") if v is None else v for v in array], "m8[us]")
    if type(present) is datetime.date:
        return np.array([np.datetime64("NaT") if v is None else v for v in array], "M8[s]")
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
        array, unit = array.astype(f"{array.dtype.kind}8[s]"), "s"
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
    form = _form(array)
    if form is None:
        if not strict:
            return Times(np.full(len(array), np.nan), EPOCH)
        row = next((r for r, cell in enumerate(array) if not _is_number(cell)), 0)
        raise ValueError(f"{argument}[{row}] is no time: {value(array[row])}")
    groups = _groups(array, _FORMS[form])
    first, month, third, hour, minute, second, is_pm, offset = groups.T
    year, day = (first, third) if form in ("year first", "compact") else (third, first)
    if form == "year last":
        day, month = _day_and_month(argument, array, (first, month), date_order)
    hour = np.where(np.isnan(is_pm), hour, np.where((hour < 1) | (hour > 12), 24, hour % 12))
    hour = hour + 12 * np.nan_to_num(is_pm)
    clock = (np.nan_to_num(part) for part in (hour, minute, second))
    seconds = _seconds(np.nan_to_num(year), np.nan_to_num(month), np.nan_to_num(day), *clock)
    seconds = seconds - offset
    if strict and np.isnan(seconds).any():
        row = int(np.argmax(np.isnan(seconds)))
        raise ValueError(f"{argument}[{row}] is no time: {value(array[row])}")
    return Times(seconds, EPOCH)


def _form(array: NDArray[Any]) -> str | None:
    """The form of the first cell that is a date."""
    patterns = {form: re.compile(pattern) for form, pattern in _FORMS.items()}
    for cell in array:
        for form, pattern in patterns.items():
            if pattern.match(str(cell)):
                return form
    return None


def _is_number(cell: Any) -> bool:
    try:
        float(cell)
    except (TypeError, ValueError):
        return False
    return True


def _day_and_month(
    argument: str,
    cells: NDArray[Any],
    numbers: tuple[NDArray[np.float64], NDArray[np.float64]],
    order: str | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Which of the two numbers is the day: one that is above 12 somewhere."""
    a, b = numbers
    first, second = bool((a > 12).any()), bool((b > 12).any())
    if order is None and first == second:
        why = "both are above 12 somewhere" if first else "neither is ever above 12"
        row = int(np.argmax(np.isfinite(a)))
        raise ValueError(
            f"{argument}: day and month cannot be told apart ({why}; {argument}[{row}] is "
            f"{value(cells[row])}): give date_order='dmy' or date_order='mdy'"
        )
    day_first = order == "dmy" if order is not None else first
    return (a, b) if day_first else (b, a)


def _groups(array: NDArray[Any], pattern: str) -> NDArray[np.float64]:
    """``(rows, 8)``: three numbers of the date, hour, minute, second, 1 for PM, zone in seconds."""
    pl = polars()
    readers = (_number, _month, _number, _number, _number, _number, _is_pm, _offset)
    if pl is None:
        compiled = re.compile(pattern)
        matches = [compiled.match(str(v)) for v in array]
        cells = [m.groups() if m else (None,) * 8 for m in matches]
        numbers = [[read(c) for read, c in zip(readers, row, strict=True)] for row in cells]
        return np.array(numbers, np.float64).reshape(len(array), 8)
    series = pl.Series(array.tolist(), dtype=pl.String)
    frame = series.str.extract_groups(pattern).struct.unnest()
    return np.column_stack(
        [
            _numbers(frame[name]) if read is _number else _mapped(frame[name], read)
            for name, read in zip(frame.columns, readers, strict=True)
        ]
    )


def _numbers(cells: Any) -> NDArray[np.float64]:
    pl = polars()
    numbers: NDArray[np.float64] = (
        cells.str.replace(",", ".", literal=True).cast(pl.Float64, strict=False).to_numpy()
    )
    return numbers


def _mapped(cells: Any, read: Callable[[str | None], float]) -> NDArray[np.float64]:
    """A number for each different text."""
    known = cells.unique().to_list()
    texts = cells.replace_strict(known, [read(c) for c in known], return_dtype=polars().Float64)
    numbers: NDArray[np.float64] = texts.to_numpy()
    return numbers


def _number(cell: str | None) -> float:
    return np.nan if cell is None else float(cell.replace(",", "."))


def _month(cell: str | None) -> float:
    """A month by its number or its English name."""
    if cell is None or cell.isdigit():
        return _number(cell)
    return float(_MONTHS.index(cell.lower()) + 1) if cell.lower() in _MONTHS else np.nan


def _is_pm(cell: str | None) -> float:
    return np.nan if cell is None else float(cell.lower() == "pm")


def _offset(zone: str | None) -> float:
    """Seconds that a zone is ahead of UTC."""
    if zone in (None, "Z", "UTC"):
        return 0.0
    assert zone is not None
    digits = zone[1:].replace(":", "").ljust(4, "0")
    seconds = int(digits[:2]) * 3600 + int(digits[2:]) * 60
    return float(-seconds if zone[0] == "-" else seconds)
