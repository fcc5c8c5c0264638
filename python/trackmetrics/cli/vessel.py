"""A recording of AIS through the vessel estimator: whom does the filter lie about, since when?"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from trackmetrics._progress import watched
from trackmetrics.cli._output import print_verdicts, write_html
from trackmetrics.diagnostics import Diagnosis, EstimatorLog, diagnose
from trackmetrics.vessel import (
    HeldOut,
    Recording,
    Reports,
    Settings,
    Tracker,
    decimated,
    predictive_nis,
    read_ais,
)

PART = 50_000
"""Reports that are tracked in one go."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the user may choose."""
    parser.add_argument("recording", help="a CSV file with a heading, or NMEA sentences")
    parser.add_argument("--html", help="write the page of the diagnosis there")
    parser.add_argument(
        "--decimate",
        type=float,
        metavar="SECONDS",
        help="use one report of each vessel in so many seconds; the others test the predictions",
    )
    parser.add_argument("--log", help="write the estimator's log there (.jsonl, .csv, .parquet)")
    parser.add_argument(
        "--least", type=int, default=50, help="reports that a vessel must have (50)"
    )
    parser.add_argument(
        "--moving", type=float, default=3.0, help="knots that its median must exceed (3)"
    )
    parser.add_argument(
        "--settings",
        choices=["harbour", "sea"],
        default="harbour",
        help="what the filter assumes: manoeuvring traffic (default), or steady ships",
    )
    for name in ("time", "vessel", "lat", "lon", "sog", "cog"):
        parser.add_argument(f"--{name}", metavar="COLUMN", help=f"heading of the column of {name}")


def run(arguments: argparse.Namespace) -> int:
    """Read, track, diagnose, test the predictions; print and write."""
    if arguments.decimate is not None and not arguments.decimate > 0:
        raise ValueError(f"--decimate must be positive, got {arguments.decimate:g}")
    names = ("time", "vessel", "lat", "lon", "sog", "cog")
    columns = {name: getattr(arguments, name) for name in names if getattr(arguments, name)}
    recording = read_ais(arguments.recording, columns, progress=True)
    _print_reading(recording)
    reports = _under_way(recording.reports, arguments.least, arguments.moving)
    settings = Settings.harbour() if arguments.settings == "harbour" else Settings()
    whole = np.ones(len(reports), bool)
    used = decimated(reports, arguments.decimate) if arguments.decimate else whole
    tracker = Tracker(settings)
    _track(tracker, reports.take(used))
    absolute = tracker.log()
    log = _since_first_report(absolute, reports)
    diagnosis = diagnose(log)
    print_verdicts(diagnosis)
    held_out = None
    if not used.all():
        held_out = predictive_nis(absolute, reports.take(~used), settings, progress=True)
        _print_predictions(held_out, diagnosis)
    if arguments.log:
        log.write(arguments.log)
    if arguments.html:
        title = f"Vessels of {Path(arguments.recording).name}"
        write_html(arguments.html, diagnosis, log, title, held_out)
    return 0


def _print_reading(recording: Recording) -> None:
    aside = ", ".join(f"{n} {reason}" for reason, n in sorted(recording.counts.items()))
    print(
        f"{recording.rows} rows, {len(recording.reports)} reports of "
        f"{len(recording.reports.vessels)} vessels; set aside: {aside or 'none'}; "
        f"{recording.without_course} without a course\n"
    )
    for vessel in recording.shared:
        print(f"more than one vessel reports as {vessel}")


def _under_way(reports: Reports, least: int, moving: float) -> Reports:
    """The reports of the vessels that have enough of them and are under way."""
    chosen = []
    for rows in reports.rows_by_vessel().values():
        # A report without a usable speed is one of a vessel that lies still, more often than not.
        speeds = np.nan_to_num(reports.z[rows, 2])
        if len(speeds) >= least and np.median(speeds) > moving:
            chosen.append(rows)
    if not chosen:
        raise ValueError(f"no vessel has {least} reports and a median speed above {moving:g} kt")
    return reports.take(np.sort(np.concatenate(chosen)))


def _track(tracker: Tracker, reports: Reports) -> None:
    """The reports, which are in the order of time, in parts that a bar can count."""
    parts = np.array_split(np.arange(len(reports)), max(1, len(reports) // PART))
    for part in watched(parts, "tracking", len(parts), " parts"):
        tracker.add(reports.take(part))


def _since_first_report(log: EstimatorLog, reports: Reports) -> EstimatorLog:
    """The same log with times since the first report of all."""
    shifted = log.columns.with_(time=log.columns.time - reports.time.min())
    return EstimatorLog(
        shifted,
        log.tracks,
        log.starts,
        log.states,
        log.measurement_angles,
        log.computed,
        log.repeated,
        log.time_unit,
    )


def _print_predictions(found: Mapping[str, HeldOut], diagnosis: Diagnosis) -> None:
    """How well the reports that were left out were predicted."""
    print("\nPredictions of the reports left out (NIS scale: 1 is honest)")
    width = max([5, *map(len, found)])
    print(f"{'track':{width}}  {'verdict':12}  {'scale':>21}  reports  gaps  {'fused':12}")
    for track, held in sorted(found.items(), key=lambda item: -item[1].scale):
        low, high = held.interval
        scale = f"{held.scale:.3g} [{low:.3g}, {high:.3g}]"
        print(
            f"{track:{width}}  {held.verdict:12}  {scale:>21}  {held.reports:7}  {held.gaps:4}"
            f"  {diagnosis[track].verdict}"
        )
