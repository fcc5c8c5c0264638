"""Logs as Parquet, the header as metadata of the file."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables.opening import Content
from trackmetrics._tables.polars_columns import data_frame, need_polars, to_array
from trackmetrics.logs import header as headers
from trackmetrics.logs.header import LogHeader

METADATA_KEY = "trackmetrics"


def read(content: Content) -> tuple[dict[str, Any], LogHeader]:
    """The columns in a file, and its header."""
    polars = need_polars("Parquet")
    source = content.source if isinstance(content.source, Path) else io.BytesIO(content.source)
    metadata = polars.read_parquet_metadata(source).get(METADATA_KEY)
    frame = polars.read_parquet(source)
    header = headers.from_record(json.loads(metadata), content.name) if metadata else LogHeader()
    return {name: to_array(frame.drop_in_place(name)) for name in frame.columns}, header


def write(path: Path, header: Mapping[str, Any], columns: Mapping[str, Any]) -> None:
    """Write columns as they are serialised."""
    need_polars("Parquet")
    data_frame(columns).write_parquet(path, metadata={METADATA_KEY: json.dumps(header)})
