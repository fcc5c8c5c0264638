"""Scene of one track: consistency over time, the measurement timeline, and every state.

Above, over the whole width: NIS per degree of freedom, NEES per state and the measurement timeline.
Below, one row per state: its value with the band of plus or minus two standard deviations, the
standard deviation over its reference, and the error over the standard deviation.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _distributions
from trackmetrics._format import number
from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.axes import Limits, log_limits, on_log_axis
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Bounds,
    ErrorBars,
    Event,
    Floats,
    HLine,
    Line,
    Panel,
    Points,
    Primitive,
    Rects,
    Scene,
    Text,
    floats,
)
from trackmetrics.report.state_panels import state_block
from trackmetrics.report.theme import segment_role, verdict_label, verdict_symbol
from trackmetrics.report.track_view import TrackView

COVERAGE = 0.95
"""Probability of the shaded chi-square intervals."""
QUANTITY_HEIGHT, TIMELINE_ROW_HEIGHT = 190.0, 36.0
TITLE_HEIGHT, PANEL_GAP, BLOCK_GAP = 64.0, 42.0, 112.0
COMPLETE_SIZE, INCOMPLETE_SIZE = 8.0, 4.5
"""Size of the symbols of updates with and without all components of their measurement."""

Rows = NDArray[np.bool_]
TimelineRow = tuple[str, str, list[tuple[str, bool, float, Rows]]]
"""A measurement type, what it observes, and for each group of updates: symbol, whether tentative,
size and mask of rows."""


def track_scene(view: TrackView, titled: bool = True) -> Scene:
    """The scene of one track; ``titled`` adds its name and verdicts at the top."""
    frame, top = Frame(), TITLE_HEIGHT + 28.0 if titled else 28.0
    above = view.quantities()
    timeline = _timeline_rows(view)
    heights = [QUANTITY_HEIGHT] * len(above) + [TIMELINE_ROW_HEIGHT * len(timeline)] * bool(
        timeline
    )
    all_bounds = frame.rows(top, heights, PANEL_GAP)
    panels = [
        _quantity_panel(view, verdict, bounds)
        for verdict, bounds in zip(above, all_bounds, strict=False)
    ]
    if timeline:
        panels.append(_timeline_panel(view, timeline, all_bounds[-1]))
    panels[-1] = _with_time_label(view, panels[-1])
    below = all_bounds[-1].top + all_bounds[-1].height + BLOCK_GAP
    states, headings, end = state_block(view, frame, below)
    title, subtitle = _titles(view) if titled else ("", "")
    bottom = end if states else all_bounds[-1].top + all_bounds[-1].height
    return Scene(frame.width, bottom + frame.bottom, (*panels, *states), title, subtitle, headings)


def _titles(view: TrackView) -> tuple[str, str]:
    track = view.track
    weakest = f"; weakest state {track.weakest_state}" if track.weakest_state else ""
    parts = [f"NIS {verdict_label(track.nis.verdict)}"]
    if track.nees is not None:
        parts.append(f"NEES {verdict_label(track.nees.verdict)}")
    title = f"{track.track}  {verdict_symbol(track.verdict)} {verdict_label(track.verdict)}"
    return title, f"{', '.join(parts)}{weakest}; {track.updates} updates"


def _with_time_label(view: TrackView, panel: Panel) -> Panel:
    return replace(panel, x_label=view.clock.label)


def _quantity_panel(view: TrackView, verdict: QuantityVerdict, bounds: Bounds) -> Panel:
    """NIS or NEES per degree of freedom with the 95 % interval of a consistent filter."""
    values, dof = view.per_dof(verdict.quantity)
    low, high = _interval(dof)
    edges = [edge for s in verdict.segments for edge in s.interval if np.isfinite(edge)]
    events = _events(view, verdict)
    names = max((event.row + 1 for event in events), default=0)
    limits = log_limits([values, low, high, floats(edges)], names=names)
    primitives = [
        *_chi_square_band(view, dof, bounds.width),
        HLine(1.0, "muted/0.8"),
        *_segments(view, verdict),
        *_points(view, values, limits),
        *_outliers(view, verdict.quantity),
        *events,
    ]
    name, divisor = verdict.quantity.upper(), "dof"
    if verdict.quantity == "nees" and len(set(dof[np.isfinite(dof)])) == 1:
        divisor = f"{np.nanmax(dof):g}"
    return Panel(
        bounds,
        tuple(primitives),
        title=f"{name}: {verdict_label(verdict.verdict)} (shaded: 95 % interval if consistent)",
        y_label=f"{name} / {divisor}",
        log=True,
        x_limits=view.x_limits,
        y_limits=limits,
    )


def _chi_square_band(view: TrackView, dof: Floats, pixels: float) -> list[Primitive]:
    """The chi-square interval of each update: one band if all have the same dof, else bars."""
    known = np.isfinite(dof)
    if not known.any():
        return []
    low, high = _interval(dof)
    if len(set(dof[known])) == 1:
        return [HLine(float(np.nanmin(low)), "band/0.22", top=float(np.nanmax(high)))]
    width = float(np.clip(0.5 * pixels / known.sum(), 1.5, 7.0))
    return [ErrorBars(view.minutes, low, high, "band/0.32", round(width, 1), "95 % interval")]


def _interval(dof: Floats) -> tuple[Floats, Floats]:
    """The chi-square interval of each update per degree of freedom; few of them differ."""
    different, of_update = np.unique(dof, return_inverse=True)
    low, high = _distributions.chi2_interval(different, COVERAGE)
    return (low / different)[of_update], (high / different)[of_update]


def _segments(view: TrackView, verdict: QuantityVerdict) -> list[Primitive]:
    """The mean of each segment with its confidence interval, in the colour of its label."""
    primitives: list[Primitive] = []
    pad = 0.003 * (view.span[1] - view.span[0])
    for segment in verdict.segments:
        left = view.clock.at(segment.start_time) - pad
        right = view.clock.at(segment.stop_time) + pad
        low, high = segment.interval
        role = segment_role(segment.label)
        name = f"scale {number(segment.scale)} [{number(low)}, {number(high)}], {segment.label}"
        sides, mean = floats([left, right]), floats([segment.scale] * 2)
        box = Rects(floats([left]), floats([right]), floats([low]), floats([high]), f"{role}/0.2")
        primitives += [box, Line(sides, mean, role, 2.4, name=name)]
        factor = f"{float(f'{segment.scale:.2g}'):g}×"
        primitives.append(Text(right, high, factor, role, "right", above=True, bold=True))
    return primitives


def _points(view: TrackView, values: Floats, limits: Limits) -> list[Primitive]:
    primitives: list[Primitive] = []
    shown = on_log_axis(values, limits)
    colour = view.style.colour
    for kind, symbol, hollow, rows in view.groups_of(values):
        name = f"{kind}, tentative" if hollow else kind
        points = Points(view.minutes, shown, colour, symbol, hollow, 6.5, name, rows)
        primitives.append(points)
    return primitives


def _outliers(view: TrackView, quantity: str) -> list[Primitive]:
    if quantity != "nis" or not view.track.outliers:
        return []
    x = view.clock([o.time for o in view.track.outliers])
    y = floats([o.nis / o.dof for o in view.track.outliers])
    return [Points(x, y, "high", "circle", True, 14.0, "outlier")]


def _events(view: TrackView, verdict: QuantityVerdict) -> list[Event]:
    """Onset, settling and alarm; labels of events close together are moved apart."""
    named = (
        ("onset", verdict.onset_time, "high"),
        ("settled", verdict.settling_time, "consistent"),
        ("alarm", verdict.alarm_time, "warning"),
    )
    at = sorted((view.clock.at(t), name, role) for name, t, role in named if t is not None)
    span = view.span[1] - view.span[0]
    primitives: list[Event] = []
    for i, (minute, name, role) in enumerate(at):
        crowded = i + 1 < len(at) and at[i + 1][0] - minute < 0.16 * span
        left = minute > 0.16 * span and (crowded or minute > 0.8 * span)
        row = i if i and minute - at[i - 1][0] < 0.16 * span else 0
        primitives.append(
            Event(minute, f"{name} {number(minute, 4)} {view.clock.unit}", role, row=row, left=left)
        )
    return primitives


def _timeline_rows(view: TrackView) -> list[TimelineRow]:
    """Each measurement type with the states that it observes and the times of its updates."""
    found: dict[str, list[tuple[str, bool, float, Rows]]] = {}
    incomplete = view.incomplete()
    for kind, symbol, hollow, rows in view.by_measurement_type():
        parts = found.setdefault(kind, [])
        for size, chosen in (
            (COMPLETE_SIZE, rows & ~incomplete),
            (INCOMPLETE_SIZE, rows & incomplete),
        ):
            if chosen.any():
                parts.append((symbol, hollow, size, chosen))
    observed = view.track.observed
    return [(kind, ", ".join(observed.get(kind, ())) or "", parts) for kind, parts in found.items()]


def _timeline_panel(
    view: TrackView,
    rows: Sequence[TimelineRow],
    bounds: Bounds,
) -> Panel:
    """One row per measurement type: times of its updates and the states that it observes."""
    primitives: list[Primitive] = []
    small = "; small: some components missing" if view.incomplete().any() else ""
    limits = view.x_limits
    start = limits[0] + 0.004 * (limits[1] - limits[0])
    for i, (kind, states, parts) in enumerate(rows):
        y = float(-i)
        label = f"{kind} observes {states}" if states else kind
        primitives.append(Text(start, y + 0.26, label, "muted"))
        primitives.append(HLine(y - 0.2, "grid"))
        level = np.full(len(view.minutes), y - 0.2)
        for symbol, hollow, size, chosen in parts:
            name = f"{kind}, some components missing" if size == INCOMPLETE_SIZE else kind
            colour = view.style.colour
            points = Points(view.minutes, level, colour, symbol, hollow, size, name, chosen)
            primitives.append(points)
    return Panel(
        bounds,
        tuple(primitives),
        title=f"Measurements over time (hollow: tentative{small})",
        y_label="type",
        x_limits=limits,
        y_limits=(-len(rows) + 0.5, 0.5),
        ticks=(),
    )
