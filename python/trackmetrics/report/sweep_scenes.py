"""Figures of a Monte Carlo sweep: honesty and accuracy over time, and a score over two settings."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics.monte_carlo import SweepResult
from trackmetrics.report.axes import linear_limits, log_limits, on_log_axis
from trackmetrics.report.diagnosis_figures import Backend, draw
from trackmetrics.report.layout import LEGEND_COLUMNS, Frame
from trackmetrics.report.scene import (
    Band,
    Boxes,
    Floats,
    Level,
    Line,
    Mark,
    Panel,
    Rectangle,
    Scene,
    Text,
    floats,
)
from trackmetrics.report.theme import DASHES, TRACK_COLOURS

# Scores that an honest filter has at 1.
_HONEST_AT_ONE = ("nees", "nis")


def sweep_figure(
    result: SweepResult,
    *,
    states: Sequence[str] | None = None,
    step: float | None = None,
    settings: Sequence[int] | None = None,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """ANEES of every setting over time with the band of an honest filter; below, RMSE by state.

    Parameters
    ----------
    result
        What :func:`trackmetrics.monte_carlo.sweep` found.
    states
        Names of the states, with their units.
    step
        Seconds from one step to the next; None counts steps.
    settings
        Places in ``result.grid`` of what is drawn; at most eight by default, those whose mean NEES
        is nearest to honest.
    backend
        ``"matplotlib"`` or ``"plotly"``.
    dark
        Whether the figure is for a dark page.

    Returns
    -------
    matplotlib.figure.Figure or plotly.graph_objects.Figure
        One colour for each setting; bands of RMSE are 95 % intervals over runs.
    """
    return draw(sweep_scene(result, states, step, settings), backend, dark)


def heat_figure(
    result: SweepResult,
    x: str,
    y: str,
    score: str = "nees",
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """A score over two parameters; outlined are settings whose mean NEES over the states has a 95 %
    interval that holds 1.

    Parameters
    ----------
    result
        What :func:`trackmetrics.monte_carlo.sweep` found.
    x, y
        The parameters; where the grid has others too, the first value of each is drawn.
    score
        Which of ``result.scores``; darker is more. NEES and NIS are red where they are above 1,
        blue below.
    backend, dark
        As for :func:`sweep_figure`.
    """
    return draw(heat_scene(result, x, y, score), backend, dark)


def sweep_scene(
    result: SweepResult,
    states: Sequence[str] | None = None,
    step: float | None = None,
    settings: Sequence[int] | None = None,
) -> Scene:
    """The panels of :func:`sweep_figure`."""
    frame = Frame()
    drawn = _nearest_to_honest(result) if settings is None else list(settings)
    if not drawn or not all(0 <= i < len(result.grid) for i in drawn):
        raise ValueError(f"settings must be of the {len(result.grid)} of the grid, got {drawn}")
    n = result.rmse.shape[2]
    names = list(states) if states is not None else [f"state {j}" for j in range(n)]
    if len(names) != n:
        raise ValueError(f"states has {len(names)} names, the filter has {n}")
    top, lower = frame.rows(_title_room(len(drawn)), [250.0, 210.0], 72.0)
    time = floats(np.arange(result.rmse.shape[1]) * (1.0 if step is None else step))
    axis = "step" if step is None else "time (s)"
    panels = [_honesty(result, drawn, settings is None, time, axis, top)]
    columns = frame.columns(lower.top, lower.height, n)
    panels += [
        _accuracy(result, drawn, j, name, time, axis, place)
        for j, (name, place) in enumerate(zip(names, columns, strict=True))
    ]
    subtitle = f"{result.runs} runs of each setting; bands are 95 % intervals"
    height = lower.top + lower.height + frame.bottom
    return Scene(
        frame.width, height, tuple(panels), "Is the filter honest, and how good?", subtitle
    )


def _nearest_to_honest(result: SweepResult) -> list[int]:
    """As many settings as there are colours, in the order of the grid."""
    if len(result.grid) <= TRACK_COLOURS:
        return list(range(len(result.grid)))
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.abs(np.log(np.nanmean(result.anees, axis=1)))
    return sorted(np.argsort(distance, kind="stable")[:TRACK_COLOURS].tolist())


def _title_room(settings: int) -> float:
    """Pixels above the panels: the title, and the rows of the legend on its right."""
    return max(92.0, 40.0 + 18.0 * math.ceil(settings / LEGEND_COLUMNS))


def _honesty(
    result: SweepResult,
    drawn: list[int],
    nearest: bool,
    time: Floats,
    axis: str,
    place: Rectangle,
) -> Panel:
    limits = log_limits([result.anees[drawn].ravel(), np.ravel(result.anees_interval)])
    marks: list[Mark] = []
    for low, high in np.atleast_2d(result.anees_interval)[:1]:
        marks.append(Level(float(low), "consistent/0.25", top=float(high)))
    marks.append(Level(1.0, "muted/0.8"))
    some = ""
    if len(drawn) < len(result.grid):
        some = f", {len(drawn)} of {len(result.grid)} settings" + ", the nearest" * nearest
    for k, i in enumerate(drawn):
        y = on_log_axis(result.anees[i], limits)
        marks.append(Line(time, y, *_style(k), name=label(result.grid[i])))
    return Panel(
        place,
        tuple(marks),
        title=f"ANEES / states{some}; the band is where an honest filter lies",
        x_label=axis,
        y_label="ANEES",
        log=True,
        x_limits=_ends(time),
        y_limits=limits,
        legend=True,
    )


def _accuracy(
    result: SweepResult,
    drawn: list[int],
    j: int,
    name: str,
    time: Floats,
    axis: str,
    place: Rectangle,
) -> Panel:
    marks: list[Mark] = []
    for k, i in enumerate(drawn):
        colour, width, dash = _style(k)
        low, high = result.rmse_interval[i, :, j].T
        marks.append(Band(time, low, high, f"{colour}/0.15"))
        line = Line(time, result.rmse[i, :, j], colour, width, dash, name=label(result.grid[i]))
        marks.append(line)
    return Panel(
        place,
        tuple(marks),
        title=f"RMSE of {name}",
        x_label=axis,
        x_limits=_ends(time),
        y_limits=linear_limits([result.rmse_interval[drawn, :, j].ravel()], (0.0, 0.0)),
    )


def _style(i: int) -> tuple[str, float, str]:
    """Colour, width and dash of a setting, as tracks have them."""
    return f"track-{i % TRACK_COLOURS}", 1.6, DASHES[i // TRACK_COLOURS % len(DASHES)]


def _ends(time: Floats) -> tuple[float, float]:
    return float(time[0]), float(time[-1]) if len(time) > 1 else float(time[0]) + 1.0


def label(settings: dict[str, Any]) -> str:
    """A setting in words."""
    return ", ".join(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
                     for name, value in settings.items()) or "the filter"  # fmt: skip


def heat_scene(result: SweepResult, x: str, y: str, score: str) -> Scene:
    """The panel of :func:`heat_figure`."""
    for name in (x, y):
        if name not in result.grid[0]:
            raise ValueError(f"the grid has no {name!r}, it has {', '.join(result.grid[0])}")
    if score not in result.scores:
        raise ValueError(f"there is no score {score!r}, there are {', '.join(result.scores)}")
    columns, rows = _values(result, x), _values(result, y)
    cells = _cells(result, x, y, score)
    frame = Frame(width=240.0 + 90.0 * len(columns), left=110.0)
    (place,) = frame.rows(64.0, [60.0 * len(rows)], 0.0)
    marks = _shades(cells, score)
    honest = {at for at, (_, ok) in cells.items() if ok}
    marks += [Line(floats(a), floats(b), "ink", 2.4) for a, b in _outline(honest)]
    panel = Panel(
        place,
        tuple(marks),
        y_label=y,
        x_limits=(-0.5, len(columns) - 0.5),
        y_limits=(-0.5, len(rows) - 0.5),
        ticks=tuple((float(k), str(value)) for k, value in enumerate(rows)),
        x_ticks=tuple((float(i), str(value)) for i, value in enumerate(columns)),
        x_label=x,
        linked=False,
    )
    subtitle = "outlined: honest at 95 %"
    if score in _HONEST_AT_ONE:
        subtitle += "; red: optimistic, blue: pessimistic"
    height = place.top + place.height + frame.bottom
    return Scene(frame.width, height, (panel,), f"{score} over {x} and {y}", subtitle)


def _values(result: SweepResult, name: str) -> list[Any]:
    return list(dict.fromkeys(settings[name] for settings in result.grid))


def _cells(
    result: SweepResult, x: str, y: str, score: str
) -> dict[tuple[int, int], tuple[float, bool]]:
    """For each column and row the score, and whether the filter is honest there."""
    columns, rows = _values(result, x), _values(result, y)
    table = result.to_columns("settings")
    others = [name for name in result.grid[0] if name not in (x, y)]
    first = {name: result.grid[0][name] for name in others}
    cells = {}
    for k, settings in enumerate(result.grid):
        if any(settings[name] != first[name] for name in others):
            continue
        low, high = (table.get(f"nees_{end}", [np.nan] * len(rows) * len(columns))[k]
                     for end in ("low", "high"))  # fmt: skip
        at = columns.index(settings[x]), rows.index(settings[y])
        cells[at] = (float(result.scores[score][k]), bool(low <= 1.0 <= high))
    return cells


def _shades(cells: dict[tuple[int, int], tuple[float, bool]], score: str) -> list[Mark]:
    """A box and its number for each cell.

    Darker is more; NEES and NIS are red above and blue below 1, the darker the farther.
    """
    values = floats([value for value, _ in cells.values()])
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.log(values) if score in _HONEST_AT_ONE else values - np.nanmin(values)
    deepest = np.max(np.abs(depths[np.isfinite(depths)]), initial=0.0) or 1.0
    marks: list[Mark] = []
    for ((i, k), (value, _)), depth in zip(cells.items(), depths, strict=True):
        colour = "high" if score in _HONEST_AT_ONE and depth > 0 else "low"
        share = float(min(abs(depth) / deepest, 1.0)) if not np.isnan(depth) else 0.0
        edges = (floats([i - 0.5]), floats([i + 0.5]), floats([k - 0.5]), floats([k + 0.5]))
        marks.append(Boxes(*edges, f"{colour}/{0.04 + 0.64 * share:.3f}", name=f"{value:.4g}"))
        marks.append(Text(float(i), float(k), f"{value:.3g}", "ink", anchor="center"))
    return marks


def _outline(cells: set[tuple[int, int]]) -> list[tuple[list[float], list[float]]]:
    """The edges between these cells and the others."""
    edges = []
    for i, k in sorted(cells):
        for di, dk in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            if (i + di, k + dk) not in cells:
                x, y = i + di / 2, k + dk / 2
                across, along = abs(dk) / 2, abs(di) / 2
                edges.append(([x - across, x + across], [y - along, y + along]))
    return edges
