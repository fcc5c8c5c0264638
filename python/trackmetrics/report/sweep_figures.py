"""Figures of a Monte Carlo sweep: consistency and accuracy over time, a score over two settings."""

from collections.abc import Sequence
from typing import Any

from trackmetrics.monte_carlo import SweepResult
from trackmetrics.report.draw import Backend, draw
from trackmetrics.report.heatmap_scene import heatmap_scene
from trackmetrics.report.sweep_scenes import sweep_scene


def sweep_figure(
    result: SweepResult,
    *,
    states: Sequence[str] | None = None,
    step: float | None = None,
    settings: Sequence[int] | None = None,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """ANEES of every setting over time with its acceptance interval; below, RMSE by state.

    Parameters
    ----------
    result
        The result of :func:`trackmetrics.monte_carlo.sweep`.
    states
        Names of the states, with their units.
    step
        Seconds from one step to the next; None counts steps.
    settings
        Places in ``result.grid`` of what is drawn; at most eight by default, those whose mean NEES
        is nearest to 1.
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


def heatmap_figure(
    result: SweepResult,
    x: str,
    y: str,
    score: str = "nees",
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """A score over two parameters, as a heat map.

    Settings are outlined if the 95 % interval of their mean NEES per state contains 1.

    Parameters
    ----------
    result
        The result of :func:`trackmetrics.monte_carlo.sweep`.
    x, y
        The parameters; where the grid has others too, the first value of each is drawn.
    score
        Which of ``result.scores``; darker is more. NEES and NIS are red where they are above 1,
        blue below.
    backend, dark
        As for :func:`sweep_figure`.
    """
    return draw(heatmap_scene(result, x, y, score), backend, dark)
