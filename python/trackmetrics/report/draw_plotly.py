"""Draws a scene with plotly: as a plain dictionary whose colours are roles.

``{"color": "@track-3/0.2"}`` is a role; :func:`coloured` puts a theme's colours in, in Python for
a figure, in the browser for the page. So the page changes its theme without a second copy of the
data.
"""

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import numpy as np

from trackmetrics.report.axes import finite_runs, log_ticks
from trackmetrics.report.scene import (
    Band,
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
)
from trackmetrics.report.theme import Theme

Json = dict[str, Any]
_DIGITS = 4


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


def figure(scene: Scene) -> Json:
    """The scene as plotly's data and layout, colours as roles."""
    data: list[Json] = []
    layout = _layout(scene)
    first = next((i for i, panel in enumerate(scene.panels) if panel.linked), 0)
    for i, panel in enumerate(scene.panels):
        x, y = _axis_names(i)
        layout[f"xaxis{x[1:]}"], layout[f"yaxis{y[1:]}"] = _axes(scene, panel, i, first)
        layout["annotations"] += _title(scene, panel)
        for item in panel.primitives:
            _DRAW[type(item)](_Target(panel, x, y, data, layout), item)
    return {"data": data, "layout": layout}


class _Target:
    """Where the primitives of one panel go."""

    def __init__(self, panel: Panel, x: str, y: str, data: list[Json], layout: Json) -> None:
        self.panel, self.x, self.y, self.data, self.layout = panel, x, y, data, layout

    def trace(self, item: Any, **content: Any) -> None:
        """Adds a trace."""
        axes = {"xaxis": self.x, "yaxis": self.y, "type": "scatter"}
        named = {
            "name": literal(item.name),
            "showlegend": self.panel.legend and isinstance(item, (Line, Band)) and bool(item.name),
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
        return float(np.log10(max(y, 1e-12))) if self.panel.log else y


def literal(text: str) -> str:
    """Escapes a text so that plotly shows it unchanged.

    Plotly interprets tags, and templates in hover texts; a leading ``@`` would be read as a role.
    """
    safe = escape(text, quote=False).replace("%{", "%&#123;")
    return "&#64;" + safe[1:] if safe.startswith("@") else safe


def numbers(values: Floats, log: bool = False) -> list[float | None]:
    """Numbers as short as the eye can tell: four digits, on a linear axis those of the span."""
    known = np.isfinite(values)
    finite = values[known]
    if log:
        return [float(f"{v:.{_DIGITS}g}") if v == v else None for v in values.tolist()]
    span = float(np.ptp(finite)) if finite.size else 0.0
    span = span or float(np.abs(finite).max(initial=0.0)) or 1.0
    short: list[float | None] = np.round(values, _DIGITS - int(np.floor(np.log10(span)))).tolist()
    return short if known.all() else [v if v == v else None for v in short]


def _axis_names(i: int) -> tuple[str, str]:
    return (f"x{i + 1}", f"y{i + 1}") if i else ("x", "y")


def _layout(scene: Scene) -> Json:
    layout: Json = {
        "width": scene.width,
        "height": scene.height,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0, "pad": 0},
        "paper_bgcolor": "@surface",
        "plot_bgcolor": "@surface",
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": "@muted"},
        "hoverlabel": {
            "bgcolor": "@page",
            "bordercolor": "@edge",
            "font": {"color": "@ink"},
            "namelength": -1,
        },
        "hovermode": "closest",
        "dragmode": "zoom",
        "showlegend": any(panel.legend for panel in scene.panels),
        "legend": _legend(scene),
        "shapes": [],
        "annotations": [],
    }
    for heading in scene.headings:
        text = _text_at(scene, heading.left, heading.top, heading.text, 12, "@muted")
        layout["annotations"].append({**text, "yanchor": "bottom"})
    if scene.title:
        left = scene.panels[0].bounds.left if scene.panels else 0.0
        layout["annotations"] += [
            _text_at(scene, left, 18, f"<b>{literal(scene.title)}</b>", 20, "@ink"),
            _text_at(scene, left, 46, literal(scene.subtitle).replace("\n", "<br>"), 13, "@muted"),
        ]
    return layout


def _legend(scene: Scene) -> Json:
    """Above the right end of the panel that has one."""
    bounds = next((panel.bounds for panel in scene.panels if panel.legend), None)
    if bounds is None:
        return {}
    return {
        "orientation": "h",
        "x": (bounds.left + bounds.width) / scene.width,
        "xanchor": "right",
        "y": 1 - (bounds.top - 2) / scene.height,
        "yanchor": "bottom",
        "font": {"size": 11.5, "color": "@ink"},
        "bgcolor": "@surface/0",
    }


def _text_at(scene: Scene, left: float, top: float, text: str, size: float, colour: str) -> Json:
    return {
        "text": text,
        "showarrow": False,
        "xref": "paper",
        "yref": "paper",
        "x": left / scene.width,
        "y": 1 - top / scene.height,
        "xanchor": "left",
        "yanchor": "top",
        "align": "left",
        "font": {"size": size, "color": colour},
    }


def _title(scene: Scene, panel: Panel) -> list[Json]:
    if not panel.title:
        return []
    text = _text_at(
        scene, panel.bounds.left, panel.bounds.top - 4, literal(panel.title), 12.5, "@ink"
    )
    return [{**text, "yanchor": "bottom"}]


def _axes(scene: Scene, panel: Panel, i: int, first: int) -> tuple[Json, Json]:
    bounds = panel.bounds
    bottom = 1 - (bounds.top + bounds.height) / scene.height
    common = {
        "gridcolor": "@grid",
        "linecolor": "@edge",
        "showline": True,
        "zeroline": False,
        "tickfont": {"size": 11},
        "ticks": "",
    }
    x: Json = {
        **common,
        "domain": [bounds.left / scene.width, (bounds.left + bounds.width) / scene.width],
        "anchor": _axis_names(i)[1],
        "showticklabels": bool(panel.x_label),
        "title": {"text": literal(panel.x_label), "standoff": 6, "font": {"size": 12}},
    }
    if panel.x_limits:
        x["range"] = list(panel.x_limits)
    if panel.x_ticks is not None:
        x |= _named_ticks(panel.x_ticks)
    if panel.linked and i != first:
        x["matches"] = _axis_names(first)[0]
    y = {
        **common,
        "domain": [bottom, bottom + bounds.height / scene.height],
        "anchor": _axis_names(i)[0],
        "title": {"text": literal(panel.y_label), "standoff": 8, "font": {"size": 12}},
        **_y_scale(panel),
    }
    return x, y


def _y_scale(panel: Panel) -> Json:
    scale: Json = {"type": "log" if panel.log else "linear"}
    if panel.y_limits:
        scale["range"] = [float(np.log10(v)) if panel.log else v for v in panel.y_limits]
    ticks = panel.ticks
    if ticks is None and panel.log and panel.y_limits:
        ticks = tuple(log_ticks(panel.y_limits))
    if ticks is not None:
        scale |= _named_ticks(ticks)
    elif panel.bounds.height < 150:
        scale["nticks"] = 5
    return scale


def _named_ticks(ticks: Sequence[tuple[float, str]]) -> Json:
    return {"tickvals": [v for v, _ in ticks], "ticktext": [literal(name) for _, name in ticks]}


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
        x=numbers(item.x),
        y=numbers(item.y, target.panel.log),
        line=line,
        **({"hovertemplate": _hover(target, item.name)} if item.name else {"hoverinfo": "skip"}),
    )


def _points(target: _Target, item: Points) -> None:
    outline = {"color": f"@{item.colour}" if item.hollow else "@surface"}
    target.trace(
        item,
        mode="markers",
        x=numbers(item.x),
        y=numbers(item.y, target.panel.log),
        marker={
            "symbol": item.symbol + ("-open" if item.hollow else ""),
            "size": item.size,
            "color": f"@{item.colour}",
            "line": {**outline, "width": 1.3 if item.hollow else 0.5},
        },
        hovertemplate=_hover(target, item.name),
        cliponaxis=False,
    )


def _area(target: _Target, item: Band | Rects, x: list[Any], y: list[Any]) -> None:
    target.trace(
        item,
        mode="lines",
        x=x,
        y=y,
        fill="toself",
        fillcolor=f"@{item.colour}",
        line={"width": 0},
        hoverinfo="skip",
    )


def _band(target: _Target, item: Band) -> None:
    """The outline of each run without gaps: along the upper side, back along the lower."""
    xs: list[float | None] = []
    ys: list[float | None] = []
    x, high, low = (
        numbers(item.x),
        _short(target, item.high),
        _short(target, item.low),
    )
    for part in finite_runs(item.x, item.low, item.high):
        gap: list[None] = [None] if xs else []
        xs += [*gap, *x[part], *x[part][::-1]]
        ys += [*gap, *high[part], *low[part][::-1]]
    _area(target, item, xs, ys)


def _boxes(target: _Target, item: Rects) -> None:
    xs: list[float | None] = []
    ys: list[float | None] = []
    sides = (numbers(item.left), numbers(item.right))
    edges = (_short(target, item.low), _short(target, item.high))
    for a, b, c, d in zip(*sides, *edges, strict=True):
        gap: list[None] = [None] if xs else []
        xs += [*gap, a, b, b, a, a]
        ys += [*gap, c, c, d, d, c]
    _area(target, item, xs, ys)


def _bars(target: _Target, item: ErrorBars) -> None:
    x = _with_gaps(numbers(item.x), numbers(item.x))
    y = _with_gaps(_short(target, item.low), _short(target, item.high))
    line = {"color": f"@{item.colour}", "width": item.width}
    target.trace(item, mode="lines", x=x, y=y, line=line, hoverinfo="skip")


def _short(target: _Target, values: Floats) -> list[float | None]:
    return numbers(values, target.panel.log)


def _with_gaps(low: Sequence[float | None], high: Sequence[float | None]) -> list[float | None]:
    return [value for pair in zip(low, high, strict=True) for value in (*pair, None)]


def _level(target: _Target, item: HLine) -> None:
    across = {"xref": f"{target.x} domain", "yref": target.y, "x0": 0, "x1": 1, "y0": item.y}
    if item.top is None:
        line = {"color": f"@{item.colour}", "width": 1, "dash": item.dash}
        target.shape(type="line", y1=item.y, line=line, **across)
    else:
        fill = f"@{item.colour}"
        target.shape(type="rect", y1=item.top, fillcolor=fill, line={"width": 0}, **across)


def _event(target: _Target, item: Event) -> None:
    ends = {"x0": item.x, "x1": item.x, "y0": 0, "y1": 1}
    line = {"color": f"@{item.colour}", "width": 1.4, "dash": item.dash}
    target.shape(type="line", xref=target.x, yref=f"{target.y} domain", line=line, **ends)
    target.annotation(
        text=item.label,
        x=item.x,
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
        return {"x": x}
    return {"x": (x - low) / (high - low), "xref": f"{target.x} domain"}


def _text(target: _Target, item: Text) -> None:
    target.annotation(
        text=f"<b>{literal(item.text)}</b>" if item.bold else literal(item.text),
        **_across(target, item.x),
        y=target.height(item.y),
        yref=target.y,
        xanchor=item.anchor,
        yanchor="bottom" if item.above else "middle",
        bgcolor="@surface/0.75",
        borderpad=0,
        font={"size": 11.5, "color": f"@{item.colour}"},
    )


_DRAW: dict[type[Primitive], Callable[[_Target, Any], None]] = {
    Band: _band,
    ErrorBars: _bars,
    Rects: _boxes,
    Event: _event,
    HLine: _level,
    Line: _line,
    Points: _points,
    Text: _text,
}
