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
    return Comparison(views).scene(views if drawn is None else drawn)


class Comparison:
    """Axes that fit all tracks, for scenes that draw some of them."""

    def __init__(self, views: Sequence[TrackView]) -> None:
        known = {verdict.quantity for view in views for verdict in view.quantities()} or {"nis"}
        self._quantities = [quantity for quantity in ("nis", "nees") if quantity in known]
        self._frame = Frame()
        self._bounds = self._frame.rows(52.0, [230.0] * len(self._quantities), 40.0)
        self._limits = {quantity: _limits(views, quantity) for quantity in self._quantities}
        self._x_limits = views[0].x_limits if views else None
        self._x_label = views[0].clock.label if views else ""

    def scene(self, drawn: Sequence[TrackView]) -> Scene:
        """The scene of some of the tracks."""
        panels = [
            self._panel(drawn, quantity, bounds)
            for quantity, bounds in zip(self._quantities, self._bounds, strict=True)
        ]
        panels[0] = replace(panels[0], legend=True)
        panels[-1] = replace(panels[-1], x_label=self._x_label)
        last = self._bounds[-1]
        height = last.top + last.height + self._frame.bottom
        return Scene(self._frame.width, height, tuple(panels))

    def _panel(self, drawn: Sequence[TrackView], quantity: str, bounds: Bounds) -> Panel:
        limits = self._limits[quantity]
        primitives = [p for view in drawn for p in _updates(view, quantity, limits)]
        primitives += [p for view in drawn for p in _means(view, quantity)]
        return Panel(
            bounds,
            (HLine(1.0, "muted/0.8"), *primitives),
            title=f"{quantity.upper()}: updates and segment means",
            y_label=f"{quantity.upper()} / {'dof' if quantity == 'nis' else 'states'}",
            log=True,
            x_limits=self._x_limits,
            y_limits=limits,
        )


def _limits(views: Sequence[TrackView], quantity: str) -> Limits:
    scales = [segment.scale for view in views for segment in view.segments(quantity)]
    return log_limits([*(view.per_dof(quantity)[0] for view in views), floats(scales)])


def _updates(view: TrackView, quantity: str, limits: Limits) -> list[Primitive]:
    """The points of one track, paler where they are many."""
    values = view.per_dof(quantity)[0]
    opacity, size = ("0.6", 5.0) if len(values) <= MANY_UPDATES else ("0.3", 3.5)
    primitives: list[Primitive] = []
    shown = on_log_axis(values, limits)
    role, name = f"{view.style.colour}/{opacity}", view.track.track
    for _, symbol, hollow, rows in view.groups_of(values):
        primitives.append(Points(view.minutes, shown, role, symbol, hollow, size, name, rows))
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
