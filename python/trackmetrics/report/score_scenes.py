"""Scenes of scores: distances over time, RMSE over runs, coverage of credibility regions."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics.logs import State
from trackmetrics.report.axes import TimeAxis, linear_limits
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Band,
    Floats,
    Line,
    Panel,
    Primitive,
    Scene,
    Text,
    floats,
)

TITLE_HEIGHT = 92.0
PARTS = ("track-0", "track-1", "track-2")


def ospa_scene(results: Any, times: Any, unit: str, title: str) -> Scene:
    """The distance, and below it its two parts."""
    columns = [floats([getattr(r, name) for r in results]) for name in _OSPA]
    axis = TimeAxis(times, len(columns[0]), "frame")
    lines = [
        Line(axis.x, values, role, 1.8, name=name)
        for name, values, role in zip(_OSPA[1:], columns[1:], PARTS[1:], strict=True)
    ]
    return _over_time(axis, columns[0], lines, title, ("OSPA", unit, unit))


_OSPA = ("ospa", "localization", "cardinality")
_POWERS = {1.0: "", 2.0: "²", 3.0: "³"}
_GOSPA = ("localization", "missed", "false")


def gospa_scene(results: Any, times: Any, unit: str, p: float, title: str) -> Scene:
    """The distance, and below it its three parts on each other: they add up to its power."""
    distance, *parts = (_column(results, name) for name in ("distance", *_GOSPA))
    axis = TimeAxis(times, len(distance), "frame")
    power = f"{unit}{_POWERS.get(p, f'^{p:g}')}"
    bands: list[Primitive] = []
    below = np.zeros_like(distance)
    for name, part, role in zip(_GOSPA, parts, PARTS, strict=True):
        bands.append(Band(axis.x, below, below + part, f"{role}/0.6", name))
        below = below + part
    return _over_time(axis, distance, bands, title, ("GOSPA", unit, power))


def _column(results: Any, name: str) -> Floats:
    """A field of a sequence's result, or of each of a sequence of results."""
    if hasattr(results, name):
        return np.atleast_1d(np.asarray(getattr(results, name), np.float64))
    return floats([getattr(result, name) for result in results])


def _over_time(
    axis: TimeAxis,
    distance: Floats,
    parts: Sequence[Primitive],
    title: str,
    labels: tuple[str, str, str],
) -> Scene:
    name, unit, part_unit = labels
    frame = Frame()
    above, below = frame.rows(TITLE_HEIGHT, (230.0, 200.0), 46.0)
    heights = [side for m in parts if isinstance(m, Band) for side in (m.low, m.high)]
    heights += [m.y for m in parts if isinstance(m, Line)]
    panels = (
        axis.panel(
            above,
            [Line(axis.x, distance, "ink", 2.0, name=name)],
            linear_limits([distance], (0.0, 0.0)),
            title=f"{name} distance: 0 is best",
            y_label=f"{name} ({unit})",
        ),
        axis.panel(
            below,
            parts,
            linear_limits(heights, (0.0, 0.0)),
            title="Components",
            y_label=f"parts ({part_unit})",
            x_label=axis.label,
            legend=True,
        ),
    )
    mean = f"{len(distance)} frames"
    return Scene(frame.width, below.top + below.height + frame.bottom, panels, title, mean)


def rmse_scene(statistics: Any, times: Any, states: Sequence[State], title: str) -> Scene:
    """RMSE of each state over the runs, with its interval."""
    rmse = np.asarray(statistics.rmse, np.float64)
    interval = np.asarray(statistics.rmse_interval, np.float64)
    if len(states) != rmse.shape[1]:
        raise ValueError(f"states has {len(states)} names, the RMSE has {rmse.shape[1]} components")
    axis, frame = TimeAxis(times, len(rmse), "step"), Frame(left=84.0)
    all_bounds = frame.rows(TITLE_HEIGHT, [130.0] * len(states), 38.0)
    panels = []
    for j, (state, bounds) in enumerate(zip(states, all_bounds, strict=True)):
        low, high = interval[:, j, 0], interval[:, j, 1]
        share = f"{100 * statistics.confidence:g} % interval"
        primitives = (
            Band(axis.x, low, high, "track-0/0.22", share),
            Line(axis.x, rmse[:, j], "track-0", 1.8, name="RMSE"),
        )
        label = f"{state.name} ({state.unit})" if state.unit else state.name
        x_label = axis.label if j == len(states) - 1 else ""
        limits = linear_limits([low, high, rmse[:, j]], (0.0, 0.0))
        title_of = f"{state.name}: RMSE over the runs"
        panels.append(
            axis.panel(
                bounds,
                primitives,
                limits,
                title=title_of,
                y_label=label,
                x_label=x_label,
                legend=j == 0,
            )
        )
    bottom = all_bounds[-1].top + all_bounds[-1].height + frame.bottom
    runs = int(np.max(statistics.runs, initial=0))
    return Scene(frame.width, bottom, tuple(panels), title, f"{runs} runs")


def coverage_scene(coverage: Any, title: str) -> Scene:
    """Observed against nominal coverage of credibility regions; the diagonal is consistent."""
    nominal, observed = floats(coverage.probability), floats(coverage.share)
    frame = Frame(width=620.0, left=76.0, right=30.0)
    bounds = frame.rows(TITLE_HEIGHT + 10, [514.0], 0.0)[0]
    ends = floats([0.0, 1.0])
    primitives = (
        Band(nominal, floats(coverage.lower), floats(coverage.upper), "track-0/0.22", "interval"),
        Line(ends, ends, "muted", 1.2, "dash", "consistent"),
        Line(nominal, observed, "track-0", 2.2, name="observed"),
        Text(0.03, 0.95, "above the diagonal: pessimistic", "muted"),
        Text(0.97, 0.05, "below the diagonal: optimistic", "muted", "right"),
    )
    panel = Panel(
        bounds,
        primitives,
        x_label="nominal probability",
        y_label="fraction of errors inside",
        x_limits=(-0.02, 1.02),
        y_limits=(-0.02, 1.02),
        x_unit="",
        legend=True,
    )
    count = int(np.max(coverage.count, initial=0))
    height = bounds.top + bounds.height + frame.bottom
    return Scene(frame.width, height, (panel,), title, f"{count} errors")
