"""``trackmetrics vessel RECORDING``: the vessel estimator over a recording of AIS."""

from pathlib import Path
from typing import Any

import click

from trackmetrics.cli._output import Command, Output, output_options, write_diagnosis_page

BATCH = 50_000
"""Number of reports that are tracked at once, between two steps of the bar."""
COLUMNS = ("time", "vessel", "lat", "lon", "sog", "cog")


def _column_options(function: Any) -> Any:
    for name in reversed(COLUMNS):
        function = click.option(
            f"--{name}", metavar="COLUMN", help=f"Heading of the column of {name}."
        )(function)
    return function


@click.command(
    cls=Command,
    examples="""
    trackmetrics vessel recording.csv --html vessels.html
    trackmetrics vessel recording.nmea --thin 60 --log run.parquet
    trackmetrics vessel recording.csv --vessel ship_id --format csv -o verdicts.csv
    """,
)
@click.argument("recording", metavar="RECORDING")
@click.option("--html", metavar="FILE", help="Write a page with figures.")
@click.option("--log", metavar="FILE", help="Write the estimator's log ({written}).")
@click.option(
    "--thin",
    type=float,
    metavar="SECONDS",
    help="Use one report of each vessel per interval; the others test the predictions.",
)
@click.option(
    "--min-reports", default=50, show_default=True, help="Reports that a vessel must have."
)
@click.option(
    "--min-speed",
    default=3.0,
    show_default=True,
    help="Knots that the median speed of a vessel must exceed.",
)
@click.option(
    "--preset",
    type=click.Choice(["harbour", "open-sea"]),
    default="harbour",
    show_default=True,
    help="What the filter assumes: manoeuvring traffic, or steady ships.",
)
@_column_options
@output_options
def command(
    recording: str,
    html: str | None,
    log: str | None,
    thin: float | None,
    min_reports: int,
    min_speed: float,
    preset: str,
    output: Output,
    **headings: str | None,
) -> None:
    """Track the vessels of a recording of AIS, and diagnose their filters.

    RECORDING is a CSV file with a heading, or a file of NMEA sentences (extra ais). Reports which
    vessels have inconsistent covariances and when this began.
    """
    import numpy as np

    from trackmetrics.cli._verdicts import diagnosis_table, most_severe
    from trackmetrics.diagnostics import diagnose
    from trackmetrics.vessel import Settings, Tracker, predictive_nis, read_ais
    from trackmetrics.vessel import thin as vessel_thin

    if thin is not None and not thin > 0:
        raise ValueError(f"--thin must be positive, got {thin:g}")
    found = read_ais(recording, {k: v for k, v in headings.items() if v}, progress=True)
    _report_reading(output, found)
    reports = _under_way(found.reports, min_reports, min_speed)
    settings = Settings.harbour() if preset == "harbour" else Settings()
    used = vessel_thin(reports, thin) if thin else np.ones(len(reports), bool)
    tracker = Tracker(settings)
    _track(tracker, reports.take(used))
    absolute = tracker.log()
    relative = absolute.shifted(-float(reports.time.min()))
    diagnosis = diagnose(relative)
    held_out = None
    if not used.all():
        held_out = predictive_nis(absolute, reports.take(~used), settings, progress=True)
    output.write(
        diagnosis_table(diagnosis, held_out),
        content={"diagnosis": diagnosis, "held_out": held_out},
        after=most_severe(diagnosis),
    )
    if log:
        relative.write(log)
        output.message(f"wrote {log}")
    if html:
        title = f"Vessels of {Path(recording).name}"
        write_diagnosis_page(output, html, diagnosis, relative, title=title, held_out=held_out)


def _report_reading(output: Output, recording: Any) -> None:
    rejected = ", ".join(f"{n} {reason}" for reason, n in sorted(recording.counts.items()))
    output.message(
        f"{recording.rows} rows, {len(recording.reports)} reports of "
        f"{len(recording.reports.vessels)} vessels; rejected: {rejected or 'none'}; "
        f"{recording.without_course} without a course"
    )
    for vessel in recording.duplicate_mmsi:
        output.warn(f"more than one vessel reports as {vessel}")


def _under_way(reports: Any, min_reports: int, min_speed: float) -> Any:
    """The reports of the vessels that have enough of them and are under way."""
    import numpy as np

    chosen = []
    for rows in reports.rows_by_vessel().values():
        # A report without a usable speed is most often one of a vessel at rest.
        speeds = np.nan_to_num(reports.z[rows, 2])
        if len(speeds) >= min_reports and np.median(speeds) > min_speed:
            chosen.append(rows)
    if not chosen:
        raise ValueError(
            f"no vessel has {min_reports} reports and a median speed above {min_speed:g} kt"
        )
    return reports.take(np.sort(np.concatenate(chosen)))


def _track(tracker: Any, reports: Any) -> None:
    """Tracks the reports, which are ordered by time, in batches that a bar counts."""
    import numpy as np

    from trackmetrics._progress import with_progress

    batches = np.array_split(np.arange(len(reports)), max(1, len(reports) // BATCH))
    for batch in with_progress(batches, "tracking", len(batches), "batches"):
        tracker.add(reports.take(batch))
