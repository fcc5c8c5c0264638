"""Logs as delimited text: one column an element, ``x[0]``, ``x[1]``, ...; a header comment."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables import delimited, json_lines
from trackmetrics._tables.opening import Content
from trackmetrics.logs import header as headers
from trackmetrics.logs.header import LogHeader
from trackmetrics.logs.schema import STRING_COLUMNS
from trackmetrics.logs.serialization import by_element


def read(content: Content) -> tuple[dict[str, Any], LogHeader]:
    """The columns in a file, and its header."""
    start, header = 0, LogHeader()
    head = content.head()
    if head.startswith(b"# {"):
        first = head.partition(b"\n")[0]
        start = len(first) + 1
        record = json_lines.parse(first[2:].decode(), content.name, 1)
        header = headers.from_record(record, content.name)
    text = ("track", *STRING_COLUMNS)
    return delimited.read(content.source, content.name, text, start), header


def write(path: Path, header: Mapping[str, Any], columns: Mapping[str, Any]) -> None:
    """Write columns as they are serialised, lists element by element."""
    comment = "# " + json.dumps(header, ensure_ascii=False) + "\n"
    with path.open("wb") as file:
        file.write(comment.encode())
        delimited.write(by_element(columns), file)
