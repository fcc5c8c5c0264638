"""Tables of columns from files and data frames."""

import csv
import json
import re
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from trackmetrics._progress import lines
from trackmetrics.logs.columns import KNOWN, WORDS
from trackmetrics.logs.header import SCHEMA

Renaming = Mapping[str, str | Sequence[str]]
Table = dict[str, list[Any]]


def from_file(path: Path, progress: bool) -> tuple[Table, dict[str, Any]]:
    """The table in a file, and its header; the ending says in which form it is.

    With ``progress`` a bar shows how much is read.
    """
    readers = {
        ".jsonl": _read_json_lines,
        ".csv": _read_csv,
        ".parquet": _read_parquet,
        ".ulg": _read_ulog,
    }
    if path.suffix not in readers:
        raise ValueError(f"path must end in {', '.join(readers)}, got {path.name!r}")
    return readers[path.suffix](path, progress)


def from_frame(frame: Any) -> Table:
    """The table in a data frame of pandas, Polars, PyArrow or whatever else narwhals reads."""
    import narwhals

    native = narwhals.from_native(frame, eager_only=True)
    return {name: native[name].to_list() for name in native.columns}


def chosen(table: Table, renaming: Renaming) -> Table:
    """The columns of a log among those of a table, vectors put together."""
    chosen: Table = {name: table[name] for name in KNOWN if name in table}
    for name in KNOWN:
        parts = _parts(table, name)
        if parts:
            chosen[name] = _together([table[part] for part in parts])
    for name, source in renaming.items():
        names = [source] if isinstance(source, str) else list(source)
        missing = [n for n in names if n not in table]
        if missing:
            raise ValueError(f"columns: no column {missing[0]!r}; there are {', '.join(table)}")
        scalar = isinstance(source, str)
        chosen[name] = table[names[0]] if scalar else _together([table[n] for n in names])
    return chosen


def _parts(table: Table, name: str) -> list[str]:
    """``x[0]``, ``x[1]``, ... in the order of their indices."""
    found = [re.fullmatch(rf"{name}\[(\d+)\]", key) for key in table]
    return [m.string for m in sorted((m for m in found if m), key=lambda m: int(m.group(1)))]


def _together(parts: Sequence[list[Any]]) -> list[list[Any] | None]:
    """Columns side by side, one list a row, without what is missing at the end."""
    rows: list[list[Any] | None] = []
    for values in zip(*parts, strict=True):
        row = list(values)
        while row and row[-1] is None:
            row.pop()
        rows.append([float("nan") if v is None else v for v in row] or None)
    return rows


def _read_json_lines(path: Path, progress: bool) -> tuple[Table, dict[str, Any]]:
    header: dict[str, Any] = {}
    records = []
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(lines(file, "reading") if progress else file, 1):
            if not line.strip():
                continue
            record = _parse(path, number, line)
            if "schema" in record and "states" in record:
                header = _checked_header(path, record)
            else:
                records.append(record)
    names = dict.fromkeys(name for record in records for name in record)
    return {name: [record.get(name) for record in records] for name in names}, header


def _parse(path: Path, number: int, line: str) -> dict[str, Any]:
    try:
        record = json.loads(line)
    except json.JSONDecodeError as error:
        raise ValueError(
            f"{path.name}, line {number}: not a JSON record ({error.msg} at character "
            f"{error.pos + 1} of {len(line.rstrip())}); was the file cut off?"
        ) from None
    if not isinstance(record, dict):
        raise ValueError(f"{path.name}, line {number}: expected a JSON object")
    return record


def _checked_header(path: Path, record: dict[str, Any]) -> dict[str, Any]:
    if record["schema"] != SCHEMA:
        raise ValueError(f"{path.name}: schema {record['schema']!r}, expected {SCHEMA!r}")
    return record


def _read_csv(path: Path, progress: bool) -> tuple[Table, dict[str, Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        first = file.readline()
        headed = first.startswith("# {")
        header = _checked_header(path, _parse(path, 1, first[2:])) if headed else {}
        others = lines(file, "reading") if progress else file
        reader = csv.reader(others if headed else chain([first], others))
        names = next(reader, [])
        rows = [row for row in reader if row]
    for number, row in enumerate(rows):
        if len(row) != len(names):
            raise ValueError(
                f"{path.name}, row {number}: {len(row)} cells, the header has {len(names)}"
            )
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    return {n: [_cell(n, c) for c in column] for n, column in zip(names, columns)}, header  # noqa: B905 - a file without rows


def _cell(name: str, text: str) -> Any:
    """A cell of a CSV file: a number where it reads as one, None where it is empty."""
    if text == "":
        return None
    if name == "track" or name in WORDS:
        return text
    try:
        return float(text)
    except ValueError:
        return text


def _read_ulog(path: Path, _: bool) -> tuple[Table, dict[str, Any]]:
    from trackmetrics.logs import px4

    return px4.read_ulog(path), {}


def _read_parquet(path: Path, _: bool) -> tuple[Table, dict[str, Any]]:
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    metadata = (table.schema.metadata or {}).get(b"trackmetrics")
    header = _checked_header(path, json.loads(metadata)) if metadata else {}
    return table.to_pydict(), header
