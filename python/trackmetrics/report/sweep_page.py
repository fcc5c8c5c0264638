"""A sweep as one self-contained HTML page: its figures for both themes, and its table."""

import base64
import io
import os
from pathlib import Path
from typing import Any

from trackmetrics._format import number
from trackmetrics.monte_carlo import BestSetting, SweepResult
from trackmetrics.report.draw import draw
from trackmetrics.report.heatmap_scene import heatmap_scene
from trackmetrics.report.scene import Scene
from trackmetrics.report.sweep_scenes import label, sweep_scene
from trackmetrics.report.templates import environment
from trackmetrics.report.theme import DARK, LIGHT, Theme

_PAGE_COLOURS = ("page", "surface", "ink", "muted", "grid")


def write_sweep_page(
    path: str | os.PathLike[str],
    result: SweepResult,
    *,
    title: str = "Monte Carlo sweep",
    best: BestSetting | None = None,
) -> None:
    """Write :func:`render_sweep_page` to a file."""
    html = render_sweep_page(result, title=title, best=best)
    Path(path).write_text(html, encoding="utf-8")


def render_sweep_page(
    result: SweepResult, *, title: str = "Monte Carlo sweep", best: BestSetting | None = None
) -> str:
    """The figures and the table of a sweep as one HTML page that needs no network.

    Parameters
    ----------
    result
        The result of :func:`trackmetrics.monte_carlo.sweep`. ANEES and RMSE over time are drawn if
        its runs gave truth; a heat map of the first score is drawn over the first two parameters
        of the grid that vary.
    title
        Heading of the page.
    best
        The best setting, from ``result.best()``; it is described and marked in the table.

    Returns
    -------
    str
        The page.
    """
    html: str = (
        environment()
        .get_template("sweep.html")
        .render(
            title=title,
            summary=_summary(result),
            best=None if best is None else _description(best),
            light=_variables(LIGHT),
            dark=_variables(DARK),
            figures=[_picture(scene) for scene in _scenes(result)],
            table=_table(result, None if best is None else best.index),
        )
    )
    return html


def _scenes(result: SweepResult) -> list[Scene]:
    scenes = [sweep_scene(result)] if "nees" in result.scores else []
    varying = [name for name in result.grid[0] if len({repr(s[name]) for s in result.grid}) > 1]
    if len(varying) > 1 and result.scores:
        scenes.append(heatmap_scene(result, varying[0], varying[1], next(iter(result.scores))))
    return scenes


def _summary(result: SweepResult) -> str:
    failed = len(result.failures)
    text = f"{result.runs} runs of {len(result.grid)} settings, seed {result.seed}"
    return f"{text}; {failed} runs failed" if failed else text


def _description(best: BestSetting) -> dict[str, str]:
    return {"name": label(best.settings), "description": "; ".join(best.describe())}


def _variables(theme: Theme) -> str:
    return " ".join(f"--{name}: {theme.colours[name]};" for name in _PAGE_COLOURS)


def _picture(scene: Scene) -> dict[str, str]:
    light, dark = (_data_url(draw(scene, "matplotlib", dark)) for dark in (False, True))
    return {"title": scene.title, "light": light, "dark": dark}


def _data_url(figure: Any) -> str:
    """The figure as SVG in a data URL."""
    file = io.BytesIO()
    figure.savefig(file, format="svg", metadata={"Date": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(file.getvalue()).decode()}"


def _table(result: SweepResult, best: int | None) -> dict[str, Any]:
    """A row for each setting, scores with their intervals; the best setting is marked."""
    columns = result.to_columns("settings")
    names = ["runs", "failed", *result.scores]
    rows = [
        {
            "name": label(settings),
            "best": k == best,
            "cells": [_cell(columns, name, k) for name in names],
        }
        for k, settings in enumerate(result.grid)
    ]
    return {"head": ["setting", *names], "rows": rows}


def _cell(columns: dict[str, Any], name: str, k: int) -> dict[str, str]:
    value = number(columns[name][k], 4)
    if f"{name}_low" not in columns:
        return {"value": value, "interval": ""}
    low, high = columns[f"{name}_low"][k], columns[f"{name}_high"][k]
    return {"value": value, "interval": f"{number(low, 4)} … {number(high, 4)}"}
