"""``trackmetrics diagnose LOG``: is each track's filter honest, since when, and which state?"""

import argparse
import json
from collections.abc import Sequence

from trackmetrics.diagnostics import Diagnosis, EstimatorLog, TrackDiagnosis, diagnose, read_log

_EXPLANATION = """
Reads the log of an estimator (.jsonl, .csv or .parquet: one row per update) and prints the verdict
of each track, the most severe first, with one paragraph each.
"""
_HEAD = ("track", "verdict", "NIS", "NEES", "weakest state", "updates")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Says what the command takes."""
    parser.description = _EXPLANATION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("log", metavar="LOG", help="the log: .jsonl, .csv or .parquet")
    parser.add_argument("--html", metavar="FILE", help="also write a page with all figures")
    parser.add_argument("--title", default=None, help="heading of that page (default: the file)")
    parser.add_argument("--format", choices=["table", "json"], default="table")
    parser.add_argument(
        "--check", action="store_true", help="exit status 1 where a track is not consistent"
    )
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="NAME=SOURCE",
        help="a column that the file names otherwise: nis_dof=df, std=s_x,s_y; may be repeated",
    )
    parser.add_argument("--states", metavar="NAMES", help="names of the states: lat,lon,sog")
    parser.add_argument("--state-dim", type=int, help="how many states, where no column tells")


def run(arguments: argparse.Namespace) -> int:
    """Prints the diagnosis."""
    log = read_log(
        arguments.log,
        columns=_renaming(arguments.column),
        states=arguments.states.split(",") if arguments.states else None,
        state_dim=arguments.state_dim,
    )
    diagnosis = diagnose(log)
    if arguments.html:
        _write_html(arguments, diagnosis, log)
    if arguments.format == "json":
        print(json.dumps(_finite(diagnosis.to_dict()), indent=2, allow_nan=False))
    else:
        print(f"{_table(diagnosis.by_severity())}\n\n{diagnosis.text}")
    return 1 if arguments.check and not diagnosis.consistent else 0


def _write_html(arguments: argparse.Namespace, diagnosis: Diagnosis, log: EstimatorLog) -> None:
    from trackmetrics.report import write_page

    write_page(arguments.html, diagnosis, log, title=arguments.title or str(arguments.log))


def _renaming(columns: Sequence[str]) -> dict[str, str | list[str]]:
    """``nis_dof=df`` and ``std=s_x,s_y`` as :func:`read_log` takes them."""
    renaming: dict[str, str | list[str]] = {}
    for column in columns:
        name, equals, source = column.partition("=")
        if not (name and equals and source):
            raise ValueError(f"--column must be NAME=SOURCE, got {column!r}")
        renaming[name] = source.split(",") if "," in source else source
    return renaming


def _table(tracks: Sequence[TrackDiagnosis]) -> str:
    rows = [_HEAD, *(_row(track) for track in tracks)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEAD))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def _row(track: TrackDiagnosis) -> tuple[str, ...]:
    nees = "-" if track.nees is None else track.nees.verdict
    weakest = track.weakest_state or "-"
    return (track.track, track.verdict, track.nis.verdict, nees, weakest, str(track.updates))


def _finite(value: object) -> object:
    """The same with null for NaN and infinity, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and value - value != 0:
        return None
    return value
