"""Scene of several tracks in the same axes: their NIS and NEES, and the means of segments."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackmetrics.report.axes import Limits, log_limits, on_log_axis
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Bounds,
    HLine,
    Line,
    Panel,
    Points,
    Primitive,
    Scene,
    floats,
)
from trackmetrics.report.track_view import TrackView

MANY_UPDATES = 60
"""Tracks with more updates than this are drawn with smaller and paler points."""


def comparison_scene(views: Sequence[TrackView], drawn: Sequence[TrackView] | None = None) -> Scene:
    """NIS and NEES of the drawn tracks in the same axes, which fit all tracks."""
    frame = Frame()
    with_nees = any(view.track.nees is not None for view in views)
    quantities = ("nis", "nees") if with_nees else ("nis",)
    all_bounds = frame.rows(52.0, [230.0] * len(quantities), 40.0)
    panels = [
        _comparison_panel(views, views if drawn is None else drawn, quantity, bounds)
        for quantity, bounds in zip(quantities, all_bounds, strict=True)
    ]
    if views:
        panels[-1] = replace(panels[-1], x_label=views[0].clock.label)
    return Scene(
        frame.width, all_bounds[-1].top + all_bounds[-1].height + frame.bottom, tuple(panels)
    )


def _comparison_panel(
    views: Sequence[TrackView], drawn: Sequence[TrackView], quantity: str, bounds: Bounds
) -> Panel:
    scales = [s.scale for view in views for s in view.segments(quantity)]
    limits = log_limits([*(view.per_dof(quantity)[0] for view in views), floats(scales)])
    primitives = [m for view in drawn for m in _updates(view, quantity, limits)]
    primitives += [m for view in drawn for m in _means(view, quantity)]
    return Panel(
        bounds,
        (HLine(1.0, "muted/0.8"), *primitives),
        title=f"{quantity.upper()}: updates and segment means",
        y_label=f"{quantity.upper()} / {'dof' if quantity == 'nis' else 'states'}",
        log=True,
        x_limits=views[0].x_limits if views else None,
        y_limits=limits,
        legend=quantity == "nis",
    )


def _updates(view: TrackView, quantity: str, limits: Limits) -> list[Primitive]:
    """The points of one track, paler where they are many."""
    values = view.per_dof(quantity)[0]
    opacity, size = ("0.6", 5.0) if len(values) <= MANY_UPDATES else ("0.3", 3.5)
    primitives: list[Primitive] = []
    for _, symbol, hollow, rows in view.by_measurement_type():
        chosen = rows & np.isfinite(values)
        if chosen.any():
            x, y = view.minutes[chosen], on_log_axis(values[chosen], limits)
            role = f"{view.style.colour}/{opacity}"
            primitives.append(Points(x, y, role, symbol, hollow, size, view.track.track))
    return primitives


def _means(view: TrackView, quantity: str) -> list[Primitive]:
    """The segments of one track as a stepped line."""
    segments = view.segments(quantity)
    if not segments:
        return []
    starts = [segment.start_time for segment in segments]
    times = np.repeat([*starts, segments[-1].stop_time], 2)[1:-1]
    scales = floats(np.repeat([segment.scale for segment in segments], 2))
    style = view.style
    x = view.clock(times)
    return [Line(x, scales, style.colour, 2.6, style.dash, view.track.track)]
