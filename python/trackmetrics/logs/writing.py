"""Logs in files: JSON Lines with a header record, CSV with a header comment, Parquet with metadata.

Only what was logged is written; what was computed is computed again when the file is read, so that
a computed value never passes for evidence of what the estimator did.
"""

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trackmetrics.logs.columns import COVARIANCES, FLOATS, NUMBERS, WORDS, Columns, Floats
from trackmetrics.logs.header import SCHEMA, State

Record = dict[str, Any]


def write(path: Path, header: Mapping[str, Any], records: Iterable[Record]) -> None:
    """Write a log; the ending of the name says in which form."""
    writers = {".jsonl": _write_json_lines, ".csv": _write_csv, ".parquet": _write_parquet}
    if path.suffix not in writers:
        raise ValueError(f"path must end in {', '.join(writers)}, got {path.name!r}")
    writers[path.suffix](path, header, list(records))


def header(
    states: Sequence[State], measurement_angles: Mapping[str, Mapping[int, float]], time_unit: str
) -> Record:
    """What a log says once."""
    return {
        "schema": SCHEMA,
        "states": [{"name": s.name, "unit": s.unit, "period": s.period} for s in states],
        "measurement_angles": {
            kind: {str(i): period for i, period in angles.items()}
            for kind, angles in measurement_angles.items()
        },
        "time_unit": time_unit,
    }


def records(track: str, columns: Columns, logged: Mapping[str, Any]) -> Iterator[Record]:
    """One dictionary a row of a track: what was ``logged`` in it, covariances as triangles."""
    for row in range(len(columns)):
        record: Record = {"track": track, "time": float(columns.time[row])}
        for name in WORDS:
            column = getattr(columns, name)
            if column is not None and column[row] is not None:
                record[name] = column[row]
        if columns.observed is not None:
            record["observed"] = _until_last(columns.observed[row], columns.observed[row] >= 0)
        for name, there in logged.items():
            if there[row]:
                record[name] = _cell(name, getattr(columns, name)[row])
        yield record


def _cell(name: str, value: Floats) -> Any:
    """A number, or a list of numbers in which None stands for what is missing before the last."""
    if name in NUMBERS:
        return float(value)
    if value.ndim == 1:
        return _until_last(value, ~np.isnan(value))
    if name == "H":
        rows = len(_until_last(value[:, 0], ~np.isnan(value).any(axis=1)))
        return [None if v != v else v for v in value[:rows].ravel().tolist()]
    size = len(_until_last(value.diagonal(), ~np.isnan(value.diagonal())))
    value = value[:size, :size]
    flat = value[np.triu_indices(size)] if name in COVARIANCES else value.ravel()
    return [None if v != v else v for v in flat.tolist()]


def _until_last(values: Any, there: Any) -> list[Any]:
    """The values up to the last that is there."""
    stop = int(np.flatnonzero(there)[-1]) + 1 if there.any() else 0
    return [None if v != v else v for v in values[:stop].tolist()]


def _write_json_lines(path: Path, header: Mapping[str, Any], records: list[Record]) -> None:
    with path.open("w", encoding="utf-8") as file:
        for record in [header, *records]:
            file.write(json.dumps(record, allow_nan=False, ensure_ascii=False) + "\n")


def _write_csv(path: Path, header: Mapping[str, Any], records: list[Record]) -> None:
    rows = [_flat(record) for record in records]
    names = sorted({name for row in rows for name in row}, key=_place)
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write("# " + json.dumps(header, ensure_ascii=False) + "\n")
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _flat(record: Record) -> Record:
    flat: Record = {}
    for name, value in record.items():
        if isinstance(value, list):
            flat.update({f"{name}[{i}]": v for i, v in enumerate(value)})
        else:
            flat[name] = value
    return flat


def _place(name: str) -> tuple[int, int]:
    """The order of the columns of a CSV file."""
    base, _, index = name.partition("[")
    return ["track", "time", *WORDS, "observed", *FLOATS].index(base), int(index.rstrip("]") or -1)


def _write_parquet(path: Path, header: Mapping[str, Any], records: list[Record]) -> None:
    import pyarrow
    import pyarrow.parquet

    table = pyarrow.Table.from_pylist(_with_every_name(records))
    metadata = {b"trackmetrics": json.dumps(header).encode()}
    pyarrow.parquet.write_table(table.replace_schema_metadata(metadata), path)


def _with_every_name(rows: list[Record]) -> list[Record]:
    """A table takes its columns from the first row."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return [{name: row.get(name) for name in names} for row in rows]
