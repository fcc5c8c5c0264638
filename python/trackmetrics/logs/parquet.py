"""Logs as Parquet, the header as metadata of the file."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables.opening import Content
from trackmetrics._tables.polars_columns import from_array, to_array
from trackmetrics.logs import header as headers
from trackmetrics.logs.header import LogHeader

METADATA_KEY = "trackmetrics"


def read(content: Content) -> tuple[dict[str, Any], LogHeader]:
    """The columns in a file, and its header."""
    import polars

    frame = polars.read_parquet(io.BytesIO(content.data))
    metadata = polars.read_parquet_metadata(io.BytesIO(content.data)).get(METADATA_KEY)
    header = headers.from_record(json.loads(metadata), content.name) if metadata else LogHeader()
    return {name: to_array(frame[name]) for name in frame.columns}, header


def write(path: Path, header: Mapping[str, Any], columns: Mapping[str, Any]) -> None:
    """Write columns as they are serialised."""
    import polars

    frame = polars.DataFrame({name: from_array(column) for name, column in columns.items()})
    frame.write_parquet(path, metadata={METADATA_KEY: json.dumps(header)})
