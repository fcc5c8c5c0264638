"""The table of a diagnosis: one row per track, the same for every command that diagnoses."""

from collections.abc import Mapping
from typing import Any

from trackmetrics._format import number
from trackmetrics.cli._table import Column, Table
from trackmetrics.diagnostics import Diagnosis, TrackDiagnosis
from trackmetrics.vessel import HeldOutResult

_COLOURS = {
    "consistent": "green",
    "insufficient": "dim",
    "pessimistic": "blue",
    "partly_pessimistic": "blue",
}
"""Colours of verdicts on a terminal; red for the others."""


def _colour(verdict: str) -> str:
    return _COLOURS.get(verdict, "red")


def since(track: TrackDiagnosis) -> str:
    """When the inconsistency began or, if it was at the start only, until when it lasted."""
    onset, settling = track.onset_time, track.settling_time
    if onset is not None:
        return track.timeline.at(onset)
    return "-" if settling is None else f"until {track.timeline.at(settling)}"


def scale_text(scale: float, interval: tuple[float, float]) -> str:
    """A scale with its interval."""
    if scale != scale:
        return "-"
    return f"{number(scale)} [{number(interval[0])}, {number(interval[1])}]"


COLUMNS = (
    Column("track", lambda t: t.track),
    Column("verdict", lambda t: t.verdict, style=lambda t: _colour(t.verdict)),
    Column("onset_time", lambda t: t.onset_time, "since", since, rank=1),
    Column("settling_time", lambda t: t.settling_time, rank=None),
    Column("weakest_state", lambda t: t.weakest_state, rank=2),
    Column("updates", lambda t: t.updates, rank=3, right=True),
    Column(
        "nis_scale_settled",
        lambda t: t.nis.scale,
        "NIS scale, settled",
        lambda t: scale_text(t.nis.scale, t.nis.interval),
        rank=4,
    ),
    Column("nis_scale_settled_low", lambda t: t.nis.interval[0], rank=None),
    Column("nis_scale_settled_high", lambda t: t.nis.interval[1], rank=None),
    Column("nis_verdict", lambda t: t.nis.verdict, "NIS", rank=5),
    Column("nees_verdict", lambda t: t.nees and t.nees.verdict, "NEES", rank=6),
)
"""Over :class:`TrackDiagnosis`. The settled part is the longest segment that is not too high."""


def diagnosis_table(
    diagnosis: Diagnosis, held_out: Mapping[str, HeldOutResult] | None = None
) -> Table:
    """One row per track, the most severe first."""
    columns = COLUMNS if held_out is None else (*COLUMNS, *_held_out_columns(held_out))
    return Table(columns, diagnosis.by_severity())


def _held_out_columns(held_out: Mapping[str, HeldOutResult]) -> tuple[Column, ...]:
    """Columns of the held-out reports."""

    def of(name: str) -> Any:
        return lambda t: getattr(held_out[t.track], name) if t.track in held_out else None

    def scale(t: TrackDiagnosis) -> str:
        found = held_out.get(t.track)
        return "-" if found is None else scale_text(found.scale, found.interval)

    def interval(end: int) -> Any:
        return lambda t: held_out[t.track].interval[end] if t.track in held_out else None

    return (
        Column("held_out_verdict", of("verdict"), "held out", rank=1),
        Column("held_out_scale", of("scale"), "held-out scale", scale, rank=2),
        Column("held_out_scale_low", interval(0), rank=None),
        Column("held_out_scale_high", interval(1), rank=None),
        Column("held_out_reports", of("reports"), rank=6, right=True),
        Column("held_out_gaps", of("num_gaps"), rank=7, right=True),
    )


def most_severe(diagnosis: Diagnosis) -> str:
    """A paragraph about the most severe track."""
    for track in diagnosis.by_severity():
        if track.verdict not in ("consistent", "insufficient"):
            return f"Most severe track: {track.text}"
    return "No inconsistency was detected in any track."
