"""``trackmetrics diagnose LOG``: is the estimator consistent, since when not, in which state?"""

from typing import Any

import click

from trackmetrics.cli._log_options import log_options, read_log_with
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
@log_options
@click.option("--html", metavar="FILE", help="Write a page with figures.")
@click.option(
    "--fail-on-inconsistent",
    is_flag=True,
    help="Exit with status 1 unless every track is consistent.",
)
@output_options
def command(
    log: str, html: str | None, fail_on_inconsistent: bool, output: Output, **reading: Any
) -> int:
    """Test whether the covariance of an estimator is consistent with its errors.

    Reads the log of an estimator ({read}; one row per update) and reports for
    every track its verdict, the time from which it is inconsistent, and the weakest state. NIS
    with its degrees of freedom is enough; innovations, covariances and truth give more detail.
    """
    from trackmetrics.cli._verdicts import diagnosis_table
    from trackmetrics.diagnostics import diagnose

    found = read_log_with(log, reading)
    output.detail(f"read {log}: {len(found)} updates of {len(found.tracks)} tracks")
    diagnosis = diagnose(found)
    if html:
        write_diagnosis_page(output, html, diagnosis, found)
    output.write(diagnosis_table(diagnosis), content=diagnosis, after=diagnosis.text)
    return 1 if fail_on_inconsistent and not diagnosis.consistent else 0
