"""The columns of a log among those of a table, by their names or as the caller names them."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trackmetrics._tables import headings
from trackmetrics._tables.columns import Ragged, from_padded
from trackmetrics._tables.errors import shown, value
from trackmetrics.logs.schema import COLUMN_NAMES, NUMERIC_COLUMNS

Renaming = Mapping[str, str | Sequence[str]]
Table = Mapping[str, Any]


def select_columns(table: Table, renaming: Renaming) -> dict[str, Any]:
    """The columns of a log, with vectors put together from their elements."""
    renamed = headings.match(list(table), COLUMN_NAMES)
    table = {renamed.get(name, name): values for name, values in table.items()}
    chosen = {name: table[name] for name in COLUMN_NAMES if name in table}
    for name in COLUMN_NAMES:
        parts = _parts(table, name)
        if parts:
            chosen[name] = _together([table[part] for part in parts])
    for name, source in renaming.items():
        names = [source] if isinstance(source, str) else list(source)
        missing = [n for n in names if n not in table]
        if missing:
            raise ValueError(f"columns: no column {missing[0]!r}; there are {shown(table)}")
        is_one = isinstance(source, str)
        chosen[name] = table[names[0]] if is_one else _together([table[n] for n in names])
    return chosen


def check_selected(chosen: dict[str, Any], table: Table, time: str | None) -> dict[str, Any]:
    """The columns, if there are times and something to diagnose among them."""
    names = list(table)
    if not any(name in chosen for name in NUMERIC_COLUMNS):
        raise ValueError(
            f"no column to diagnose ({headings.nearest('nis', names)}): expected nis and "
            "nis_dof, or more; name them by columns={'nis': ...}"
        )
    if time == "row":
        return {name: values for name, values in chosen.items() if name != "time"}
    if time is not None:
        raise ValueError(f"time must be 'row' or absent, got {value(time)}")
    if "time" not in chosen:
        raise ValueError(
            f"no column time ({headings.nearest('time', names)}): name it by "
            "columns={'time': ...}, or say time='row' for the numbers of the rows"
        )
    return chosen


def notes_on_unused(table: Table, chosen: Mapping[str, Any], renaming: Renaming) -> tuple[str, ...]:
    """A note on each unused column whose name is nearly that of a column that the log lacks."""
    used = {
        n for names in renaming.values() for n in ([names] if isinstance(names, str) else names)
    }
    absent = [name for name in COLUMN_NAMES if name not in chosen]
    found: dict[str, str] = {}
    for name in headings.unmatched(list(table), COLUMN_NAMES):
        meant = headings.closest(name, absent) if name not in used else None
        if meant is not None:
            found.setdefault(meant, name)
    return tuple(
        f"column {value(name)} is not used; did you mean {meant}?" for meant, name in found.items()
    )


def _parts(table: Table, name: str) -> list[str]:
    """``x[0]``, ``x[1]``, ... in the order of their indices."""
    found = [re.fullmatch(rf"{name}\[(\d+)\]", key) for key in table]
    parts = sorted((int(m.group(1)), m.string) for m in found if m)
    for place, (index, _) in enumerate(parts):
        if index != place:
            raise ValueError(f"no column {name}[{place}], although there is {name}[{index}]")
    return [part for _, part in parts]


def _together(parts: Sequence[Any]) -> Ragged:
    """Columns side by side, one list a row, without what is missing at the end."""
    arrays = [np.asarray(part) for part in parts]
    if all(a.dtype.kind in "biuf" for a in arrays):
        return from_padded(np.column_stack(arrays).astype(np.float64))
    cells = np.empty((len(arrays[0]), len(arrays)), object)
    for place, array in enumerate(arrays):
        cells[:, place] = [None if v is None or v != v else v for v in array.tolist()]
    there = cells != None  # noqa: E711 - elementwise
    lengths = np.where(there.any(axis=1), len(arrays) - np.argmax(there[:, ::-1], axis=1), 0)
    return Ragged(cells[np.arange(len(arrays)) < lengths[:, None]], lengths.astype(np.int64))
