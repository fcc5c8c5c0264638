"""JSON Lines to columns by Polars, block by block on all processors."""

import io
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from trackmetrics._tables.polars_columns import polars, to_array

BLOCK_BYTES = 1 << 23
_SAMPLE_BYTES = 1 << 18
_MAX_THREADS = 8


def read(source: bytes | Path, start: int = 0) -> dict[str, Any] | None:
    """The columns of the records from byte ``start`` on; None where the small reader has to name
    the line that is wrong."""
    pl = polars()
    try:
        frame = _in_blocks(source, start)
        if frame is None:
            data = source if isinstance(source, bytes) else source.read_bytes()
            frame = pl.read_ndjson(io.BytesIO(data[start:]), infer_schema_length=None)
            nested = any(isinstance(kind, pl.Struct) for kind in frame.dtypes)
            if not nested and data.count(b'":', start) > len(frame.columns) * len(frame):
                return None  # a record has a name twice, or text with such an end
        if _has_lists_as_text(frame):
            return None
        return {name: to_array(frame.drop_in_place(name)) for name in frame.columns}
    except (pl.exceptions.PolarsError, TypeError, ValueError):
        return None


def _has_lists_as_text(frame: Any) -> bool:
    """Whether a column holds lists and something else: Polars makes text of both."""
    pl = polars()
    texts = (frame[name] for name, kind in frame.schema.items() if kind == pl.String)
    return any(text.str.contains(r"^[\[{]").any() for text in texts)


def _in_blocks(source: bytes | Path, start: int) -> Any:
    """The table, if all records are like the first ones: the same names, numbers and texts."""
    pl = polars()
    spans = list(_spans(source, start))
    if not spans:
        return None
    schema = _schema(_part(source, (start, min(spans[0][1], start + _SAMPLE_BYTES))))
    if schema is None:
        return None

    def block(span: tuple[int, int]) -> Any:
        data = _part(source, span)
        part = pl.read_ndjson(io.BytesIO(data), schema=schema)
        # A name that the first records lack would be passed over.
        return part if data.count(b'":') == len(schema) * len(part) else None

    with ThreadPoolExecutor(min(os.cpu_count() or 1, _MAX_THREADS)) as executor:
        try:
            parts = list(executor.map(block, spans))
        except pl.exceptions.PolarsError:
            return None
    return None if any(part is None for part in parts) else pl.concat(parts)


def _schema(sample: bytes) -> dict[str, Any] | None:
    """What the first records hold, every number as float64."""
    pl = polars()
    sample = sample[: sample.rfind(b"\n") + 1] or sample
    try:
        frame = pl.read_ndjson(io.BytesIO(sample), infer_schema_length=None)
    except pl.exceptions.PolarsError:
        return None
    if not len(frame):
        return None
    return {name: _as_float(kind) for name, kind in frame.schema.items()}


def _as_float(kind: Any) -> Any:
    pl = polars()
    if isinstance(kind, pl.List):
        return pl.List(_as_float(kind.inner))
    return pl.Float64 if kind.is_numeric() else kind


def _spans(source: bytes | Path, start: int) -> Iterator[tuple[int, int]]:
    """First and last byte of blocks of whole lines."""
    if isinstance(source, bytes):
        while start < len(source):
            end = source.find(b"\n", start + BLOCK_BYTES) + 1 or len(source)
            yield start, end
            start = end
        return
    size = source.stat().st_size
    with source.open("rb") as file:
        while start < size:
            file.seek(start + BLOCK_BYTES)
            file.readline()
            end = min(file.tell(), size)
            yield start, end
            start = end


def _part(source: bytes | Path, span: tuple[int, int]) -> bytes:
    first, end = span
    if isinstance(source, bytes):
        return source[first:end]
    with source.open("rb") as file:
        file.seek(first)
        return file.read(end - first)
