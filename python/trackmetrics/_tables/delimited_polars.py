"""Delimited text to columns by Polars: the file is read in place, no row is looked at in Python."""

import io
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import numerals
from trackmetrics._tables.polars_columns import polars, to_array

_SAMPLE_BYTES = 1 << 18
_ROWS_INFERRED = 1000


def read(
    source: bytes | Path,
    start: int,
    file: str,
    names: Sequence[str],
    delimiter: str,
    decimal_comma: bool,
    text: Collection[str],
) -> dict[str, Any] | None:
    """The columns of the rows from byte ``start`` on; None where the small reader has to name the
    row that is wrong."""
    pl = polars()
    sample = _part(source, start, _SAMPLE_BYTES)
    if not sample.strip():
        return None
    options = {
        "has_header": False,
        "separator": delimiter,
        "decimal_comma": decimal_comma,
    }
    kinds = _kinds(sample, names, text, options)
    if kinds is None:
        return None
    frame = _frame(source, start, kinds, options)
    if frame is None:
        return None
    last = frame[names[-1]]
    if last.null_count():
        blank = _blank_rows(source, start, delimiter, len(names))
        if blank is None or len(blank) > len(frame):
            return None
        if len(blank):
            frame = frame.filter(~pl.int_range(len(frame), eager=True).is_in(blank))
    columns = {}
    for name in names:
        series = frame.drop_in_place(name)
        if series.dtype == pl.String:
            series = _numbers_or_text(file, series, name in text)
        columns[name] = to_array(series)
    return columns


def _part(source: bytes | Path, start: int, count: int) -> bytes:
    """Whole lines from byte ``start`` on, about ``count`` bytes."""
    if isinstance(source, bytes):
        part = source[start : start + count]
    else:
        with source.open("rb") as opened:
            opened.seek(start)
            part = opened.read(count)
    return part[: part.rfind(b"\n") + 1] if len(part) == count else part


def _kinds(
    sample: bytes, names: Sequence[str], text: Collection[str], options: dict[str, Any]
) -> dict[str, Any] | None:
    """What each column holds, after its first rows: numbers or text."""
    pl = polars()
    try:
        frame = pl.read_csv(
            io.BytesIO(sample),
            infer_schema_length=_ROWS_INFERRED,
            n_rows=_ROWS_INFERRED,
            null_values=list(numerals.MISSING),
            **options,
        )
    except pl.exceptions.PolarsError:
        return None
    if len(frame.columns) != len(names):
        return None
    kinds = {}
    for name, kind in zip(names, frame.dtypes, strict=True):
        is_number = kind.is_numeric() and name not in text
        kinds[name] = pl.Float64 if is_number else pl.String
    return kinds


def _frame(source: bytes | Path, start: int, kinds: dict[str, Any], options: dict[str, Any]) -> Any:
    """The table; columns that hold something else further down are read as text."""
    pl = polars()
    missing = list(numerals.MISSING)
    for schema, null_values in (
        (kinds, None),
        (kinds, missing),
        (dict.fromkeys(kinds, pl.String), None),
    ):
        try:
            if isinstance(source, bytes):
                body: Any = io.BytesIO(source[start:] if start else source)
                return pl.read_csv(body, schema=schema, null_values=null_values, **options)
            with source.open("rb") as opened:
                lines = opened.read(start).count(b"\n")
            return pl.read_csv(
                source, schema=schema, null_values=null_values, skip_lines=lines, **options
            )
        except pl.exceptions.PolarsError:
            continue
    return None


def _numbers_or_text(file: str, series: Any, is_text: bool) -> Any:
    """A column of text as numbers where all its cells are; cells that say so are missing."""
    pl = polars()
    stripped = series.str.strip_chars()
    nothing = pl.repeat(None, len(series), dtype=pl.String, eager=True)
    has_value = ~stripped.is_in(list(numerals.MISSING)).fill_null(True)
    if is_text:
        return series.zip_with(has_value, nothing)
    stripped = stripped.zip_with(has_value, nothing)
    numbers = stripped.cast(pl.Float64, strict=False)
    others = numbers.is_null() & stripped.is_not_null()
    if not others.any():
        return numbers
    left = stripped.filter(others)
    grouped = left.str.contains(numerals.THOUSANDS)
    if left.str.contains(numerals.DECIMAL_COMMA).all():
        if grouped.all():
            numerals.refuse_ambiguous(file, int(others.arg_max()), left[0], series.name)
        pointed = stripped.str.replace(",", ".", literal=True)
        return pointed.cast(pl.Float64, strict=False)
    grouped &= left.str.contains(".", literal=True)
    if grouped.any():
        place = int(grouped.arg_max())
        row = int(others.arg_true()[place])
        numerals.refuse_thousands(file, series.name, [(row, left[place])])
    return series.zip_with(has_value, nothing)


def _blank_rows(source: bytes | Path, start: int, delimiter: str, cells: int) -> list[int] | None:
    """Which lines hold nothing; None where one has another number of cells than the heading."""
    body = source[start:] if isinstance(source, bytes) else source.read_bytes()[start:]
    blank: list[int] = []
    first = lines = 0
    while first < len(body):
        end = body.find(b"\n", first + _SAMPLE_BYTES) + 1 or len(body)
        while end < len(body) and body.count(b'"', first, end) % 2:  # within a quoted cell
            end = body.find(b"\n", end) + 1 or len(body)
        block = np.frombuffer(body[first:end].removesuffix(b"\n") + b"\n", np.uint8)
        delimiters, sizes = _cells(block, delimiter)
        is_blank = sizes == 0
        if (~is_blank & (delimiters != cells - 1)).any():
            return None
        blank += (lines + np.flatnonzero(is_blank)).tolist()
        lines += len(sizes)
        first = end
    return blank


def _cells(block: NDArray[np.uint8], delimiter: str) -> tuple[Any, Any]:
    """How many delimiters and how many bytes each line has, quoted cells aside."""
    is_end, is_delimiter = block == ord("\n"), block == ord(delimiter)
    quotes = block == ord('"')
    if quotes.any():
        outside = np.cumsum(quotes) % 2 == 0
        is_end, is_delimiter = is_end & outside, is_delimiter & outside
    ends = np.flatnonzero(is_end)
    delimiters = np.diff(np.searchsorted(np.flatnonzero(is_delimiter), ends), prepend=0)
    sizes = np.diff(ends, prepend=-1) - 1
    return delimiters, sizes - (block[ends - 1] == ord("\r")) * (sizes > 0)
