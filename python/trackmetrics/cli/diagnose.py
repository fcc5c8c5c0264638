"""``trackmetrics diagnose LOG``: is the filter honest, since when, and which state?"""

import argparse
import json
from pathlib import Path

from trackmetrics.diagnostics import Diagnosis, TrackDiagnosis, diagnose
from trackmetrics.logs import read_log

_EXPLANATION = """
Reads the log of an estimator (.jsonl, .csv or .parquet; one row per update) and says for every
track whether its covariance is honest, from when to when, and which state fails. The NIS with its
degrees of freedom is enough; with innovations, covariances and truth there is more to say.

With --check the exit status is 1 where a track is not consistent, so that the test of a filter can
fail on it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Says what the command takes."""
    parser.description = _EXPLANATION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("log", metavar="LOG", help="log of an estimator")
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="NAME=COLUMN[,COLUMN...]",
        help="the file's name of a column, or the columns of a vector; may be repeated",
    )
    parser.add_argument("--states", metavar="NAME,NAME,...", help="names of the states")
    parser.add_argument(
        "--angle",
        action="append",
        default=[],
        metavar="STATE=PERIOD",
        help="a state that is an angle, with its period; may be repeated",
    )
    parser.add_argument("--html", metavar="FILE", help="write a page to look at")
    parser.add_argument("--format", choices=["table", "json"], default="table")
    parser.add_argument("--check", action="store_true", help="exit with 1 unless all is consistent")


def run(arguments: argparse.Namespace) -> int:
    """Prints the diagnosis."""
    log = read_log(
        arguments.log,
        columns={name: _names(value) for name, value in map(_pair, arguments.column)} or None,
        states=arguments.states.split(",") if arguments.states else None,
        angles={name: float(period) for name, period in map(_pair, arguments.angle)} or None,
        progress=True,
    )
    found = diagnose(log)
    if arguments.html:
        from trackmetrics.report import page

        Path(arguments.html).write_text(page(found, log), encoding="utf-8")
    if arguments.format == "json":
        print(json.dumps(_without_nan(found.to_dict()), indent=2))
    else:
        print(table(found))
    return 1 if arguments.check and not found.consistent else 0


def table(found: Diagnosis) -> str:
    """A line a track, the most severe first, then a paragraph each."""
    head = ["track", "verdict", "NIS", "NEES", "updates", "since", "weakest state"]
    rows = [head, *(_row(track) for track in found.by_severity())]
    widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
    return "\n".join([*(line.rstrip() for line in lines), "", found.text])


def _row(track: TrackDiagnosis) -> list[str]:
    quantities = [q for q in (track.nis, track.nees) if q is not None]
    onsets = [q.onset_time for q in quantities if q.onset_time is not None]
    return [
        track.track,
        track.verdict,
        track.nis.verdict,
        "-" if track.nees is None else track.nees.verdict,
        str(track.updates),
        track.timeline.at(min(onsets)) if onsets else "-",
        track.weakest_state or "-",
    ]


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"expected NAME=VALUE, got {text!r}")
    return name, value


def _names(value: str) -> str | list[str]:
    return value.split(",") if "," in value else value


def _without_nan(value: object) -> object:
    """NaN as null: JSON has no NaN."""
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and value != value else value
