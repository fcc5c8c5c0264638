"""Track tables as delimited text with headings."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables import delimited
from trackmetrics._tables.opening import Content
from trackmetrics.tracks import named


def read(content: Content, mapping: named.Mapped) -> dict[str, Any]:
    """The arguments of a track table."""
    chosen = [mapping[name] for name in ("id", "cls", "mask") if name in mapping]
    text = (*named.TEXT, *(name for name in chosen if isinstance(name, str)))
    table = delimited.read(content.source, content.name, text)
    return named.take(table, mapping, content.name)


def write(path: Path, columns: Mapping[str, Any]) -> None:
    """Write a track table, one column a component."""
    with path.open("wb") as file:
        delimited.write(named.give(columns), file)
