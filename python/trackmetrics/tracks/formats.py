"""Every form of a track table in a file: the one place that lists them.

A new format is a module with ``read`` and ``write``, and a line here.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from trackmetrics._tables.opening import Content

_HERE = "trackmetrics.tracks"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


@dataclass(frozen=True)
class Format:
    """A form of a track table in a file."""

    name: str
    suffix: str
    module: str
    """The module that reads and writes it, imported when it is first used."""
    title: str
    pattern: str = ""
    """What the first line of a file without headings matches; "" for files with headings."""

    @property
    def read(self) -> Callable[..., Any]:
        """The function that reads it."""
        read: Callable[..., Any] = import_module(self.module).read
        return read

    @property
    def write(self) -> Callable[..., None]:
        """The function that writes it."""
        write: Callable[..., None] = import_module(self.module).write
        return write


FORMATS = (
    Format(
        "motchallenge",
        ".txt",
        f"{_HERE}.mot_challenge",
        "MOTChallenge",
        rf"\s*{_NUMBER}(?:\s*,\s*{_NUMBER}){{3,}}\s*$",
    ),
    Format(
        "kitti_mots",
        ".txt",
        f"{_HERE}.kitti_mots",
        "KITTI MOTS",
        r"\s*\d+\s+\d+(?:\s+\d+){3}\s+\S+\s*$",
    ),
    Format("kitti", ".txt", f"{_HERE}.kitti", "KITTI tracking", r"\s*\d+\s+-?\d+\s+[A-Za-z_]\w*\s"),
    Format("csv", ".csv", f"{_HERE}.csv", "delimited text"),
    Format("parquet", ".parquet", f"{_HERE}.parquet", "Parquet"),
)


def names() -> str:
    """The names of the formats, for messages."""
    return ", ".join(repr(form.name) for form in FORMATS)


def named(name: str) -> Format:
    """The format of that name."""
    for form in FORMATS:
        if form.name == name:
            return form
    raise ValueError(f"format must be one of {names()}, got {name!r}")


def to_read(content: Content, name: str | None) -> Format:
    """The format of a file: the one named, or the one that its first line shows."""
    if name is not None:
        return named(name)
    if content.kind == "parquet":
        return named("parquet")
    first = content.head(1 << 16).lstrip().partition(b"\n")[0].decode(errors="replace")
    if not first and not content.name.endswith(".csv"):
        return named("motchallenge")
    for form in FORMATS:
        if form.pattern and re.match(form.pattern, first):
            return form
    return named("csv")


def to_write(path: Path, name: str | None) -> Format:
    """The format named, or that of the ending of a path."""
    if name is not None:
        return named(name)
    found = [form for form in FORMATS if form.suffix == path.suffix]
    if len(found) == 1:
        return found[0]
    raise ValueError(
        f"format must be given for {path.name!r} (one of {names()}): only .csv and .parquet tell it"
    )
