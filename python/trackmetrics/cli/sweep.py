"""``trackmetrics sweep MODULE:FUNCTION``: a Monte Carlo sweep from the command line."""

import ast
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from trackmetrics._format import number
from trackmetrics.cli._output import Command, Output, output_options
from trackmetrics.cli._table import Column, Table


@click.command(
    cls=Command,
    examples="""
    trackmetrics sweep tune_cv_filter:simulate --runs 1000 --grid q=0.01,0.1,1
    trackmetrics sweep tune_cv_filter:simulate --workers 2 --checkpoint s.ckpt --html out.html
    """,
)
@click.argument("simulate", metavar="MODULE:FUNCTION")
@click.option("--runs", default=1000, show_default=True, help="Runs of each setting.")
@click.option("--seed", default=0, show_default=True, help="Seed of every random number.")
@click.option(
    "--grid",
    multiple=True,
    metavar="NAME=VALUE,...",
    help="Values of a parameter, Python literals or strings; may be given for several.",
)
@click.option("--workers", type=int, help="Processes that share the runs.")
@click.option("--chunk-size", type=int, help="Runs per job.")
@click.option("--checkpoint", metavar="FOLDER", help="Keeps finished runs, to resume from.")
@click.option("--keep-going", is_flag=True, help="List runs that fail, and go on.")
@click.option(
    "--rank-by",
    default="anees",
    show_default=True,
    metavar="CRITERION",
    help="What makes a setting the best one.",
)
@click.option("--parquet", metavar="FILE", help="Write every setting and step.")
@click.option("--html", metavar="FILE", help="Write a page with figures.")
@output_options
def command(
    simulate: str,
    rank_by: str,
    parquet: str | None,
    html: str | None,
    output: Output,
    **options: Any,
) -> int:
    """Run a simulation many times for every setting of a grid, and test its filter.

    Calls FUNCTION(rng, **settings) of MODULE for every run and setting, and prints ANEES and the
    scores of each setting with 95 % intervals, and the best setting. FUNCTION is one run: it
    returns a mapping with truth, estimates and covariances as arrays over steps, and any numbers
    as scores.
    """
    from trackmetrics.monte_carlo import SweepInterrupted

    function = load_function(simulate)
    if html:
        import_module("matplotlib")  # fail before the work, not after it
        import_module("jinja2")
    status = 0
    try:
        result = _sweep(function, **options)
    except SweepInterrupted as stop:
        output.warn(f"trackmetrics sweep: interrupted {stop}")
        result, status = stop.result, 130
    if status and not any(state.accumulators for state in result.setting_states):
        return status
    best = _best(result, rank_by)
    output.write(
        sweep_table(result, best), content=_content(result, best), after=_remarks(result, best)
    )
    if parquet:
        result.to_parquet(parquet)
        output.message(f"wrote {parquet}")
    if html:
        from trackmetrics.report import write_sweep_page

        write_sweep_page(html, result, title=simulate, best=best)
        output.message(f"wrote {html}")
    return status


def _sweep(
    function: Any,
    runs: int,
    seed: int,
    grid: tuple[str, ...],
    workers: int | None,
    chunk_size: int | None,
    checkpoint: str | None,
    keep_going: bool,
) -> Any:
    from trackmetrics.monte_carlo import sweep

    return sweep(
        function,
        runs,
        seed=seed,
        grid=parse_grid(grid),
        executor=None if workers is None else "processes",
        workers=workers,
        chunk=chunk_size,
        checkpoint=checkpoint,
        on_error="collect" if keep_going else "raise",
    )


def load_function(name: str) -> Any:
    """The function of ``module:function``; the module may be in the working directory."""
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


def parse_grid(options: Any) -> dict[str, list[Any]] | None:
    """The values of each ``NAME=VALUE,...``: Python literals or strings."""
    values: dict[str, list[Any]] = {}
    for option in options:
        name, equals, text = option.partition("=")
        if not equals or not name or not text:
            raise ValueError(f"--grid expects NAME=VALUE,..., got {option!r}")
        values[name] = [_literal(value.strip()) for value in text.split(",")]
    return values or None


def _literal(text: str) -> Any:
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def _best(result: Any, rank_by: str) -> Any:
    """The best setting; None by default if the runs gave no truth."""
    if rank_by == "anees" and "nees" not in result.scores:
        return None
    return result.best(rank_by)


def _content(result: Any, best: Any) -> dict[str, Any]:
    return {**result.to_dict(), "best": None if best is None else best.to_dict()}


def sweep_table(result: Any, best: Any) -> Table:
    """One row per setting, the best one marked; scores with their intervals."""
    values = result.to_columns("settings")
    shown = [*result.grid[0], "runs", *result.scores]
    columns = [
        Column(
            "best",
            lambda k: best is not None and k == best.index,
            " ",
            lambda k: "*" if best is not None and k == best.index else "",
            style=lambda _: "bold green",
        )
    ]
    columns += [_column(values, name, rank) for rank, name in enumerate(shown)]
    columns += [_column(values, name, None) for name in values if name not in shown]
    return Table(columns, range(len(result.grid)))


def _column(values: Any, name: str, rank: int | None) -> Column:
    def text(k: int) -> str:
        value = values[name][k]
        if f"{name}_low" not in values:
            return f"{value:g}" if isinstance(value, float) else str(value)
        low, high = values[f"{name}_low"][k], values[f"{name}_high"][k]
        return f"{number(value, 4)} [{number(low, 4)}, {number(high, 4)}]"

    return Column(name, lambda k: values[name][k], name, text, rank)


def _remarks(result: Any, best: Any) -> str:
    said = [] if best is None else best.describe()
    remarks = [mark + text for mark, text in zip(("* ", "  "), said, strict=False)]
    if result.failures:
        remarks.append(f"{len(result.failures)} runs failed; the first: {result.failures[0].error}")
    return "\n".join(remarks)
