"""``trackmetrics tune LOG``: by what must the noises of an estimator be multiplied?"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import click

from trackmetrics._format import number
from trackmetrics.cli._log_options import log_options, read_log_with
from trackmetrics.cli._output import Command, Output, output_options
from trackmetrics.cli._table import Column, Table
from trackmetrics.diagnostics import Factor, NoiseEstimate


@dataclass(frozen=True)
class Row:
    """One factor, and what to do about it."""

    noise: str
    factor: Factor
    change: str


COLUMNS = (
    Column("noise", lambda r: r.noise),
    Column("factor", lambda r: r.factor.factor, "factor", lambda r: _number(r.factor.factor)),
    Column("low", lambda r: r.factor.interval[0], "from", lambda r: number(r.factor.interval[0])),
    Column("high", lambda r: r.factor.interval[1], "to", lambda r: number(r.factor.interval[1])),
    Column("p_value", lambda r: r.factor.p_value, "p", lambda r: _number(r.factor.p_value), rank=2),
    Column("change", lambda r: r.change, rank=1),
)


@click.command(
    cls=Command,
    examples="""
    trackmetrics tune run.jsonl
    trackmetrics tune run.parquet --process by_block
    trackmetrics tune run.jsonl --robust --format json
    """,
)
@click.argument("log", metavar="LOG")
@click.option(
    "--process",
    type=click.Choice(["all", "by_block"]),
    default="all",
    help="One factor on the process noise, or one for each block of states.",
)
@click.option(
    "--by",
    type=click.Choice(["type", "all"]),
    default="type",
    help="A factor for each measurement type, or one for all.",
)
@click.option("--confidence", type=float, default=0.95, help="Confidence of the intervals.")
@click.option("--robust", is_flag=True, help="Set outliers aside.")
@log_options
@output_options
def command(
    log: str, process: str, by: str, confidence: float, robust: bool, output: Output, **reading: Any
) -> int:
    """Estimate by what the process and measurement noises must be multiplied.

    Reads the log of an estimator ({read}) with innovations, S, A, P_pred
    and H or observed; prints a factor on each claimed covariance, its confidence interval and what
    to change. With innovations and S alone the answer is a direction.
    """
    from trackmetrics.diagnostics import estimate_noise

    found = read_log_with(log, reading)
    output.detail(f"read {log}: {len(found)} updates of {len(found.tracks)} tracks")
    estimate = estimate_noise(
        found,
        process=process,
        measurement="by_type" if by == "type" else "all",
        confidence=confidence,
        robust=robust,
    )
    output.write(Table(COLUMNS, rows(estimate)), content=estimate, after=advice(estimate))
    return 0


def rows(estimate: NoiseEstimate) -> list[Row]:
    """One row for each factor."""
    parts: tuple[tuple[str, str, Mapping[str, Factor]], ...] = (
        ("process", "Q", estimate.process),
        ("measurement", "R", estimate.measurement),
    )
    return [
        Row(f"{kind} {name}", factor, _change(matrix, name, factor, f"{kind} {name}", estimate))
        for kind, matrix, factors in parts
        for name, factor in factors.items()
    ]


def _change(matrix: str, name: str, factor: Factor, noise: str, estimate: NoiseEstimate) -> str:
    if not factor.identifiable:
        return "the log does not tell"
    if noise not in estimate.causes:
        return "keep"
    return f"multiply {matrix} of {name} by {number(factor.factor)}"


def advice(estimate: NoiseEstimate) -> str:
    """What to do, in a sentence or two."""
    return repr(estimate).splitlines()[-1] if estimate.grade == "exact" else repr(estimate)


def _number(value: float) -> str:
    return "-" if value != value else number(value)
