"""Track tables as Parquet."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables.opening import Content
from trackmetrics._tables.polars_columns import data_frame, need_polars
from trackmetrics.tracks import frames, named


def read(content: Content, mapping: named.Mapped) -> dict[str, Any]:
    """The arguments of a track table."""
    polars = need_polars("Parquet")
    source = content.source if isinstance(content.source, Path) else io.BytesIO(content.source)
    return named.take(frames.columns(polars.read_parquet(source)), mapping, content.name)


def write(path: Path, columns: Mapping[str, Any]) -> None:
    """Write a track table, one column a component."""
    need_polars("Parquet")
    data_frame(named.give(columns)).write_parquet(path)
