"""``trackmetrics sweep MODULE:FUNCTION``: a Monte Carlo sweep from the command line."""

import argparse
import ast
import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from trackmetrics.monte_carlo import SweepInterrupted, SweepResult, sweep

_EXPLANATION = """
Calls FUNCTION(rng, **settings) of MODULE for every run and setting, and prints ANEES and the scores
of each setting with 95 % intervals, and the best setting. FUNCTION is one run: it returns a mapping
with truth, estimates and covariances as arrays over steps, and any numbers as scores.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Says what the command takes."""
    parser.description = _EXPLANATION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("simulate", metavar="MODULE:FUNCTION", help="one run")
    parser.add_argument("--runs", type=int, default=1000, help="runs of each setting (1000)")
    parser.add_argument("--seed", type=int, default=0, help="decides every random number (0)")
    parser.add_argument(
        "--grid",
        action="append",
        default=[],
        metavar="NAME=VALUE,...",
        help="values of a parameter; may be given for several",
    )
    parser.add_argument("--workers", type=int, help="processes to spread the runs over")
    parser.add_argument("--chunk", type=int, help="runs of a job")
    parser.add_argument("--checkpoint", metavar="FOLDER", help="keeps what is done, to go on from")
    parser.add_argument("--collect", action="store_true", help="list runs that fail, and go on")
    parser.add_argument("--best", default="anees", metavar="CRITERION", help="of the best setting")
    parser.add_argument("--format", choices=["table", "json"], default="table")
    parser.add_argument("--parquet", metavar="FILE", help="writes every setting and step")
    parser.add_argument("--html", metavar="FILE", help="writes the figures as a page")


def run(arguments: argparse.Namespace) -> int:
    """Runs the sweep and prints what it found; status 130 where it was interrupted."""
    simulate = function(arguments.simulate)
    if arguments.html:
        import_module("matplotlib")  # a lack is better known before the work than after it
    try:
        result, status = _sweep(simulate, arguments), 0
    except SweepInterrupted as stop:
        print(f"interrupted {stop}", file=sys.stderr)
        result, status = stop.result, 130
    if status and not any(tally.cells for tally in result.tallies):
        return status
    if arguments.format == "json":
        print(json.dumps(_content(result, arguments.best), indent=2))
    else:
        print("\n".join(_table(result, arguments.best)))
    if arguments.parquet:
        result.to_parquet(arguments.parquet)
    if arguments.html:
        from trackmetrics.report.sweep_page import write_sweep_page

        best = _best(result, arguments.best)
        write_sweep_page(arguments.html, result, title=arguments.simulate, best=best)
    return status


def _sweep(simulate: Any, arguments: argparse.Namespace) -> SweepResult:
    return sweep(
        simulate,
        arguments.runs,
        seed=arguments.seed,
        grid=grid(arguments.grid),
        executor=None if arguments.workers is None else "processes",
        workers=arguments.workers,
        chunk=arguments.chunk,
        checkpoint=arguments.checkpoint,
        on_error="collect" if arguments.collect else "raise",
    )


def function(name: str) -> Any:
    """The function of ``module:function``; a module of the working directory will do."""
    module, colon, attribute = name.partition(":")
    if not colon or not module or not attribute:
        raise ValueError(f"expected MODULE:FUNCTION, got {name!r}")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    found = import_module(module)
    for part in attribute.split("."):
        if not hasattr(found, part):
            raise ValueError(f"{module} has no {attribute}")
        found = getattr(found, part)
    return found


def grid(options: list[str]) -> dict[str, list[Any]] | None:
    """The values of each ``NAME=VALUE,...``: Python literals, or words."""
    values: dict[str, list[Any]] = {}
    for option in options:
        name, equals, text = option.partition("=")
        if not equals or not name or not text:
            raise ValueError(f"--grid expects NAME=VALUE,..., got {option!r}")
        values[name] = [_literal(word) for word in text.split(",")]
    return values or None


def _literal(word: str) -> Any:
    try:
        return ast.literal_eval(word.strip())
    except (ValueError, SyntaxError):
        return word.strip()


def _content(result: SweepResult, by: str) -> dict[str, Any]:
    best = _best(result, by)
    return {**result.to_dict(), "best": None if best is None else best.to_dict()}


def _best(result: SweepResult, by: str) -> Any:
    """The best setting; none where nobody asked and the runs gave no truth."""
    if by == "anees" and "nees" not in result.scores:
        return None
    return result.best(by)


def _table(result: SweepResult, by: str) -> list[str]:
    """A line for each setting, the best one, and how many runs failed."""
    columns = result.to_columns("settings")
    parameters = list(result.grid[0])
    names = ["runs", *result.scores]
    rows = [["", *parameters, *names]]
    for k in range(len(result.grid)):
        row = [f"{columns[name][k]:g}" if isinstance(columns[name][k], float)
               else str(columns[name][k]) for name in parameters]  # fmt: skip
        row += [str(columns["runs"][k])]
        row += [
            f"{columns[name][k]:.4g} [{columns[f'{name}_low'][k]:.4g}, "
            f"{columns[f'{name}_high'][k]:.4g}]"
            for name in result.scores
        ]
        rows.append(["", *row])
    best = _best(result, by)
    if best is not None:
        rows[best.index + 1][0] = "*"
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(f"{x:<{w}}" for x, w in zip(row, widths, strict=True)) for row in rows]
    return [line.rstrip() for line in lines] + _remarks(result, best)


def _remarks(result: SweepResult, best: Any) -> list[str]:
    marks = ("* ", "  ")
    said = [] if best is None else best.words()
    remarks = [mark + words for mark, words in zip(marks, said, strict=False)]
    if result.failures:
        remarks.append(f"{len(result.failures)} runs failed; the first: {result.failures[0].error}")
    return remarks
