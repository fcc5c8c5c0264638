"""Delimited text to columns: comma, semicolon, tab or blanks; decimal point or comma."""

import csv
import io
import re
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from trackmetrics._tables import headings
from trackmetrics._tables.errors import value
from trackmetrics._tables.polars_columns import polars, to_array

MISSING = ("", "NA", "N/A", "NaN", "nan", "NAN", "null", "NULL", "None", "<NA>", "#N/A")
"""Cells that hold no value."""
_ROWS_INFERRED = 1000
_GROUPED = re.compile(r"-?\d{1,3}(?:,\d{3})+(?:\.\d+)?")
_DECIMAL_COMMA = re.compile(r"-?\d+,\d+(?:[eE][+-]?\d+)?")


def read(data: bytes, file: str, text_columns: Collection[str] = ()) -> dict[str, Any]:
    """The columns of delimited text under their headings; ``text_columns`` are never numbers."""
    line, _, body = data.lstrip(b"\r\n").partition(b"\n")
    delimiter = _delimiter(line.decode())
    if delimiter == " ":
        # NumPy's savetxt pads with blanks; the heading may stand behind a lone ``#``.
        line = re.sub(rb"[ \t]+", b" ", re.sub(rb"^[#%]\s*", b"", line.strip()))
        body = re.sub(rb"(?m)^ +| +$", b"", re.sub(rb"[ \t]+", b" ", body))
    names = headings.clean(
        next(csv.reader([line.decode().rstrip("\r")], delimiter=delimiter)), file
    )
    known = {name for name in names if headings.match([name], text_columns) or name in text_columns}
    decimal_comma = delimiter == ";" and _has_decimal_commas(body[:65536].decode(errors="replace"))
    columns = _read_fast(body, file, names, delimiter, decimal_comma, known)
    if columns is None:
        columns = _read_small(body, file, names, delimiter, decimal_comma, known)
    return {name: _numbers_in_quotes(file, name, c, known) for name, c in columns.items()}


def _delimiter(heading: str) -> str:
    bare = re.sub(r'"[^"]*"', "", heading)
    for delimiter in (";", "\t", ","):
        if delimiter in bare:
            return delimiter
    return " " if " " in bare.strip().lstrip("#% ") else ","


def _has_decimal_commas(sample: str) -> bool:
    cells = [c.strip() for c in re.split(r"[;\n]", sample)]
    return any(_DECIMAL_COMMA.fullmatch(c) for c in cells)


def _read_fast(
    body: bytes, file: str, names: list[str], delimiter: str, comma: bool, text: Collection[str]
) -> dict[str, Any] | None:
    pl = polars()
    if pl is None or not body.strip():
        return None
    options = {
        "has_header": False,
        "separator": delimiter,
        "decimal_comma": comma,
        "null_values": list(MISSING),
        "schema_overrides": {f"column_{names.index(n) + 1}": pl.String for n in text},
    }
    # The first rows tell what a column holds, most often; if a later one differs, all of them.
    for inferred in (_ROWS_INFERRED, None):
        try:
            frame = pl.read_csv(io.BytesIO(body), infer_schema_length=inferred, **options)
            break
        except pl.exceptions.PolarsError:
            continue
    else:
        return None  # the small reader names the row
    if len(frame.columns) != len(names):
        return None
    frame.columns = names
    if frame[names[-1]].null_count() and _has_short_rows(body, delimiter, len(names)):
        return None  # likewise
    return {name: to_array(frame[name]) for name in names}


def _has_short_rows(body: bytes, delimiter: str, cells: int) -> bool:
    """Whether a row has fewer cells than there are headings."""
    if b'"' in body:
        rows = csv.reader(io.StringIO(body.decode()), delimiter=delimiter)
        return any(row and len(row) != cells for row in rows)
    bytes_ = np.frombuffer(body.rstrip(b"\r\n") + b"\n", np.uint8)
    ends = np.flatnonzero(bytes_ == ord("\n"))
    delimiters = np.searchsorted(np.flatnonzero(bytes_ == ord(delimiter)), ends)
    is_blank = np.diff(ends, prepend=-1) <= 1 + (bytes_[ends - 1] == ord("\r"))
    return bool((~is_blank & (np.diff(delimiters, prepend=0) != cells - 1)).any())


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
        columns[name] = _from_cells(cells, comma) if name not in text else np.array(cells, object)
    return columns


def _from_cells(cells: list[str | None], comma: bool) -> Any:
    try:
        values = [
            np.nan if c is None else float(c.replace(",", ".") if comma else c) for c in cells
        ]
    except ValueError:
        return np.array(cells, object)
    return np.array(values, np.float64)


def _numbers_in_quotes(file: str, name: str, column: Any, text: Collection[str]) -> Any:
    """Quoted numbers with a decimal comma; thousands separators are refused."""
    if not isinstance(column, np.ndarray) or column.dtype.kind != "O" or name in text:
        return column
    cells = [c for c in column if c is not None]
    if not cells or not all(_DECIMAL_COMMA.fullmatch(c.strip()) or _is_number(c) for c in cells):
        for row, cell in enumerate(column):
            if cell is not None and _GROUPED.fullmatch(cell.strip()) and "." in cell:
                raise ValueError(
                    f"{file}, row {row}: {name} is {value(cell)}, with a thousands separator: "
                    "write it without"
                )
        return column
    with_comma = [c for c in cells if "," in c]
    if with_comma and all(_GROUPED.fullmatch(c.strip()) for c in with_comma):
        row = next(r for r, c in enumerate(column) if c is not None and "," in c)
        raise ValueError(
            f"{file}, row {row}: {name} is {value(column[row])}: a thousands separator or a "
            "decimal comma? Write a decimal point"
        )
    return np.array([np.nan if c is None else float(c.replace(",", ".")) for c in column])


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def write(columns: Mapping[str, Any]) -> bytes:
    """Columns as comma-separated text with a heading; missing cells are empty."""
    pl = polars()
    if pl is None:
        return _write_small(columns)
    from trackmetrics._tables.polars_columns import from_array

    frame = pl.DataFrame({name: from_array(column) for name, column in columns.items()})
    out = io.BytesIO()
    frame.write_csv(out)
    return out.getvalue()


def _write_small(columns: Mapping[str, Any]) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    cells = [["" if v is None or v != v else v for v in c.tolist()] for c in columns.values()]
    writer.writerows(zip(*cells, strict=True))
    return out.getvalue().encode()
