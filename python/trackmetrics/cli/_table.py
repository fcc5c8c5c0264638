"""Tables of the commands: columns with one definition each, printed in several formats.

A column is defined once, by a :class:`Column`; every format and every command that shows it reads
that definition.
"""

import csv
import io
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import IO, Any

from trackmetrics._format import number
from trackmetrics.results import to_json

GAP = 2
"""Blanks between two columns."""


@dataclass(frozen=True)
class Column:
    """One column of a table."""

    name: str
    """Its name in CSV and JSON."""
    value: Callable[[Any], Any]
    """The value of a row, for CSV and JSON."""
    heading: str = ""
    """Its heading in a table; the default is ``name`` with blanks."""
    text: Callable[[Any], str] | None = None
    """The text of a row in a table; the default is its value with four digits."""
    rank: int | None = 0
    """On narrow terminals the columns of the lowest ranks are shown; None: only in CSV and JSON."""
    right: bool = False
    """Whether it is aligned to the right."""
    style: Callable[[Any], str] | None = None
    """The colour of a row on a terminal."""

    @property
    def title(self) -> str:
        """The heading."""
        return self.heading or self.name.replace("_", " ")

    def cell(self, row: Any) -> str:
        """The text of a row."""
        if self.text is not None:
            return self.text(row)
        value = self.value(row)
        if value is None or value != value:
            return "-"
        return number(value, 4) if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Table:
    """Rows of any kind and the columns that show them."""

    columns: Sequence[Column]
    rows: Sequence[Any]

    def shown(self) -> list[Column]:
        """The columns of a printed table."""
        return [column for column in self.columns if column.rank is not None]

    def records(self) -> list[dict[str, Any]]:
        """The rows as dictionaries, ready for JSON."""
        return [
            {column.name: to_json(column.value(row)) for column in self.columns}
            for row in self.rows
        ]


def to_csv(table: Table) -> str:
    """Comma-separated values, undefined ones empty."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([column.name for column in table.columns])
    for record in table.records():
        writer.writerow(["" if value is None else value for value in record.values()])
    return file.getvalue()


def to_markdown(table: Table) -> str:
    """A Markdown table."""
    columns = table.shown()
    lines = [[column.title for column in columns]]
    lines.append(["---:" if column.right else "---" for column in columns])
    lines += [[c.cell(row).replace("|", "\\|") for c in columns] for row in table.rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def fitting(table: Table, width: int | None) -> list[Column]:
    """The columns that fit into a width: all without one, else those of the lowest ranks."""
    columns = table.shown()
    if width is None:
        return columns
    widths = {column.name: _width(column, table.rows) for column in columns}
    kept: list[Column] = []
    for column in sorted(columns, key=lambda column: column.rank or 0):
        total = sum(widths[c.name] + GAP for c in [*kept, column]) - GAP
        if total <= width or not kept:
            kept.append(column)
    return [column for column in columns if column in kept]


def _width(column: Column, rows: Sequence[Any]) -> int:
    from rich.cells import cell_len

    return max([cell_len(column.title), *(cell_len(column.cell(row)) for row in rows)])


def terminal_width(file: IO[str]) -> int | None:
    """The width of a terminal; None where the file is none, so that nothing need be left out."""
    return shutil.get_terminal_size((80, 24)).columns if file.isatty() else None


def to_text(table: Table, file: IO[str], width: int | None) -> str:
    """An aligned table for ``file``, coloured where that is a terminal that has colours."""
    import os

    from rich.console import Console
    from rich.table import Table as Grid
    from rich.text import Text

    plain = not file.isatty() or "NO_COLOR" in os.environ
    grid = Grid(box=None, pad_edge=False, padding=(0, GAP, 0, 0), header_style="bold")
    columns = fitting(table, width)
    for i, column in enumerate(columns):
        grid.add_column(
            Text(column.title, style="bold"),
            justify="right" if column.right else "left",
            no_wrap=True,
            overflow="ellipsis" if i == 0 else "fold",
        )
    for row in table.rows:
        cells = [
            Text(column.cell(row), style=column.style(row) if column.style else "")
            for column in columns
        ]
        grid.add_row(*cells)
    console = Console(
        file=file,
        width=width or 100_000,
        color_system=None if plain else "auto",
        highlight=False,
        markup=False,
        emoji=False,
    )
    with console.capture() as capture:
        console.print(grid)
    return "".join(f"{line.rstrip()}\n" for line in capture.get().splitlines())
