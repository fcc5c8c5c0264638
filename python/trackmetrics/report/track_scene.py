"""The sheet of one track: consistency over time, what supported it, and every state.

Above, over the whole width: NIS per degree of freedom, NEES per state and the support strip.
Below, one row a state: its value with the claimed band, the claim as a ratio to its reference, and
the error in units of the claim.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.axes import Limits, linear_limits, log_limits, on_log_axis
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Bars,
    Boxes,
    Event,
    Floats,
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
from trackmetrics.report.state_panels import state_block
from trackmetrics.report.theme import glyph, segment_role, words
from trackmetrics.report.track_view import Subject

HONEST = 0.95
"""Share of an honest filter's values that the shaded intervals hold."""
QUANTITY_HEIGHT, SUPPORT_ROW = 190.0, 36.0
TITLE_ROOM, PANEL_GAP, BLOCK_GAP = 64.0, 42.0, 112.0
WHOLE, PARTIAL = 8.0, 4.5
"""Size of the symbols of updates with and without all components of their measurement."""

SupportRow = tuple[str, str, list[tuple[str, bool, float, Floats]]]
"""A measurement type, what it observes, and symbol, whether tentative, size and when."""


def track_scene(subject: Subject, titled: bool = True) -> Scene:
    """Everything about one track in one figure."""
    frame, top = Frame(), TITLE_ROOM + 28.0 if titled else 28.0
    above = subject.quantities()
    support = _support_rows(subject)
    heights = [QUANTITY_HEIGHT] * len(above) + [SUPPORT_ROW * len(support)] * bool(support)
    places = frame.rows(top, heights, PANEL_GAP)
    panels = [
        _quantity_panel(subject, verdict, place)
        for verdict, place in zip(above, places, strict=False)
    ]
    if support:
        panels.append(_support_panel(subject, support, places[-1]))
    panels[-1] = _with_clock(subject, panels[-1])
    below = places[-1].top + places[-1].height + BLOCK_GAP
    states, headings, end = state_block(subject, frame, below)
    title, subtitle = _titles(subject) if titled else ("", "")
    bottom = end if states else places[-1].top + places[-1].height
    return Scene(frame.width, bottom + frame.bottom, (*panels, *states), title, subtitle, headings)


def _titles(subject: Subject) -> tuple[str, str]:
    track = subject.track
    weakest = f"; weakest state {track.weakest_state}" if track.weakest_state else ""
    parts = [f"NIS {words(track.nis.verdict)}"]
    if track.nees is not None:
        parts.append(f"NEES {words(track.nees.verdict)}")
    title = f"{track.track}  {glyph(track.verdict)} {words(track.verdict)}"
    return title, f"{', '.join(parts)}{weakest}; {track.updates} updates"


def _with_clock(subject: Subject, panel: Panel) -> Panel:
    return replace(panel, x_label=subject.clock.label)


def _quantity_panel(subject: Subject, verdict: QuantityVerdict, place: Rectangle) -> Panel:
    """NIS or NEES per degree of freedom with what an honest filter's would be."""
    values, dof = subject.per_dof(verdict.quantity)
    low, high = _distributions.chi2_interval(dof, HONEST)
    edges = [edge for s in verdict.segments for edge in s.interval if np.isfinite(edge)]
    events = _events(subject, verdict)
    names = max((event.row + 1 for event in events), default=0)
    limits = log_limits([values, low / dof, high / dof, floats(edges)], names=names)
    marks = [
        *_honest(subject, dof, place.width),
        Level(1.0, "muted/0.8"),
        *_segments(subject, verdict),
        *_points(subject, values, limits),
        *_outliers(subject, verdict.quantity),
        *events,
    ]
    name, divisor = verdict.quantity.upper(), "dof"
    if verdict.quantity == "nees" and len(set(dof[np.isfinite(dof)])) == 1:
        divisor = f"{np.nanmax(dof):g}"
    return Panel(
        place,
        tuple(marks),
        title=f"{name}: {words(verdict.verdict)} (shaded: 95 % of an honest filter)",
        y_label=f"{name} / {divisor}",
        log=True,
        x_limits=subject.x_limits,
        y_limits=limits,
    )

    return linear_limits([floats(subject.span)])


def _honest(subject: Subject, dof: Floats, pixels: float) -> list[Mark]:
    """The chi-square interval of each point: one band where all have the same dof, else bars."""
    known = np.isfinite(dof)
    low, high = _distributions.chi2_interval(dof[known], HONEST)
    low, high = low / dof[known], high / dof[known]
    if not known.any():
        return []
    if len(set(dof[known])) == 1:
        return [Level(float(low[0]), "band/0.22", top=float(high[0]))]
    width = float(np.clip(0.5 * pixels / known.sum(), 1.5, 7.0))
    return [Bars(subject.minutes[known], low, high, "band/0.32", width, "95 % interval")]


def _segments(subject: Subject, verdict: QuantityVerdict) -> list[Mark]:
    """The mean of each segment with its confidence interval, in the colour of its verdict."""
    marks: list[Mark] = []
    pad = 0.003 * (subject.span[1] - subject.span[0])
    for segment in verdict.segments:
        left = subject.clock.at(segment.start_time) - pad
        right = subject.clock.at(segment.stop_time) + pad
        low, high = segment.interval
        role = segment_role(segment.label)
        name = f"scale {segment.scale:.3g} [{low:.3g}, {high:.3g}], {segment.label}"
        sides, mean = floats([left, right]), floats([segment.scale] * 2)
        box = Boxes(floats([left]), floats([right]), floats([low]), floats([high]), f"{role}/0.2")
        marks += [box, Line(sides, mean, role, 2.4, name=name)]
        factor = f"{float(f'{segment.scale:.2g}'):g}×"
        marks.append(Text(right, high, factor, role, "right", above=True, bold=True))
    return marks


def _points(subject: Subject, values: Floats, limits: Limits) -> list[Mark]:
    marks: list[Mark] = []
    if not values.size:
        return marks
    shown = on_log_axis(values, limits)
    for kind, symbol, hollow, rows in subject.kinds():
        rows = rows & np.isfinite(values)
        if rows.any():
            name = f"{kind}, tentative" if hollow else kind
            x, y = subject.minutes[rows], shown[rows]
            marks.append(Points(x, y, subject.style.colour, symbol, hollow, 6.5, name))
    return marks


def _outliers(subject: Subject, quantity: str) -> list[Mark]:
    if quantity != "nis" or not subject.track.outliers:
        return []
    x = subject.clock([o.time for o in subject.track.outliers])
    y = floats([o.nis / o.dof for o in subject.track.outliers])
    return [Points(x, y, "high", "circle", True, 14.0, "outlier")]


def _events(subject: Subject, verdict: QuantityVerdict) -> list[Event]:
    """Onset, settling and alarm; names of those close together stand apart."""
    named = (
        ("onset", verdict.onset_time, "high"),
        ("settled", verdict.settling_time, "consistent"),
        ("alarm", verdict.alarm_time, "warning"),
    )
    at = sorted((subject.clock.at(t), name, role) for name, t, role in named if t is not None)
    span = subject.span[1] - subject.span[0]
    marks: list[Event] = []
    for i, (minute, name, role) in enumerate(at):
        crowded = i + 1 < len(at) and at[i + 1][0] - minute < 0.16 * span
        left = minute > 0.16 * span and (crowded or minute > 0.8 * span)
        row = i if i and minute - at[i - 1][0] < 0.16 * span else 0
        marks.append(Event(minute, f"{name} {minute:.4g} min", role, row=row, left=left))
    return marks


def _support_rows(subject: Subject) -> list[SupportRow]:
    """Each measurement type with what it observes and when it came."""
    found: dict[str, list[tuple[str, bool, float, Floats]]] = {}
    lacking = subject.lacking()
    for kind, symbol, hollow, rows in subject.kinds():
        parts = found.setdefault(kind, [])
        for size, chosen in ((WHOLE, rows & ~lacking), (PARTIAL, rows & lacking)):
            if chosen.any():
                parts.append((symbol, hollow, size, subject.minutes[chosen]))
    observed = subject.track.observed
    return [(kind, ", ".join(observed.get(kind, ())) or "", parts) for kind, parts in found.items()]


def _support_panel(
    subject: Subject,
    rows: Sequence[SupportRow],
    place: Rectangle,
) -> Panel:
    """One row a measurement type: when it came, and which states it observes."""
    marks: list[Mark] = []
    small = "; small: some components missing" if subject.lacking().any() else ""
    limits = subject.x_limits
    start = limits[0] + 0.004 * (limits[1] - limits[0])
    for i, (kind, states, parts) in enumerate(rows):
        y = float(-i)
        words = f"{kind} observes {states}" if states else kind
        marks.append(Text(start, y + 0.26, words, "muted"))
        marks.append(Level(y - 0.2, "grid"))
        for symbol, hollow, size, x in parts:
            level = np.full(len(x), y - 0.2)
            name = f"{kind}, some components missing" if size == PARTIAL else kind
            marks.append(Points(x, level, subject.style.colour, symbol, hollow, size, name))
    return Panel(
        place,
        tuple(marks),
        title=f"Support: which measurement came when (hollow: tentative{small})",
        y_label="support",
        x_limits=limits,
        y_limits=(-len(rows) + 0.5, 0.5),
        ticks=(),
    )
