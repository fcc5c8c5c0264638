"""Logs as JSON Lines: a header record, then one record an update."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables import json_lines
from trackmetrics._tables.opening import Content
from trackmetrics.logs import header as headers
from trackmetrics.logs.header import LogHeader


def read(content: Content) -> tuple[dict[str, Any], LogHeader]:
    """The columns in a file, and its header."""
    first = json_lines.first_record(content.data, content.name)
    if not headers.is_record(first):
        return json_lines.read(content.data, content.name), LogHeader()
    body = content.data.lstrip().partition(b"\n")[2]
    return json_lines.read(body, content.name, 2), headers.from_record(first, content.name)


def write(path: Path, header: Mapping[str, Any], columns: Mapping[str, Any]) -> None:
    """Write columns as they are serialised."""
    first = json.dumps(header, ensure_ascii=False).encode()
    path.write_bytes(first + b"\n" + json_lines.write(columns))
