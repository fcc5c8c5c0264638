"""Figures of a diagnosis: one track in full, or all of them at a glance."""

from typing import Any, Literal

from trackmetrics.diagnostics import Diagnosis, EstimatorLog
from trackmetrics.report.scene import Scene
from trackmetrics.report.theme import theme

Backend = Literal["matplotlib", "plotly"]


def track_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None,
    track: str,
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """One track in full: NIS, NEES, its support, and each state's value, claim and error.

    NIS and NEES stand per degree of freedom on logarithmic axes, with the 95 % chi-square interval
    of each point's own degrees of freedom and the mean of each segment in the colour of its label.
    Below, one row a state: measured, estimated and true value with plus or minus two claimed
    standard deviations; the claim over its reference; the error over the claim.

    Parameters
    ----------
    diagnosis
        What :func:`trackmetrics.diagnostics.diagnose` found.
    log
        The log it was made from; None draws the segments alone.
    track
        The name of the track.
    backend
        ``"matplotlib"`` or ``"plotly"``.
    dark
        Whether the figure is for a dark page.

    Returns
    -------
    matplotlib.figure.Figure or plotly.graph_objects.Figure
        Time is in minutes since the first update of the log.

    Raises
    ------
    KeyError
        If there is no such track.
    """
    from trackmetrics.report.track_scene import track_scene
    from trackmetrics.report.track_view import subjects

    name = diagnosis[track].track
    chosen = next(s for s in subjects(diagnosis, log) if s.track.track == name)
    return draw(track_scene(chosen), backend, dark)


def overview_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Is the filter honest, and since when?",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """All tracks, the most severe on top: one lane each with its segments, onset and alarm.

    The upper half of a lane is the NIS, the lower half the NEES. The parameters are those of
    :func:`track_figure`.
    """
    from trackmetrics.report.overview_scene import lanes_scene
    from trackmetrics.report.track_view import subjects

    return draw(lanes_scene(subjects(diagnosis, log), title), backend, dark)


def comparison_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """NIS and NEES of the eight most severe tracks over each other, each in its colour.

    The parameters are those of :func:`track_figure`.
    """
    from trackmetrics.report.overview_scene import comparison_scene
    from trackmetrics.report.theme import TRACK_COLOURS
    from trackmetrics.report.track_view import subjects

    every = subjects(diagnosis, log)
    return draw(comparison_scene(every, every[:TRACK_COLOURS]), backend, dark)


def draw(scene: Scene, backend: str, dark: bool) -> Any:
    """The scene as a figure of one of the two libraries."""
    if backend == "matplotlib":
        from trackmetrics.report import draw_matplotlib

        return draw_matplotlib.draw(scene, theme(dark))
    if backend == "plotly":
        from trackmetrics.report import draw_plotly

        return draw_plotly.draw(scene, theme(dark))
    raise ValueError(f"backend must be 'matplotlib' or 'plotly', got {backend!r}")
