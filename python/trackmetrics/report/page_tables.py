"""What the page says of a track beside its figures: lanes, moments and tables."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.draw_plotly import numbers
from trackmetrics.report.theme import segment_role
from trackmetrics.report.track_view import Subject


@dataclass(frozen=True)
class Stretch:
    """A segment in the lane of a track: percent of the time axis, and what it says."""

    left: float
    width: float
    top: int
    label: str
    words: str


@dataclass(frozen=True)
class Table:
    """A table of words."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def lanes(subject: Subject) -> list[Stretch]:
    """The segments of NIS and, below, of NEES, for the small picture in the overview."""
    stretches = []
    for row, verdict in enumerate(subject.quantities()):
        for segment in verdict.segments:
            left, right = (
                100 * subject.clock.at(time) / subject.span[1]
                for time in (segment.start_time, segment.stop_time)
            )
            scale = f"{verdict.quantity.upper()} scale {segment.scale:.3g}, {segment.label}"
            wide = max(right - left, 1.2)
            stretches.append(Stretch(left, wide, 11 * row, segment_role(segment.label), scale))
    return stretches


def moments(subject: Subject) -> tuple[float, list[str]]:
    """Since when: the first onset or settling in minutes, and the words for each."""
    found = [m for verdict in subject.quantities() for m in _moments(subject, verdict)]
    if not found:
        return float("inf"), ["–"]
    return min(minute for minute, _ in found), [words for _, words in found]


def _moments(subject: Subject, verdict: QuantityVerdict) -> list[tuple[float, str]]:
    name = verdict.quantity.upper()
    times = (("from", verdict.onset_time), ("settled", verdict.settling_time))
    at = [(word, subject.clock.at(time)) for word, time in times if time is not None]
    return [(minute, f"{name} {word} {minute:.4g} min") for word, minute in at]


def track_tables(subject: Subject) -> list[Table]:
    """The tables of a track that have rows."""
    tables = (_segments(subject), _states(subject), _biases(subject), _outliers(subject))
    return [table for table in tables if table.rows]


def _segments(subject: Subject) -> Table:
    """Each segment with its scale."""
    rows = tuple(
        (
            verdict.quantity.upper(),
            f"{subject.clock.at(s.start_time):.4g} to {subject.clock.at(s.stop_time):.4g}",
            str(s.stop - s.start),
            f"{s.scale:.3g}",
            f"{s.interval[0]:.3g} to {s.interval[1]:.3g}",
            f"{s.p_value:.2g}",
            {"optimistic": "too large", "pessimistic": "too small"}.get(s.label, "as promised"),
        )
        for verdict in subject.quantities()
        for s in verdict.segments
    )
    head = ("", "minutes", "updates", "scale", "95 % interval", "p", "errors are")
    return Table("Segments: squared errors over what the covariance promises", head, rows)


def _states(subject: Subject) -> Table:
    """Each state with its support, its claim and its part in the fault."""
    minute = subject.clock.minute
    rows = tuple(
        (
            f"{s.state} ({s.unit})" if s.unit else s.state,
            ", ".join(s.observed_by) or "never directly",
            "–" if s.num_direct_updates is None else str(s.num_direct_updates),
            _number(s.longest_gap / minute),
            _number(s.reference_std),
            _number(s.peak_growth),
            _number(s.information_gain),
            _number(s.nees_share),
            _number(s.marginal_nees),
        )
        for s in subject.track.states
    )
    head = (
        "state",
        "observed by",
        "updates",
        "longest gap (min)",
        "reference σ",
        "peak σ / reference",
        "information gain",
        "share of NEES",
        "error² / σ²",
    )
    return _without_empty(Table("States", head, rows))


def _biases(subject: Subject) -> Table:
    rows = tuple(
        (
            b.kind,
            b.measurement_type or "–",
            b.component,
            f"{b.value:.3g} {b.unit}".rstrip(),
            f"{b.z:.2g}",
            f"{b.p_value:.2g}",
        )
        for b in subject.track.biases
    )
    return Table("Biases", ("of", "measurement", "component", "offset", "z", "p"), rows)


def _outliers(subject: Subject) -> Table:
    rows = tuple(
        (f"{subject.clock.at(o.time):.4g}", f"{o.nis:.4g}", f"{o.dof:g}", f"{o.p_value:.2g}")
        for o in subject.track.outliers
    )
    return Table("Isolated outliers", ("minute", "NIS", "dof", "p"), rows)


def _without_empty(table: Table) -> Table:
    """The table without the columns that hold nothing."""
    kept = [i for i in range(len(table.head)) if any(row[i] != "–" for row in table.rows)]
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return Table(table.caption, tuple(table.head[i] for i in kept), rows)


def _number(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "–"


def update_table(subject: Subject) -> dict[str, list[Any]]:
    """Every update, for the table that the browser builds when it is opened."""
    if subject.rows is None:
        return {}
    columns: dict[str, list[Any]] = {"minute": numbers(subject.minutes)}
    for name in ("measurement_type", "status"):
        words = getattr(subject.rows, name)
        if words is not None:
            columns[name.replace("_", " ")] = [word or "–" for word in words]
    for name, title in (("nis", "NIS"), ("nis_dof", "dof"), ("nees", "NEES")):
        values = subject.column(name)
        if values is not None:
            columns[title] = numbers(values, log=True)
    return columns
