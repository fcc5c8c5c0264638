"""Draws a scene with matplotlib: for papers, tickets and notebooks."""

from collections.abc import Callable
from typing import Any

from trackmetrics.report.axes import log_ticks
from trackmetrics.report.layout import LEGEND_COLUMNS
from trackmetrics.report.scene import (
    Band,
    Bars,
    Boxes,
    Event,
    Level,
    Line,
    Mark,
    Panel,
    Points,
    Scene,
    Text,
)
from trackmetrics.report.theme import Theme

INCH = 100.0
"""Pixels of a scene in an inch."""
_POINT = 72.0 / INCH
"""Points of type in a pixel of a scene."""
_MARKERS = {
    "circle": "o",
    "square": "s",
    "diamond": "D",
    "triangle-up": "^",
    "triangle-down": "v",
    "cross": "P",
    "pentagon": "p",
    "star": "*",
}
_DASHES: dict[str, Any] = {
    "solid": "-",
    "dash": (0, (4, 2)),
    "dot": (0, (1, 1.6)),
    "dashdot": (0, (5, 2, 1, 2)),
}


def draw(scene: Scene, theme: Theme) -> Any:
    """A ``matplotlib.figure.Figure``."""
    from matplotlib.figure import Figure
    from matplotlib.text import Text as Words

    figure = Figure(figsize=(scene.width / INCH, scene.height / INCH), dpi=INCH)
    figure.set_facecolor(theme.rgba("surface"))
    if scene.title:
        _headline(figure, scene, theme)
    for heading in scene.headings:
        place = (heading.left / scene.width, 1 - heading.top / scene.height)
        figure.text(*place, heading.text, color=theme.rgba("muted"), size=12 * _POINT, va="bottom")
    linked: dict[bool, Any] = {}
    for panel in scene.panels:
        axes = _axes(figure, scene, panel, linked.get(panel.linked))
        if panel.linked:
            linked.setdefault(True, axes)
        _dress(axes, panel, theme)
        for mark in panel.marks:
            _DRAW[type(mark)](axes, mark, theme)
        if panel.legend:
            _legend(axes, theme)
    for text in figure.findobj(Words):
        text.set_parse_math(False)
    return figure


def _headline(figure: Any, scene: Scene, theme: Theme) -> None:
    left = scene.panels[0].place.left / scene.width if scene.panels else 0.05
    y = 1 - 18.0 / scene.height
    figure.text(
        left, y, scene.title, color=theme.rgba("ink"), size=20 * _POINT, weight="bold", va="top"
    )
    y = 1 - 46.0 / scene.height
    figure.text(left, y, scene.subtitle, color=theme.rgba("muted"), size=13 * _POINT, va="top")


def _axes(figure: Any, scene: Scene, panel: Panel, shared: Any) -> Any:
    place = panel.place
    bounds = (
        place.left / scene.width,
        1 - (place.top + place.height) / scene.height,
        place.width / scene.width,
        place.height / scene.height,
    )
    return figure.add_axes(bounds, sharex=shared)


def _dress(axes: Any, panel: Panel, theme: Theme) -> None:
    """Scales, limits, labels, grid and frame."""
    axes.set_facecolor(theme.rgba("surface"))
    if panel.log:
        axes.set_yscale("log")
    if panel.x_limits:
        axes.set_xlim(panel.x_limits)
    if panel.y_limits:
        axes.set_ylim(panel.y_limits)
    axes.set_title(
        panel.title, loc="left", size=12.5 * _POINT, color=theme.rgba("ink"), pad=5 * _POINT
    )
    axes.set_xlabel(panel.x_label, size=12 * _POINT, color=theme.rgba("muted"))
    axes.set_ylabel(panel.y_label, size=12 * _POINT, color=theme.rgba("muted"))
    _ticks(axes, panel)
    axes.grid(True, color=theme.rgba("grid"), linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(
        labelsize=11 * _POINT, colors=theme.rgba("muted"), length=0, labelbottom=bool(panel.x_label)
    )
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(theme.rgba("edge"))


def _ticks(axes: Any, panel: Panel) -> None:
    from matplotlib.ticker import NullLocator

    ticks = panel.ticks
    if ticks is None and panel.log and panel.y_limits:
        ticks = tuple(log_ticks(panel.y_limits))
    if ticks is not None:
        axes.set_yticks([value for value, _ in ticks], [name for _, name in ticks])
        axes.yaxis.set_minor_locator(NullLocator())
    elif panel.place.height < 150:
        axes.locator_params(axis="y", nbins=4)
    if panel.x_ticks is not None:
        axes.set_xticks(*zip(*panel.x_ticks, strict=True))


def _legend(axes: Any, theme: Theme) -> None:
    axes.legend(
        fontsize=11 * _POINT,
        frameon=False,
        labelcolor=theme.rgba("ink"),
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=LEGEND_COLUMNS,
        borderaxespad=0.1,
    )


def _line(axes: Any, mark: Line, theme: Theme) -> None:
    axes.plot(
        mark.x,
        mark.y,
        color=theme.rgba(mark.colour),
        linewidth=mark.width * _POINT,
        linestyle=_DASHES[mark.dash],
        drawstyle="steps-post" if mark.steps else "default",
        label=mark.name or "_",
        zorder=3,
        solid_capstyle="butt",
    )


def _points(axes: Any, mark: Points, theme: Theme) -> None:
    colour = theme.rgba(mark.colour)
    axes.plot(
        mark.x,
        mark.y,
        linestyle="none",
        marker=_MARKERS[mark.symbol],
        markersize=mark.size * _POINT,
        markerfacecolor="none" if mark.hollow else colour,
        markeredgecolor=colour if mark.hollow else theme.rgba("surface"),
        markeredgewidth=1.2 * _POINT if mark.hollow else 0.5 * _POINT,
        zorder=3,
    )


def _band(axes: Any, mark: Band, theme: Theme) -> None:
    colour = theme.rgba(mark.colour)
    axes.fill_between(
        mark.x, mark.low, mark.high, color=colour, linewidth=0, label=mark.name or "_", zorder=1.5
    )


def _bars(axes: Any, mark: Bars, theme: Theme) -> None:
    axes.vlines(
        mark.x,
        mark.low,
        mark.high,
        color=theme.rgba(mark.colour),
        linewidth=mark.width * _POINT,
        capstyle="butt",
        zorder=1.2,
    )


def _boxes(axes: Any, mark: Boxes, theme: Theme) -> None:
    from matplotlib.collections import PolyCollection

    corners = [
        [(a, c), (b, c), (b, d), (a, d)]
        for a, b, c, d in zip(mark.left, mark.right, mark.low, mark.high, strict=True)
    ]
    boxes = PolyCollection(corners, facecolor=theme.rgba(mark.colour), linewidth=0, zorder=1.4)
    axes.add_collection(boxes, autolim=False)


def _level(axes: Any, mark: Level, theme: Theme) -> None:
    colour = theme.rgba(mark.colour)
    if mark.top is not None:
        axes.axhspan(mark.y, mark.top, color=colour, linewidth=0, zorder=1)
    else:
        axes.axhline(
            mark.y, color=colour, linewidth=1.0 * _POINT, linestyle=_DASHES[mark.dash], zorder=2
        )


def _event(axes: Any, mark: Event, theme: Theme) -> None:
    colour = theme.rgba(mark.colour)
    axes.axvline(
        mark.x, color=colour, linewidth=1.4 * _POINT, linestyle=_DASHES[mark.dash], zorder=2.5
    )
    axes.annotate(
        mark.label,
        (mark.x, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-3 if mark.left else 3, -2 - 14 * _POINT * mark.row),
        textcoords="offset points",
        ha="right" if mark.left else "left",
        va="top",
        size=11 * _POINT,
        color=colour,
        zorder=6,
    )


def _text(axes: Any, mark: Text, theme: Theme) -> None:
    axes.annotate(
        mark.text,
        (mark.x, mark.y),
        xytext=(0, 2 if mark.above else 0),
        textcoords="offset points",
        ha=mark.anchor,
        va="bottom" if mark.above else "center",
        size=11.5 * _POINT,
        color=theme.rgba(mark.colour),
        weight="bold" if mark.bold else "normal",
        bbox={"facecolor": theme.rgba("surface/0.75"), "edgecolor": "none", "pad": 0.5},
        zorder=5,
        annotation_clip=False,
    )


_DRAW: dict[type[Mark], Callable[[Any, Any, Theme], None]] = {
    Band: _band,
    Bars: _bars,
    Boxes: _boxes,
    Event: _event,
    Level: _level,
    Line: _line,
    Points: _points,
    Text: _text,
}
