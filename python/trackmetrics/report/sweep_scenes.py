"""Scene of a Monte Carlo sweep: ANEES of its settings over time, and RMSE by state."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics.monte_carlo import SweepResult
from trackmetrics.report.axes import linear_limits, log_limits, on_log_axis
from trackmetrics.report.layout import LEGEND_COLUMNS, Frame
from trackmetrics.report.scene import (
    Band,
    Bounds,
    Floats,
    HLine,
    Line,
    Panel,
    Primitive,
    Scene,
    floats,
)
from trackmetrics.report.theme import DASHES, TRACK_COLOURS


def sweep_scene(
    result: SweepResult,
    states: Sequence[str] | None = None,
    step: float | None = None,
    settings: Sequence[int] | None = None,
) -> Scene:
    """The panels of :func:`sweep_figure`."""
    frame = Frame()
    drawn = _nearest_to_consistent(result) if settings is None else list(settings)
    if not drawn or not all(0 <= i < len(result.grid) for i in drawn):
        raise ValueError(f"settings must be of the {len(result.grid)} of the grid, got {drawn}")
    n = result.rmse.shape[2]
    names = list(states) if states is not None else [f"state {j}" for j in range(n)]
    if len(names) != n:
        raise ValueError(f"states has {len(names)} names, the filter has {n}")
    top, lower = frame.rows(_title_height(len(drawn)), [250.0, 210.0], 72.0)
    time = floats(np.arange(result.rmse.shape[1]) * (1.0 if step is None else step))
    axis = "step" if step is None else "time (s)"
    panels = [_anees_panel(result, drawn, settings is None, time, axis, top)]
    columns = frame.columns(lower.top, lower.height, n)
    panels += [
        _rmse_panel(result, drawn, j, name, time, axis, bounds)
        for j, (name, bounds) in enumerate(zip(names, columns, strict=True))
    ]
    subtitle = f"{result.runs} runs of each setting; bands are 95 % intervals"
    height = lower.top + lower.height + frame.bottom
    return Scene(
        frame.width, height, tuple(panels), "Consistency and accuracy by setting", subtitle
    )


def _nearest_to_consistent(result: SweepResult) -> list[int]:
    """As many settings as there are colours, in the order of the grid."""
    if len(result.grid) <= TRACK_COLOURS:
        return list(range(len(result.grid)))
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.abs(np.log(np.nanmean(result.anees, axis=1)))
    return sorted(np.argsort(distance, kind="stable")[:TRACK_COLOURS].tolist())


def _title_height(settings: int) -> float:
    """Pixels above the panels: the title, and the rows of the legend on its right."""
    return max(92.0, 40.0 + 18.0 * math.ceil(settings / LEGEND_COLUMNS))


def _anees_panel(
    result: SweepResult,
    drawn: list[int],
    nearest: bool,
    time: Floats,
    axis: str,
    bounds: Bounds,
) -> Panel:
    limits = log_limits([result.anees[drawn].ravel(), np.ravel(result.anees_interval)])
    primitives: list[Primitive] = []
    for low, high in np.atleast_2d(result.anees_interval)[:1]:
        primitives.append(HLine(float(low), "consistent/0.25", top=float(high)))
    primitives.append(HLine(1.0, "muted/0.8"))
    some = ""
    if len(drawn) < len(result.grid):
        some = f", {len(drawn)} of {len(result.grid)} settings" + ", the nearest" * nearest
    for k, i in enumerate(drawn):
        y = on_log_axis(result.anees[i], limits)
        primitives.append(Line(time, y, *_style(k), name=label(result.grid[i])))
    return Panel(
        bounds,
        tuple(primitives),
        title=f"ANEES / states{some}; shaded: 95 % interval if consistent",
        x_label=axis,
        y_label="ANEES",
        log=True,
        x_limits=_ends(time),
        y_limits=limits,
        legend=True,
    )


def _rmse_panel(
    result: SweepResult,
    drawn: list[int],
    j: int,
    name: str,
    time: Floats,
    axis: str,
    bounds: Bounds,
) -> Panel:
    primitives: list[Primitive] = []
    for k, i in enumerate(drawn):
        colour, width, dash = _style(k)
        low, high = result.rmse_interval[i, :, j].T
        primitives.append(Band(time, low, high, f"{colour}/0.15"))
        line = Line(time, result.rmse[i, :, j], colour, width, dash, name=label(result.grid[i]))
        primitives.append(line)
    return Panel(
        bounds,
        tuple(primitives),
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
    """A setting as text."""
    return ", ".join(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
                     for name, value in settings.items()) or "the filter"  # fmt: skip
