"""All tracks at once: one lane each, the most severe on top, and their NIS and NEES together."""

from collections.abc import Sequence
from dataclasses import replace
from textwrap import wrap

import numpy as np

from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.axes import Limits, log_limits, on_log_axis
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Boxes,
    Level,
    Line,
    Mark,
    Panel,
    Points,
    Rectangle,
    Scene,
    Text,
    floats,
)
from trackmetrics.report.theme import glyph, segment_role, verdict_role, words
from trackmetrics.report.track_view import Subject

LANE = 24.0
"""Height of a track in the overview, in pixels."""
_LANES = (
    "Upper half NIS, lower half NEES; red: covariance too small, blue: too large, green: honest; "
    "▲ onset, ◆ alarm"
)
FEW = 60
"""Updates of a track up to which its points are drawn boldly in the comparison."""


def lanes_scene(subjects: Sequence[Subject], title: str) -> Scene:
    """Each track's segments of NIS and NEES over time, the most severe track on top."""
    frame = Frame(left=190.0, right=210.0)
    place = frame.rows(110.0, [LANE * max(len(subjects), 1)], 0.0)[0]
    marks = [mark for i, subject in enumerate(subjects) for mark in _lane(subject, -float(i))]
    panel = Panel(
        place,
        tuple(marks),
        title=_LANES,
        x_label=subjects[0].clock.label if subjects else "minutes since start",
        y_label="",
        x_limits=subjects[0].x_limits if subjects else (0.0, 1.0),
        y_limits=(-len(subjects) + 0.4, 0.6),
        ticks=tuple((-float(i), _short(s.track.track)) for i, s in enumerate(subjects)),
    )
    return Scene(
        frame.width, place.top + place.height + frame.bottom, (panel,), title, summary(subjects)
    )


def summary(subjects: Sequence[Subject]) -> str:
    """How many tracks, and how many of each verdict."""
    counts: dict[str, int] = {}
    for subject in subjects:
        counts[subject.track.verdict] = counts.get(subject.track.verdict, 0) + 1
    parts = ", ".join(f"{count} {words(verdict)}" for verdict, count in counts.items())
    tracks = f"{len(subjects)} track{'s' if len(subjects) != 1 else ''}"
    return "\n".join(wrap(f"{tracks}: {parts}" if parts else tracks, 140))


def _short(name: str, length: int = 26) -> str:
    return name if len(name) <= length else name[: length - 1] + "…"


def _lane(subject: Subject, y: float) -> list[Mark]:
    marks: list[Mark] = [Level(y - 0.5, "grid/0.6")]
    for verdict, low, high in ((subject.track.nis, 0.04, 0.36), (subject.track.nees, -0.36, -0.04)):
        if verdict is not None:
            marks += _stretches(subject, verdict, y + low, y + high)
            marks += _moments(subject, verdict, y + (low + high) / 2)
    end = subject.span[1] + 0.045 * (subject.span[1] - subject.span[0])
    role = verdict_role(subject.track.verdict)
    marks.append(
        Text(end, y, f"{glyph(subject.track.verdict)} {words(subject.track.verdict)}", role)
    )
    return marks


def _stretches(subject: Subject, verdict: QuantityVerdict, low: float, high: float) -> list[Mark]:
    pad = 0.003 * (subject.span[1] - subject.span[0])
    marks: list[Mark] = []
    for segment in verdict.segments:
        left = floats([subject.clock.at(segment.start_time) - pad])
        right = floats([subject.clock.at(segment.stop_time) + pad])
        name = f"{verdict.quantity.upper()} scale {segment.scale:.3g}"
        box = Boxes(
            left, right, floats([low]), floats([high]), f"{segment_role(segment.label)}/0.75", name
        )
        marks.append(box)
    return marks


def _moments(subject: Subject, verdict: QuantityVerdict, y: float) -> list[Mark]:
    """Onset and alarm as arrows."""
    marks: list[Mark] = []
    for name, time, symbol in (
        ("onset", verdict.onset_time, "triangle-up"),
        ("alarm", verdict.alarm_time, "diamond"),
    ):
        if time is not None:
            x, label = subject.clock([time]), f"{verdict.quantity.upper()} {name}"
            marks.append(Points(x, floats([y]), "ink", symbol, False, 8.0, label))
    return marks


def comparison_scene(subjects: Sequence[Subject], drawn: Sequence[Subject] | None = None) -> Scene:
    """NIS and NEES of the drawn tracks over each other, on axes that fit all of them."""
    frame = Frame()
    with_nees = any(subject.track.nees is not None for subject in subjects)
    quantities = ("nis", "nees") if with_nees else ("nis",)
    places = frame.rows(52.0, [230.0] * len(quantities), 40.0)
    panels = [
        _comparison_panel(subjects, subjects if drawn is None else drawn, quantity, place)
        for quantity, place in zip(quantities, places, strict=True)
    ]
    if subjects:
        panels[-1] = replace(panels[-1], x_label=subjects[0].clock.label)
    return Scene(frame.width, places[-1].top + places[-1].height + frame.bottom, tuple(panels))


def _comparison_panel(
    subjects: Sequence[Subject], drawn: Sequence[Subject], quantity: str, place: Rectangle
) -> Panel:
    scales = [s.scale for subject in subjects for s in subject.segments(quantity)]
    limits = log_limits([*(subject.per_dof(quantity)[0] for subject in subjects), floats(scales)])
    marks = [m for subject in drawn for m in _updates(subject, quantity, limits)]
    marks += [m for subject in drawn for m in _means(subject, quantity)]
    return Panel(
        place,
        (Level(1.0, "muted/0.8"), *marks),
        title=f"{quantity.upper()}: updates and segment means",
        y_label=f"{quantity.upper()} / {'dof' if quantity == 'nis' else 'states'}",
        log=True,
        x_limits=subjects[0].x_limits if subjects else None,
        y_limits=limits,
        legend=quantity == "nis",
    )


def _updates(subject: Subject, quantity: str, limits: Limits) -> list[Mark]:
    """The points of one track, paler where they are many."""
    values = subject.per_dof(quantity)[0]
    opacity, size = ("0.6", 5.0) if len(values) <= FEW else ("0.3", 3.5)
    marks: list[Mark] = []
    for _, symbol, hollow, rows in subject.kinds():
        chosen = rows & np.isfinite(values)
        if chosen.any():
            x, y = subject.minutes[chosen], on_log_axis(values[chosen], limits)
            role = f"{subject.style.colour}/{opacity}"
            marks.append(Points(x, y, role, symbol, hollow, size, subject.track.track))
    return marks


def _means(subject: Subject, quantity: str) -> list[Mark]:
    """The segments of one track as a stepped line."""
    segments = subject.segments(quantity)
    if not segments:
        return []
    starts = [segment.start_time for segment in segments]
    times = np.repeat([*starts, segments[-1].stop_time], 2)[1:-1]
    scales = floats(np.repeat([segment.scale for segment in segments], 2))
    style = subject.style
    x = subject.clock(times)
    return [Line(x, scales, style.colour, 2.6, style.dash, subject.track.track)]
