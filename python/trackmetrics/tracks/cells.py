"""Text without headings: lines of cells, as MOTChallenge and KITTI write them."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.errors import value
from trackmetrics._tables.opening import Content
from trackmetrics._tables.polars_columns import data_frame, polars

_LARGEST_WHOLE = 2**53


class Cells:
    """The cells of a file, column by column; every error names the file and the line."""

    def __init__(self, content: Content, separator: str, name: str | None = None) -> None:
        if content.kind != "text":
            raise ValueError(f"{content.name} is a {content.kind} file, expected text")
        self.name = name or content.name
        data = _plain(content.data, separator)
        sizes, counts = _measure(data, separator)
        filled = sizes > 0
        self.lines = np.flatnonzero(filled) + 1
        """The line number of each row."""
        self.counts = counts[filled]
        """The number of cells of each row."""
        self._separator = separator
        self._columns = self._split(data, filled)

    def __len__(self) -> int:
        return len(self.lines)

    @property
    def width(self) -> int:
        """The number of cells of the longest row."""
        return int(self.counts.max()) if len(self) else 0

    def where(self, row: int) -> str:
        """File and line of a row."""
        return f"{self.name}:{self.lines[row]}"

    def need(self, names: Sequence[str], *, most: int | None = None, same: bool = False) -> None:
        """Refuse rows of fewer cells than names, of more than ``most``, or of different numbers."""
        short = np.flatnonzero(self.counts < len(names))
        if len(short):
            row, needed = int(short[0]), ",".join(names)
            found = self.counts[row]
            raise ValueError(f"{self.where(row)}: expected {needed} and more, got {found} columns")
        long = np.flatnonzero(self.counts > (most or self.width))
        if len(long):
            row = int(long[0])
            raise ValueError(
                f"{self.where(row)}: expected at most {most} columns, got {self.counts[row]}"
            )
        other = np.flatnonzero(self.counts != self.counts[:1])
        if same and len(other):
            row = int(other[0])
            raise ValueError(
                f"{self.where(row)}: expected {self.counts[0]} columns as in line "
                f"{self.lines[0]}, got {self.counts[row]}"
            )

    def text(self, column: int) -> NDArray[np.object_]:
        """A column as text."""
        cells = self._columns[column]
        return np.array(cells if isinstance(cells, list) else cells.to_list(), dtype=object)

    def numbers(self, column: int, title: str) -> NDArray[np.float64]:
        """A column as finite numbers; NaN where a row is too short to have it."""
        cells = self._columns[column]
        found = _by_python(cells) if isinstance(cells, list) else _by_polars(cells)
        there = self.counts > column
        wrong = np.flatnonzero(there & ~np.isfinite(found))
        if len(wrong):
            row = int(wrong[0])
            self._refuse(row, title, cells[row])
        return found

    def _refuse(self, row: int, title: str, cell: str | None) -> None:
        word = (cell or "").strip()
        try:
            number = float(word)
        except ValueError:
            raise ValueError(
                f"{self.where(row)}: {title} must be a number, got {value(word)}"
            ) from None
        raise ValueError(f"{self.where(row)}: {title} must be finite, got {number!r}")

    def whole(self, column: int, title: str) -> NDArray[np.int64]:
        """A column as whole numbers."""
        found = self.numbers(column, title)
        wrong = np.flatnonzero((found != np.trunc(found)) | (np.abs(found) > _LARGEST_WHOLE))
        if len(wrong):
            row = int(wrong[0])
            raise ValueError(
                f"{self.where(row)}: {title} must be a whole number, got {float(found[row])!r}"
            )
        return found.astype(np.int64)

    def _split(self, data: bytes, filled: NDArray[np.bool_]) -> list[Any]:
        pl = polars()
        if pl is not None and len(self) and (self.counts == self.width).all():
            schema = {f"c{i}": pl.String for i in range(self.width)}
            frame = pl.read_csv(
                io.BytesIO(data),
                has_header=False,
                schema=schema,
                separator=self._separator,
                quote_char=None,
            )
            if len(frame) == len(filled):
                frame = frame.filter(pl.Series(filled))
            if len(frame) == len(self):
                return list(frame.get_columns())
        rows = [line.split(self._separator) for line in data.decode().split("\n") if line]
        width = self.width
        padded = [row + [""] * (width - len(row)) for row in rows]
        return [[row[i] for row in padded] for i in range(width)]


def _plain(data: bytes, separator: str) -> bytes:
    """Lines that end in a line feed, without blanks at their ends, one blank between cells."""
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if separator == " " and (b"\t" in data or b"  " in data):
        data = re.sub(rb"[ \t]+", b" ", data)
    if b" " in data or b"\t" in data:
        data = re.sub(rb"(?m)^[ \t]+|[ \t]+$", b"", data)
    return data


def _measure(data: bytes, separator: str) -> tuple[NDArray[Any], NDArray[Any]]:
    """The number of bytes and of cells of each line."""
    if not data:
        none = np.empty(0, dtype=np.int64)
        return none, none
    block = np.frombuffer(data if data.endswith(b"\n") else data + b"\n", np.uint8)
    ends = np.flatnonzero(block == ord("\n"))
    separators = np.searchsorted(np.flatnonzero(block == ord(separator)), ends)
    return np.diff(ends, prepend=-1) - 1, np.diff(separators, prepend=0) + 1


def _by_polars(cells: Any) -> NDArray[np.float64]:
    pl = polars()
    numbers = cells.str.strip_chars().cast(pl.Float64, strict=False)
    return np.array(numbers.to_numpy(), dtype=np.float64)


def _by_python(cells: list[str]) -> NDArray[np.float64]:
    try:
        return np.array(cells, dtype=np.float64)
    except ValueError:
        return np.array([_float(cell) for cell in cells])


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def write(path: Path, columns: Sequence[Any], separator: str) -> None:
    """Write columns as lines of cells, without headings."""
    named: Mapping[str, Any] = {f"c{i}": _shortest(c) for i, c in enumerate(columns)}
    if polars() is not None:
        frame = data_frame(named)
        with path.open("wb") as file:
            frame.write_csv(file, include_header=False, separator=separator, quote_style="never")
        return
    with path.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(
            text, delimiter=separator, lineterminator="\n", quoting=csv.QUOTE_NONE, quotechar=None
        )
        writer.writerows(zip(*(c.tolist() for c in named.values()), strict=True))


def _shortest(column: NDArray[Any]) -> NDArray[Any]:
    """Whole numbers without a decimal point; text as it is."""
    is_whole = column.dtype.kind == "f" and (column == np.trunc(column)).all()
    if is_whole and (np.abs(column) < _LARGEST_WHOLE).all():
        return column.astype(np.int64)
    return column.astype(object) if column.dtype.kind in "US" else column
