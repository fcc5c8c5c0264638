"""``trackmetrics diagnose LOG``: is the estimator consistent, since when not, in which state?"""

from typing import Any

import click

from trackmetrics.cli._output import Command, Output, output_options, write_diagnosis_page


@click.command(
    cls=Command,
    examples="""
    trackmetrics diagnose run.jsonl
    trackmetrics diagnose run.csv --rename time=t --rename x=px,vx --states px,vx
    trackmetrics diagnose run.parquet --html run.html
    trackmetrics diagnose run.jsonl --fail-on-inconsistent --quiet
    trackmetrics diagnose run.jsonl --format csv -o verdicts.csv
    """,
)
@click.argument("log", metavar="LOG")
@click.option(
    "--rename",
    multiple=True,
    metavar="NAME=COLUMN[,COLUMN...]",
    help="The file's name of a column, or the columns of a vector; may be repeated.",
)
@click.option("--states", metavar="NAME,NAME,...", help="Names of the states.")
@click.option(
    "--angle",
    multiple=True,
    metavar="STATE=PERIOD",
    help="A state that is an angle, and its period; may be repeated.",
)
@click.option("--html", metavar="FILE", help="Write a page with figures.")
@click.option(
    "--fail-on-inconsistent",
    is_flag=True,
    help="Exit with status 1 unless every track is consistent.",
)
@output_options
def command(
    log: str,
    rename: tuple[str, ...],
    states: str | None,
    angle: tuple[str, ...],
    html: str | None,
    fail_on_inconsistent: bool,
    output: Output,
) -> int:
    """Test whether the covariance of an estimator is consistent with its errors.

    Reads the log of an estimator ({read}; one row per update) and reports for
    every track its verdict, the time from which it is inconsistent, and the weakest state. NIS
    with its degrees of freedom is enough; innovations, covariances and truth give more detail.
    """
    from trackmetrics.cli._verdicts import diagnosis_table
    from trackmetrics.diagnostics import diagnose
    from trackmetrics.logs import read_log

    found = read_log(
        log,
        columns={name: _names(value) for name, value in map(_pair, rename)} or None,
        states=states.split(",") if states else None,
        angles={name: float(period) for name, period in map(_pair, angle)} or None,
        progress=True,
    )
    output.detail(f"read {log}: {len(found)} updates of {len(found.tracks)} tracks")
    diagnosis = diagnose(found)
    if html:
        write_diagnosis_page(output, html, diagnosis, found)
    output.write(diagnosis_table(diagnosis), content=diagnosis, after=diagnosis.text)
    return 1 if fail_on_inconsistent and not diagnosis.consistent else 0


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"expected NAME=VALUE, got {text!r}")
    return name, value


def _names(value: str) -> Any:
    return value.split(",") if "," in value else value
