"""Columns from one dictionary a row, for the objects of other libraries."""

from collections.abc import Sequence
from typing import Any

Record = dict[str, Any]
Table = dict[str, list[Any]]


def to_columns(records: Sequence[Record]) -> Table:
    """One list a column, None where a record lacks it; columns without a value are left out."""
    names = dict.fromkeys(name for record in records for name in record)
    columns = {name: [record.get(name) for record in records] for name in names}
    return {k: v for k, v in columns.items() if any(value is not None for value in v)}
