"""Draws a scene with plotly: as a plain dictionary whose colours are roles.

``{"color": "@track-3/0.2"}`` is a role; :func:`coloured` puts a theme's colours in, in Python for
a figure, in the browser for the page. So the page changes its theme without a second copy of the
data.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from trackmetrics.report.arrays import Arrays, PlainArrays
from trackmetrics.report.plotly_layout import (
    Json,
    axes_of,
    axis_names,
    empty_layout,
    literal,
    short,
    title_of,
)
from trackmetrics.report.scene import (
    Band,
    ErrorBars,
    Event,
    HLine,
    Line,
    Panel,
    Points,
    Primitive,
    Rects,
    Scene,
    StdBand,
    Text,
)
from trackmetrics.report.theme import Theme


def draw(scene: Scene, theme: Theme) -> Any:
    """A ``plotly.graph_objects.Figure``."""
    from plotly.graph_objects import Figure

    return Figure(coloured(figure(scene), theme))


def coloured(value: Any, theme: Theme) -> Any:
    """The same with the colours of a theme where there were roles."""
    if isinstance(value, dict):
        return {key: coloured(item, theme) for key, item in value.items()}
    if isinstance(value, list):
        return [coloured(item, theme) for item in value]
    if isinstance(value, str) and value.startswith("@"):
        return theme.css(value[1:])
    return value


def figure(scene: Scene, arrays: Arrays | None = None) -> Json:
    """The scene as plotly's data and layout, colours as roles, numbers by ``arrays``."""
    arrays = PlainArrays() if arrays is None else arrays
    data: list[Json] = []
    layout = empty_layout(scene)
    first = next((i for i, panel in enumerate(scene.panels) if panel.linked), 0)
    for i, panel in enumerate(scene.panels):
        x, y = axis_names(i)
        layout[f"xaxis{x[1:]}"], layout[f"yaxis{y[1:]}"] = axes_of(scene, panel, i, first)
        layout["annotations"] += title_of(scene, panel)
        for item in panel.primitives:
            _DRAW[type(item)](_Target(panel, x, y, data, layout, arrays), item)
    return {"data": data, "layout": layout}


class _Target:
    """Where the primitives of one panel go."""

    def __init__(
        self, panel: Panel, x: str, y: str, data: list[Json], layout: Json, arrays: Arrays
    ) -> None:
        self.panel, self.x, self.y, self.data, self.layout = panel, x, y, data, layout
        self.arrays = arrays

    def trace(self, item: Any, **content: Any) -> None:
        """Adds a trace."""
        axes = {"xaxis": self.x, "yaxis": self.y, "type": "scatter"}
        listed = self.panel.legend and isinstance(item, Line | Band | StdBand)
        named = {
            "name": literal(item.name),
            "showlegend": listed and bool(item.name),
        }
        self.data.append({**axes, **named, **content})

    def annotation(self, **content: Any) -> None:
        """Adds a text."""
        self.layout["annotations"].append({"showarrow": False, "xref": self.x, **content})

    def shape(self, **content: Any) -> None:
        """Adds a line or a rectangle."""
        self.layout["shapes"].append({"layer": "below", **content})

    def height(self, y: float) -> float:
        """A value of the y axis as annotations want it; a zero lies below every logarithmic one."""
        return math.log10(max(y, 1e-12)) if self.panel.log else y


def _hover(target: _Target, name: str) -> str:
    unit = f" {target.panel.x_unit}".rstrip()
    return f"%{{x:.4g}}{unit}<br>%{{y:.4g}}<extra>{literal(name)}</extra>"


def _line(target: _Target, item: Line) -> None:
    line = {"color": f"@{item.colour}", "width": item.width, "dash": item.dash}
    if item.steps:
        line["shape"] = "hv"
    target.trace(
        item,
        mode="lines",
        x=target.arrays.times(item.x),
        y=target.arrays.values(item.y, target.panel.log),
        line=line,
        **({"hovertemplate": _hover(target, item.name)} if item.name else {"hoverinfo": "skip"}),
    )


def _points(target: _Target, item: Points) -> None:
    outline = {"color": f"@{item.colour}" if item.hollow else "@surface"}
    target.trace(
        item,
        mode="markers",
        x=target.arrays.times(item.x, item.rows),
        y=target.arrays.values(item.y, target.panel.log, item.rows),
        marker={
            "symbol": item.symbol + ("-open" if item.hollow else ""),
            "size": item.size,
            "color": f"@{item.colour}",
            "line": {**outline, "width": 1.3 if item.hollow else 0.5},
        },
        hovertemplate=_hover(target, item.name),
        cliponaxis=False,
    )


def _area(target: _Target, item: Band | StdBand | Rects, **content: Any) -> None:
    target.trace(
        item,
        mode="lines",
        fill="toself",
        fillcolor=f"@{item.colour}",
        line={"width": 0},
        hoverinfo="skip",
        **content,
    )


def _band(target: _Target, item: Band) -> None:
    _area(target, item, **target.arrays.band(item.x, item.low, item.high, target.panel.log))


def _std_band(target: _Target, item: StdBand) -> None:
    band = target.arrays.std_band(item.x, item.centre, item.std, item.factor)
    _area(target, item, **band)


def _rects(target: _Target, item: Rects) -> None:
    """The outlines of the rectangles, with gaps between them."""
    xs: list[float | None] = []
    ys: list[float | None] = []
    for a, b, c, d in zip(item.left, item.right, item.low, item.high, strict=True):
        gap: list[None] = [None] if xs else []
        xs += [*gap, *map(short, (a, b, b, a, a))]
        ys += [*gap, *map(short, (c, c, d, d, c))]
    _area(target, item, x=xs, y=ys)


def _error_bars(target: _Target, item: ErrorBars) -> None:
    """Upwards bars at points of which nothing else is drawn."""
    log = target.panel.log
    bars = {
        "type": "data",
        "symmetric": False,
        "array": target.arrays.values(item.high - item.low, log),
        "arrayminus": target.arrays.values(np.zeros(len(item.x)), False),
        "color": f"@{item.colour}",
        "thickness": item.width,
        "width": 0,
    }
    target.trace(
        item,
        mode="markers",
        x=target.arrays.times(item.x),
        y=target.arrays.values(item.low, log),
        error_y=bars,
        marker={"size": 0.1, "color": f"@{item.colour}"},
        hoverinfo="skip",
    )


def _level(target: _Target, item: HLine) -> None:
    across = {
        "xref": f"{target.x} domain",
        "yref": target.y,
        "x0": 0,
        "x1": 1,
        "y0": short(item.y),
    }
    if item.top is None:
        line = {"color": f"@{item.colour}", "width": 1, "dash": item.dash}
        target.shape(type="line", y1=short(item.y), line=line, **across)
    else:
        fill = f"@{item.colour}"
        target.shape(type="rect", y1=short(item.top), fillcolor=fill, line={"width": 0}, **across)


def _event(target: _Target, item: Event) -> None:
    ends = {"x0": short(item.x), "x1": short(item.x), "y0": 0, "y1": 1}
    line = {"color": f"@{item.colour}", "width": 1.4, "dash": item.dash}
    target.shape(type="line", xref=target.x, yref=f"{target.y} domain", line=line, **ends)
    target.annotation(
        text=item.label,
        x=short(item.x),
        y=1,
        yref=f"{target.y} domain",
        xanchor="right" if item.left else "left",
        yanchor="top",
        yshift=-14 * item.row,
        font={"size": 11, "color": f"@{item.colour}"},
    )


def _across(target: _Target, x: float) -> Json:
    """The x position of a text; in fractions of the panel if outside, where plotly hides it."""
    low, high = target.panel.x_limits or (x, x)
    if low <= x <= high:
        return {"x": short(x)}
    return {"x": short((x - low) / (high - low)), "xref": f"{target.x} domain"}


def _text(target: _Target, item: Text) -> None:
    target.annotation(
        text=f"<b>{literal(item.text)}</b>" if item.bold else literal(item.text),
        **_across(target, item.x),
        y=short(target.height(item.y)),
        yref=target.y,
        xanchor=item.anchor,
        yanchor="bottom" if item.above else "middle",
        bgcolor="@surface/0.75",
        borderpad=0,
        font={"size": 11.5, "color": f"@{item.colour}"},
    )


_DRAW: dict[type[Primitive], Callable[[_Target, Any], None]] = {
    Band: _band,
    StdBand: _std_band,
    ErrorBars: _error_bars,
    Rects: _rects,
    Event: _event,
    HLine: _level,
    Line: _line,
    Points: _points,
    Text: _text,
}
