"""The layout of a plotly figure of a scene: axes, titles, legend; colours as roles."""

import math
from collections.abc import Sequence
from functools import lru_cache
from html import escape
from typing import Any

from trackmetrics.report.axes import log_ticks
from trackmetrics.report.scene import Panel, Scene

Json = dict[str, Any]


@lru_cache(4096)
def literal(text: str) -> str:
    """Escapes a text so that plotly shows it unchanged.

    Plotly interprets tags, and templates in hover texts; a leading ``@`` would be read as a role.
    """
    safe = escape(text, quote=False).replace("%{", "%&#123;")
    return "&#64;" + safe[1:] if safe.startswith("@") else safe


def short(value: float) -> float:
    """A coordinate with as many digits as can be seen."""
    return float(f"{value:.7g}")


def axis_names(i: int) -> tuple[str, str]:
    return (f"x{i + 1}", f"y{i + 1}") if i else ("x", "y")


_AXIS: Json = {
    "gridcolor": "@grid",
    "linecolor": "@edge",
    "showline": True,
    "zeroline": False,
    "tickfont": {"size": 11},
    "ticks": "",
}
_TEMPLATE: Json = {
    "layout": {
        "xaxis": {**_AXIS, "title": {"standoff": 6, "font": {"size": 12}}},
        "yaxis": {**_AXIS, "title": {"standoff": 8, "font": {"size": 12}}},
    }
}


def empty_layout(scene: Scene) -> Json:
    layout: Json = {
        "template": _TEMPLATE,
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
        "x": short(left / scene.width),
        "y": short(1 - top / scene.height),
        "xanchor": "left",
        "yanchor": "top",
        "align": "left",
        "font": {"size": size, "color": colour},
    }


def title_of(scene: Scene, panel: Panel) -> list[Json]:
    if not panel.title:
        return []
    text = _text_at(
        scene, panel.bounds.left, panel.bounds.top - 4, literal(panel.title), 12.5, "@ink"
    )
    return [{**text, "yanchor": "bottom"}]


def axes_of(scene: Scene, panel: Panel, i: int, first: int) -> tuple[Json, Json]:
    bounds = panel.bounds
    bottom = 1 - (bounds.top + bounds.height) / scene.height
    x: Json = {
        "domain": [
            short(bounds.left / scene.width),
            short((bounds.left + bounds.width) / scene.width),
        ],
        "anchor": axis_names(i)[1],
        "showticklabels": bool(panel.x_label),
        "title": {"text": literal(panel.x_label)},
    }
    if panel.x_limits:
        x["range"] = [short(v) for v in panel.x_limits]
    if panel.x_ticks is not None:
        x |= _named_ticks(panel.x_ticks)
    if panel.linked and i != first:
        x["matches"] = axis_names(first)[0]
    y = {
        "domain": [short(bottom), short(bottom + bounds.height / scene.height)],
        "anchor": axis_names(i)[0],
        "title": {"text": literal(panel.y_label)},
        **_y_scale(panel),
    }
    return x, y


def _y_scale(panel: Panel) -> Json:
    scale: Json = {"type": "log" if panel.log else "linear"}
    if panel.y_limits:
        scale["range"] = [short(math.log10(v) if panel.log else v) for v in panel.y_limits]
    ticks = panel.ticks
    if ticks is None and panel.log and panel.y_limits:
        ticks = tuple(log_ticks(panel.y_limits))
    if ticks is not None:
        scale |= _named_ticks(ticks)
    elif panel.bounds.height < 150:
        scale["nticks"] = 5
    return scale


def _named_ticks(ticks: Sequence[tuple[float, str]]) -> Json:
    return {
        "tickvals": [short(v) for v, _ in ticks],
        "ticktext": [literal(name) for _, name in ticks],
    }
