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
    head = content.head()
    first = json_lines.first_record(head, content.name)
    if not headers.is_record(first):
        return json_lines.read(content.source, content.name), LogHeader()
    start = head.index(b"\n", head.index(b"{")) + 1 if b"\n" in head.strip() else len(head)
    table = json_lines.read(content.source, content.name, start, 2)
    return table, headers.from_record(first, content.name)


def write(path: Path, header: Mapping[str, Any], columns: Mapping[str, Any]) -> None:
    """Write columns as they are serialised."""
    with path.open("wb") as file:
        file.write(json.dumps(header, ensure_ascii=False).encode() + b"\n")
        json_lines.write(columns, file)
