"""JSON Lines to columns and back: one record a line, lists of any length as values."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from trackmetrics._tables import json_lines_polars
from trackmetrics._tables.columns import Ragged
from trackmetrics._tables.polars_columns import data_frame, polars


def first_record(data: bytes, file: str) -> dict[str, Any]:
    """The first record."""
    line = data.lstrip().partition(b"\n")[0]
    return parse(line.decode(), file, 1) if line.strip() else {}


def parse(line: str, file: str, number: int) -> dict[str, Any]:
    """One record; an error names the line."""
    try:
        record = json.loads(line)
    except json.JSONDecodeError as error:
        raise ValueError(
            f"{file}, line {number}: not a JSON record ({error.msg} at character "
            f"{error.pos + 1} of {len(line.rstrip())}); was the file cut off?"
        ) from None
    if not isinstance(record, dict):
        raise ValueError(f"{file}, line {number}: expected a JSON object")
    return record


def read(source: bytes | Path, file: str, start: int = 0, first_line: int = 1) -> dict[str, Any]:
    """The columns of the records; what a record lacks is missing.

    The text is ``source`` from byte ``start`` on, or that of the file ``source``.
    """
    if polars() is not None:
        columns = json_lines_polars.read(source, start)
        if columns is not None:
            return columns
    data = source if isinstance(source, bytes) else source.read_bytes()
    return _read_small(data[start:], file, first_line)


def _read_small(data: bytes, file: str, first_line: int) -> dict[str, Any]:
    lines = enumerate(data.decode().splitlines(), first_line)
    records = [parse(line, file, number) for number, line in lines if line.strip()]
    names = dict.fromkeys(name for record in records for name in record)
    return {name: [record.get(name) for record in records] for name in names}


def write(columns: Mapping[str, Any], file: BinaryIO) -> None:
    """Write columns as one record a line; missing values are null."""
    if polars() is None:
        file.write(_write_small(columns))
        return
    data_frame(columns).write_ndjson(file)


def _write_small(columns: Mapping[str, Any]) -> bytes:
    listed = {name: _as_lists(column) for name, column in columns.items()}
    out = io.StringIO()
    for values in zip(*listed.values(), strict=True):
        record = {k: v for k, v in zip(listed, values, strict=True) if v is not None}
        out.write(json.dumps(record, allow_nan=False, ensure_ascii=False) + "\n")
    return out.getvalue().encode()


def _as_lists(column: Any) -> list[Any]:
    if isinstance(column, Ragged):
        flat = [None if v is None or v != v else v for v in column.flat.tolist()]
        ends = np.cumsum(column.lengths)
        return [flat[e - n : e] or None for e, n in zip(ends, column.lengths, strict=True)]
    return [None if v is None or v != v else v for v in column.tolist()]
