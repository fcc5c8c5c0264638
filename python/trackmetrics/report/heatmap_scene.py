"""Scene of a score of a Monte Carlo sweep over two parameters of its grid."""

from typing import Any

import numpy as np

from trackmetrics.monte_carlo import SweepResult
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import Line, Panel, Primitive, Rects, Scene, Text, floats

CONSISTENT_AT_ONE = ("nees", "nis")
"""Scores whose expectation is 1 for a consistent filter."""


def heatmap_scene(result: SweepResult, x: str, y: str, score: str) -> Scene:
    """The panel of :func:`heatmap_figure`."""
    for name in (x, y):
        if name not in result.grid[0]:
            raise ValueError(f"the grid has no {name!r}, it has {', '.join(result.grid[0])}")
    if score not in result.scores:
        raise ValueError(f"there is no score {score!r}, there are {', '.join(result.scores)}")
    columns, rows = _values(result, x), _values(result, y)
    cells = _cells(result, x, y, score)
    frame = Frame(width=240.0 + 90.0 * len(columns), left=110.0)
    (bounds,) = frame.rows(64.0, [60.0 * len(rows)], 0.0)
    primitives = _coloured_cells(cells, score)
    consistent = {at for at, (_, ok) in cells.items() if ok}
    primitives += [Line(floats(a), floats(b), "ink", 2.4) for a, b in _outline(consistent)]
    panel = Panel(
        bounds,
        tuple(primitives),
        y_label=y,
        x_limits=(-0.5, len(columns) - 0.5),
        y_limits=(-0.5, len(rows) - 0.5),
        ticks=tuple((float(k), str(value)) for k, value in enumerate(rows)),
        x_ticks=tuple((float(i), str(value)) for i, value in enumerate(columns)),
        x_label=x,
        linked=False,
    )
    subtitle = "outlined: consistent at 95 %"
    if score in CONSISTENT_AT_ONE:
        subtitle += "; red: optimistic, blue: pessimistic"
    height = bounds.top + bounds.height + frame.bottom
    return Scene(frame.width, height, (panel,), f"{score} over {x} and {y}", subtitle)


def _values(result: SweepResult, name: str) -> list[Any]:
    return list(dict.fromkeys(settings[name] for settings in result.grid))


def _cells(
    result: SweepResult, x: str, y: str, score: str
) -> dict[tuple[int, int], tuple[float, bool]]:
    """For each column and row the score, and whether the filter is consistent there."""
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


def _coloured_cells(
    cells: dict[tuple[int, int], tuple[float, bool]], score: str
) -> list[Primitive]:
    """A box and its number for each cell.

    Darker is more; NEES and NIS are red above and blue below 1, the darker the farther.
    """
    values = floats([value for value, _ in cells.values()])
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.log(values) if score in CONSISTENT_AT_ONE else values - np.nanmin(values)
    deepest = np.max(np.abs(depths[np.isfinite(depths)]), initial=0.0) or 1.0
    primitives: list[Primitive] = []
    for ((i, k), (value, _)), depth in zip(cells.items(), depths, strict=True):
        colour = "high" if score in CONSISTENT_AT_ONE and depth > 0 else "low"
        share = float(min(abs(depth) / deepest, 1.0)) if not np.isnan(depth) else 0.0
        edges = (floats([i - 0.5]), floats([i + 0.5]), floats([k - 0.5]), floats([k + 0.5]))
        primitives.append(Rects(*edges, f"{colour}/{0.04 + 0.64 * share:.3f}", name=f"{value:.4g}"))
        primitives.append(Text(float(i), float(k), f"{value:.3g}", "ink", anchor="center"))
    return primitives


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
