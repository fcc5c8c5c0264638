"""Delimited text to columns: comma, semicolon, tab or blanks; decimal point or comma."""

import csv
import io
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from trackmetrics._tables import delimited_polars, headings
from trackmetrics._tables.numerals import MISSING, from_cells
from trackmetrics._tables.polars_columns import data_frame, polars

_HEADING_BYTES = 1 << 20


def read(
    source: bytes | Path, file: str, text_columns: Collection[str] = (), start: int = 0
) -> dict[str, Any]:
    """The columns of delimited text under their headings; ``text_columns`` are never numbers.

    The text is ``source`` from byte ``start`` on, or that of the file ``source``.
    """
    first = _bytes(source, start, _HEADING_BYTES)
    line, _, _ = first.lstrip(b"\r\n").partition(b"\n")
    body = start + len(first) - len(first.lstrip(b"\r\n")) + len(line) + 1
    delimiter = _delimiter(line.decode())
    if delimiter == " ":
        line = re.sub(rb"[ \t]+", b" ", re.sub(rb"^[#%]\s*", b"", line.strip()))
        source, body = _single_blanks(_bytes(source, body)), 0
    cells = next(csv.reader([line.decode().rstrip("\r")], delimiter=delimiter))
    names = headings.clean(cells, file)
    text = {name for name in names if headings.match([name], text_columns) or name in text_columns}
    comma = delimiter == ";" and _has_decimal_commas(_bytes(source, body, 1 << 16))
    if polars() is not None:
        columns = delimited_polars.read(source, body, file, names, delimiter, comma, text)
        if columns is not None:
            return columns
    return _read_small(_bytes(source, body), file, names, delimiter, comma, text)


def _bytes(source: bytes | Path, start: int, count: int = -1) -> bytes:
    """``count`` bytes from ``start``, or all."""
    if isinstance(source, bytes):
        return source[start : None if count < 0 else start + count]
    with source.open("rb") as file:
        file.seek(start)
        return file.read(count)


def _single_blanks(body: bytes) -> bytes:
    """Text in which one blank separates cells: NumPy's ``savetxt`` pads with blanks."""
    if b"\t" in body or b"  " in body:
        body = re.sub(rb"[ \t]+", b" ", body)
    return body.replace(b"\n ", b"\n").replace(b" \n", b"\n").replace(b" \r", b"\r").strip(b" ")


def _delimiter(heading: str) -> str:
    bare = re.sub(r'"[^"]*"', "", heading)
    for delimiter in (";", "\t", ","):
        if delimiter in bare:
            return delimiter
    return " " if " " in bare.strip().lstrip("#% ") else ","


def _has_decimal_commas(sample: bytes) -> bool:
    cells = (c.strip() for c in re.split(r"[;\n]", sample.decode(errors="replace")))
    return any(re.fullmatch(r"-?\d+,\d+(?:[eE][+-]?\d+)?", c) for c in cells)


def _read_small(
    body: bytes, file: str, names: list[str], delimiter: str, comma: bool, text: Collection[str]
) -> dict[str, Any]:
    """Row by row: without Polars, and to say which row is wrong."""
    rows = [row for row in csv.reader(io.StringIO(body.decode()), delimiter=delimiter) if row]
    for number, row in enumerate(rows):
        if len(row) != len(names):
            raise ValueError(f"{file}, row {number}: {len(row)} cells, the header has {len(names)}")
    table = np.array(rows, object).reshape(len(rows), len(names))
    columns: dict[str, Any] = {}
    for place, name in enumerate(names):
        cells = [None if cell.strip() in MISSING else cell for cell in table[:, place]]
        as_text = np.array(cells, object)
        columns[name] = as_text if name in text else from_cells(file, name, as_text, comma)
    return columns


def write(columns: Mapping[str, Any], file: BinaryIO) -> None:
    """Write columns as comma-separated text with a heading; missing cells are empty."""
    if polars() is None:
        file.write(_write_small(columns))
        return
    data_frame(columns).write_csv(file)


def _write_small(columns: Mapping[str, Any]) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    cells = [["" if v is None or v != v else v for v in c.tolist()] for c in columns.values()]
    writer.writerows(zip(*cells, strict=True))
    return out.getvalue().encode()
