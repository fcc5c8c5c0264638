"""Where a command prints: its result in the format that was asked for, and its messages.

The result goes to standard output or to ``--output``; everything else to standard error.
"""

import functools
import sys
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from trackmetrics import _progress
from trackmetrics._format import json_text
from trackmetrics.cli._table import Table, fitting, terminal_width, to_csv, to_markdown, to_text

FORMATS = ("table", "json", "csv", "markdown")


class Command(click.Command):
    """A command whose help ends with examples, one per line: the command, then its comment."""

    def __init__(self, *args: Any, examples: str = "", **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.examples = examples

    def get_help(self, context: click.Context) -> str:
        """The help, with the suffixes of logs from the list of their formats."""
        parts: tuple[Any, ...] = (self, *self.params)
        for described in parts:
            text = getattr(described, "help", None) or ""
            if "{read}" in text or "{written}" in text:
                described.help = _with_suffixes(text)
        return super().get_help(context)

    def format_epilog(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Writes the examples as they are."""
        super().format_epilog(context, formatter)
        if self.examples:
            formatter.write_paragraph()
            with formatter.section("Examples"):
                for line in textwrap.dedent(self.examples).strip().splitlines():
                    formatter.write(f"  {line}\n")


def _with_suffixes(text: str) -> str:
    from trackmetrics.logs.formats import suffixes

    return text.replace("{read}", suffixes()).replace("{written}", suffixes(written=True))


@dataclass(frozen=True)
class Output:
    """The format and the place of a result, and how much else is said."""

    format: str = "table"
    path: str | None = None
    quiet: bool = False
    verbose: bool = False

    def message(self, text: str) -> None:
        """A line on standard error, unless ``--quiet``."""
        if not self.quiet:
            print(text, file=sys.stderr)

    def detail(self, text: str) -> None:
        """A line on standard error, with ``--verbose``."""
        if self.verbose:
            print(text, file=sys.stderr)

    def warn(self, text: str) -> None:
        """A line on standard error, always."""
        print(text, file=sys.stderr)

    def write(self, table: Table, content: Any = None, before: str = "", after: str = "") -> None:
        """Writes a result.

        Parameters
        ----------
        table
            The rows and columns.
        content
            What JSON holds; the default is the rows of the table.
        before, after
            Paragraphs around the table, in the formats ``table`` and ``markdown``.
        """
        if self.format == "json":
            self._emit(json_text(table.records() if content is None else content) + "\n")
        elif self.format == "csv":
            self._emit(to_csv(table))
        elif self.format == "markdown":
            parts = (before and f"{before}\n", to_markdown(table), after and f"{after}\n")
            self._emit("\n".join(part for part in parts if part))
        else:
            self._emit(self._text(table, before, after))

    def _text(self, table: Table, before: str, after: str) -> str:
        width = None if self.path else terminal_width(sys.stdout)
        parts = (_wrapped(before, width), self._grid(table, width), _wrapped(after, width))
        return "\n".join(part for part in parts if part)

    def _grid(self, table: Table, width: int | None) -> str:
        left_out = [c.title for c in table.shown() if c not in fitting(table, width)]
        if left_out:
            self.message(f"too narrow for {', '.join(left_out)}; --format csv prints every column")
        if self.path is None:
            return to_text(table, sys.stdout, width)
        import io

        return to_text(table, io.StringIO(), None)

    def _emit(self, text: str) -> None:
        if self.path is None:
            sys.stdout.write(text)
        else:
            Path(self.path).write_text(text, encoding="utf-8")
            self.message(f"wrote {self.path}")


def _wrapped(text: str, width: int | None) -> str:
    """Paragraphs at the width of a terminal; unchanged without one."""
    if not text:
        return ""
    if width is None:
        return f"{text}\n"
    lines = (textwrap.fill(line, width, break_on_hyphens=False) for line in text.splitlines())
    return "".join(f"{line}\n" for line in lines)


def output_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Adds ``--format``, ``--output``, ``--quiet`` and ``--verbose``; passes an ``output``."""

    @click.option(
        "--format", "format_", type=click.Choice(FORMATS), default="table", show_default=True
    )
    @click.option("-o", "--output", "path", metavar="FILE", help="Write the result to a file.")
    @click.option("-q", "--quiet", is_flag=True, help="Print nothing but the result and warnings.")
    @click.option("-v", "--verbose", is_flag=True, help="Print more, and the traceback of errors.")
    @functools.wraps(function)
    def wrapper(
        *args: Any, format_: str, path: str | None, quiet: bool, verbose: bool, **kwargs: Any
    ) -> Any:
        _progress.enabled = not quiet
        return function(*args, output=Output(format_, path, quiet, verbose), **kwargs)

    return wrapper


def write_diagnosis_page(output: Output, path: str, *args: Any, **kwargs: Any) -> None:
    """Writes the page of a diagnosis."""
    from trackmetrics.report import write_page

    write_page(path, *args, **kwargs, progress=True)
    output.message(f"wrote {path} ({Path(path).stat().st_size / 1e6:.1f} MB)")
