"""Draws a scene with matplotlib: for papers, tickets and notebooks."""

from collections.abc import Callable
from typing import Any

from trackmetrics.report.axes import log_ticks
from trackmetrics.report.layout import LEGEND_COLUMNS
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
    from matplotlib.text import Text as MatplotlibText

    figure = Figure(figsize=(scene.width / INCH, scene.height / INCH), dpi=INCH)
    figure.set_facecolor(theme.rgba("surface"))
    if scene.title:
        _headline(figure, scene, theme)
    for heading in scene.headings:
        position = (heading.left / scene.width, 1 - heading.top / scene.height)
        figure.text(
            *position, heading.text, color=theme.rgba("muted"), size=12 * _POINT, va="bottom"
        )
    linked: dict[bool, Any] = {}
    for panel in scene.panels:
        axes = _axes(figure, scene, panel, linked.get(panel.linked))
        if panel.linked:
            linked.setdefault(True, axes)
        _dress(axes, panel, theme)
        for item in panel.primitives:
            _DRAW[type(item)](axes, item, theme)
        if panel.legend:
            _legend(axes, theme)
    for text in figure.findobj(MatplotlibText):
        text.set_parse_math(False)
    return figure


def _headline(figure: Any, scene: Scene, theme: Theme) -> None:
    left = scene.panels[0].bounds.left / scene.width if scene.panels else 0.05
    y = 1 - 18.0 / scene.height
    figure.text(
        left, y, scene.title, color=theme.rgba("ink"), size=20 * _POINT, weight="bold", va="top"
    )
    y = 1 - 46.0 / scene.height
    figure.text(left, y, scene.subtitle, color=theme.rgba("muted"), size=13 * _POINT, va="top")


def _axes(figure: Any, scene: Scene, panel: Panel, shared: Any) -> Any:
    bounds = panel.bounds
    fractions = (
        bounds.left / scene.width,
        1 - (bounds.top + bounds.height) / scene.height,
        bounds.width / scene.width,
        bounds.height / scene.height,
    )
    return figure.add_axes(fractions, sharex=shared)


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
    elif panel.bounds.height < 150:
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


def _line(axes: Any, item: Line, theme: Theme) -> None:
    axes.plot(
        item.x,
        item.y,
        color=theme.rgba(item.colour),
        linewidth=item.width * _POINT,
        linestyle=_DASHES[item.dash],
        drawstyle="steps-post" if item.steps else "default",
        label=item.name or "_",
        zorder=3,
        solid_capstyle="butt",
    )


def _points(axes: Any, item: Points, theme: Theme) -> None:
    colour = theme.rgba(item.colour)
    axes.plot(
        *item.drawn(),
        linestyle="none",
        marker=_MARKERS[item.symbol],
        markersize=item.size * _POINT,
        markerfacecolor="none" if item.hollow else colour,
        markeredgecolor=colour if item.hollow else theme.rgba("surface"),
        markeredgewidth=1.2 * _POINT if item.hollow else 0.5 * _POINT,
        zorder=3,
    )


def _band(axes: Any, item: Band | StdBand, theme: Theme) -> None:
    colour = theme.rgba(item.colour)
    axes.fill_between(
        item.x,
        item.low,
        item.high,
        color=colour,
        linewidth=0,
        label=item.name or "_",
        zorder=1.5,
    )


def _error_bars(axes: Any, item: ErrorBars, theme: Theme) -> None:
    axes.vlines(
        item.x,
        item.low,
        item.high,
        color=theme.rgba(item.colour),
        linewidth=item.width * _POINT,
        capstyle="butt",
        zorder=1.2,
    )


def _rects(axes: Any, item: Rects, theme: Theme) -> None:
    from matplotlib.collections import PolyCollection

    corners = [
        [(a, c), (b, c), (b, d), (a, d)]
        for a, b, c, d in zip(item.left, item.right, item.low, item.high, strict=True)
    ]
    rects = PolyCollection(corners, facecolor=theme.rgba(item.colour), linewidth=0, zorder=1.4)
    axes.add_collection(rects, autolim=False)


def _level(axes: Any, item: HLine, theme: Theme) -> None:
    colour = theme.rgba(item.colour)
    if item.top is not None:
        axes.axhspan(item.y, item.top, color=colour, linewidth=0, zorder=1)
    else:
        axes.axhline(
            item.y,
            color=colour,
            linewidth=1.0 * _POINT,
            linestyle=_DASHES[item.dash],
            zorder=2,
        )


def _event(axes: Any, item: Event, theme: Theme) -> None:
    colour = theme.rgba(item.colour)
    axes.axvline(
        item.x,
        color=colour,
        linewidth=1.4 * _POINT,
        linestyle=_DASHES[item.dash],
        zorder=2.5,
    )
    axes.annotate(
        item.label,
        (item.x, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-3 if item.left else 3, -2 - 14 * _POINT * item.row),
        textcoords="offset points",
        ha="right" if item.left else "left",
        va="top",
        size=11 * _POINT,
        color=colour,
        zorder=6,
    )


def _text(axes: Any, item: Text, theme: Theme) -> None:
    axes.annotate(
        item.text,
        (item.x, item.y),
        xytext=(0, 2 if item.above else 0),
        textcoords="offset points",
        ha=item.anchor,
        va="bottom" if item.above else "center",
        size=11.5 * _POINT,
        color=theme.rgba(item.colour),
        weight="bold" if item.bold else "normal",
        bbox={"facecolor": theme.rgba("surface/0.75"), "edgecolor": "none", "pad": 0.5},
        zorder=5,
        annotation_clip=False,
    )


_DRAW: dict[type[Primitive], Callable[[Any, Any, Theme], None]] = {
    Band: _band,
    StdBand: _band,
    ErrorBars: _error_bars,
    Rects: _rects,
    Event: _event,
    HLine: _level,
    Line: _line,
    Points: _points,
    Text: _text,
}
