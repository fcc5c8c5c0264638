"""Every form of a log in a file: the one place that lists them.

Reading, writing, messages and the command line's help are made from this table. A new format is a
module with ``read(content)`` and perhaps ``write(path, header, columns)``, and a line here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from trackmetrics._tables.opening import Content
from trackmetrics.logs.header import LogHeader

Reader = Callable[[Content], tuple[dict[str, Any], LogHeader]]
Writer = Callable[[Path, Mapping[str, Any], Mapping[str, Any]], None]


@dataclass(frozen=True)
class Format:
    """A form of a log in a file."""

    suffix: str
    module: str
    """The module that reads and writes it, imported when it is first used."""
    title: str
    kind: str = "text"
    """What the file holds, by its first bytes; see :class:`Content`."""
    can_write: bool = True

    @property
    def read(self) -> Reader:
        """The function that reads it."""
        read: Reader = import_module(self.module).read
        return read

    @property
    def write(self) -> Writer:
        """The function that writes it."""
        write: Writer = import_module(self.module).write
        return write


_HERE = "trackmetrics.logs"
FORMATS = (
    Format(".jsonl", f"{_HERE}.jsonl", "JSON Lines"),
    Format(".csv", f"{_HERE}.csv", "delimited text"),
    Format(".parquet", f"{_HERE}.parquet", "Parquet", "parquet"),
    Format(".ulg", f"{_HERE}.px4", "PX4 flight log", "ulog", can_write=False),
)


def suffixes(*, written: bool = False) -> str:
    """The endings, for messages and help: ``.jsonl, .csv, .parquet``."""
    return ", ".join(f.suffix for f in FORMATS if f.can_write or not written)


def to_read(path: Path | str, content: Content) -> Format:
    """The format of a file: by its first bytes, of text by its ending, else by its first line."""
    for form in FORMATS:
        if form.kind == content.kind != "text":
            return form
    endings = {suffix.lower() for suffix in Path(content.name).suffixes}
    for form in FORMATS:
        if form.kind == "text" and form.suffix in endings:
            return form
    if any(f.suffix in endings for f in FORMATS):
        form = next(f for f in FORMATS if f.suffix in endings)
        raise ValueError(f"{content.name} is text, not a {form.title} file")
    known = {".txt", ".tsv", ".dat", ".json", ".ndjson", ".gz", ".xz", ".zip"}
    if endings and not endings <= known and str(path) != "-":
        raise ValueError(f"path must end in {suffixes()}, got {Path(path).name!r}")
    is_json = content.head().lstrip()[:1] == b"{"
    return next(f for f in FORMATS if f.suffix == (".jsonl" if is_json else ".csv"))


def to_write(path: Path) -> Format:
    """The format that the ending of a name asks for."""
    for form in FORMATS:
        if form.can_write and path.suffix == form.suffix:
            return form
    raise ValueError(f"path must end in {suffixes(written=True)}, got {path.name!r}")
