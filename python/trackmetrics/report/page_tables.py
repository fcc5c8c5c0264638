"""Texts of the page for one track: the bars of its timeline, its first event, its tables."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics._format import MISSING, number, p_value
from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.packing import PackedArrays
from trackmetrics.report.theme import segment_role, verdict_label
from trackmetrics.report.track_view import TrackView


@dataclass(frozen=True)
class TimelineBar:
    """A segment in the timeline of a track, in percent of the time axis, with its tooltip."""

    left: float
    width: float
    top: int
    label: str
    tooltip: str


@dataclass(frozen=True)
class Table:
    """A table of texts."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def timeline_bars(view: TrackView) -> list[TimelineBar]:
    """The segments of NIS and, below, of NEES, for the timeline in the overview."""
    bars = []
    for row, verdict in enumerate(view.quantities()):
        for segment in verdict.segments:
            left, right = (
                100 * view.clock.at(time) / view.span[1]
                for time in (segment.start_time, segment.stop_time)
            )
            name = verdict.quantity.upper()
            scale = f"{name} scale {number(segment.scale)}, {segment.label}"
            wide = max(right - left, 1.2)
            bars.append(TimelineBar(left, wide, 11 * row, segment_role(segment.label), scale))
    return bars


def first_event(view: TrackView) -> tuple[float, list[str]]:
    """The first onset or settling in minutes, and a text for each onset and settling."""
    found = [m for verdict in view.quantities() for m in _events(view, verdict)]
    if not found:
        return float("inf"), [MISSING]
    return min(minute for minute, _ in found), [text for _, text in found]


def _events(view: TrackView, verdict: QuantityVerdict) -> list[tuple[float, str]]:
    name = verdict.quantity.upper()
    times = (("from", verdict.onset_time), ("settled", verdict.settling_time))
    at = [(event, view.clock.at(time)) for event, time in times if time is not None]
    return [
        (minute, f"{name} {event} {number(minute, 4)} {view.clock.unit}") for event, minute in at
    ]


def track_tables(view: TrackView) -> list[Table]:
    """The tables of a track that have rows."""
    tables = (_segments(view), _states(view), _biases(view), _outliers(view))
    return [table for table in tables if table.rows]


def _segments(view: TrackView) -> Table:
    """Each segment with its scale."""
    rows = tuple(
        (
            verdict.quantity.upper(),
            f"{number(view.clock.at(s.start_time), 4)} to {number(view.clock.at(s.stop_time), 4)}",
            str(s.stop - s.start),
            number(s.scale),
            f"{number(s.interval[0])} to {number(s.interval[1])}",
            p_value(s.p_value),
            s.label,
        )
        for verdict in view.quantities()
        for s in verdict.segments
    )
    head = ("", f"time ({view.clock.unit})", "updates", "scale", "95 % interval", "p", "verdict")
    return Table("Segments: squared errors over their expectation from the covariance", head, rows)


def _states(view: TrackView) -> Table:
    """Each state with its measurements, its standard deviation and its share of the NEES."""
    minute = view.clock.minute
    rows = tuple(
        (
            f"{s.state} ({s.unit})" if s.unit else s.state,
            ", ".join(s.observed_by) or "never directly",
            MISSING if s.num_direct_updates is None else str(s.num_direct_updates),
            number(s.longest_gap / minute),
            number(s.reference_std),
            number(s.peak_growth),
            number(s.information_gain),
            number(s.nees_share),
            number(s.marginal_nees),
        )
        for s in view.track.states
    )
    head = (
        "state",
        "observed by",
        "updates",
        f"longest gap ({view.clock.unit})",
        "reference σ",
        "peak σ / reference",
        "information gain",
        "share of NEES",
        "error² / σ²",
    )
    return _without_empty(Table("States", head, rows))


def _biases(view: TrackView) -> Table:
    rows = tuple(
        (
            b.kind,
            b.measurement_type or MISSING,
            b.component,
            f"{number(b.value)} {b.unit}".rstrip(),
            number(b.z, 2),
            p_value(b.p_value),
        )
        for b in view.track.biases
    )
    return Table("Biases", ("of", "measurement", "component", "offset", "z", "p"), rows)


def _outliers(view: TrackView) -> Table:
    rows = tuple(
        (
            number(view.clock.at(o.time), 4),
            number(o.nis, 4),
            f"{o.dof:g}",
            p_value(o.p_value),
        )
        for o in view.track.outliers
    )
    return Table("Isolated outliers", (f"time ({view.clock.unit})", "NIS", "dof", "p"), rows)


def _without_empty(table: Table) -> Table:
    """The table without the columns that hold nothing."""
    kept = [i for i in range(len(table.head)) if any(row[i] != MISSING for row in table.rows)]
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return Table(table.caption, tuple(table.head[i] for i in kept), rows)


def update_table(view: TrackView, arrays: PackedArrays) -> dict[str, Any]:
    """The columns of all updates, for the table that the browser builds when it is opened.

    A column is a reference to a packed column, or a list; ``names`` are the texts of its codes,
    ``times`` is another column to multiply it by.
    """
    if view.rows is None:
        return {}
    columns: dict[str, Any] = {view.clock.unit or "time": arrays.times(view.minutes)}
    for name in ("measurement_type", "status"):
        texts = getattr(view.rows, name)
        if texts is not None:
            columns[name.replace("_", " ")] = _codes(texts, arrays)
    for quantity in view.quantities():
        per_dof, dof = view.per_dof(quantity.quantity)
        if np.isfinite(per_dof).any():
            values, divisor = arrays.values(per_dof, True), arrays.values(dof, False)
            columns[quantity.quantity.upper()] = {"product": [values, divisor]}
            columns[f"{quantity.quantity.upper()} dof"] = divisor
    return columns


def _codes(texts: Any, arrays: PackedArrays) -> dict[str, Any]:
    """Texts as codes and the list of their different values."""
    names = list(dict.fromkeys(texts))
    codes = {name: code for code, name in enumerate(names)}
    column = arrays.values(np.array([float(codes[text]) for text in texts]), False)
    return {"names": [name or MISSING for name in names], "codes": column}


def quantity_verdicts(view: TrackView) -> str:
    """The verdicts of NIS and NEES in a line."""
    parts = [(q.quantity.upper(), verdict_label(q.verdict)) for q in view.quantities()]
    if len(parts) == 2 and parts[0][1] == parts[1][1]:
        same = parts[0][1]
        return "NIS and NEES" if same == verdict_label(view.track.verdict) else f"both {same}"
    return "; ".join(f"{quantity} {verdict}" for quantity, verdict in parts)
