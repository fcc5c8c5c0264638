"""Figures of a diagnosis: one track in full, an overview of all tracks, a comparison."""

from typing import Any

from trackmetrics.diagnostics import Diagnosis
from trackmetrics.logs import EstimatorLog
from trackmetrics.report.draw import Backend, draw


def track_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None,
    track: str,
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """One track in full: its NIS, NEES, measurements and states.

    NIS and NEES are drawn per degree of freedom on logarithmic axes, with the 95 % chi-square
    interval of each update and the mean of each segment in the colour of its label.
    Below, one row per state: measured, estimated and true value with plus or minus two standard
    deviations of the covariance; the standard deviation over its reference; the error over the
    standard deviation. A panel is left out if the log lacks its columns.

    Parameters
    ----------
    diagnosis
        The result of :func:`trackmetrics.diagnostics.diagnose`.
    log
        The log it was made from; None draws only the segments.
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
    from trackmetrics.report.track_view import track_views

    name = diagnosis[track].track
    chosen = next(s for s in track_views(diagnosis, log) if s.track.track == name)
    return draw(track_scene(chosen), backend, dark)


def overview_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Consistency of all tracks over time",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """All tracks, the most severe at the top: one row each with its segments, onset and alarm.

    The upper half of a row is the NIS, the lower half the NEES. The parameters are those of
    :func:`track_figure`.
    """
    from trackmetrics.report.overview_scene import overview_scene
    from trackmetrics.report.track_view import track_views

    return draw(overview_scene(track_views(diagnosis, log), title), backend, dark)


def comparison_figure(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """NIS and NEES of the eight most severe tracks in the same axes, each in its colour.

    The parameters are those of :func:`track_figure`.
    """
    from trackmetrics.report.comparison_scene import comparison_scene
    from trackmetrics.report.theme import TRACK_COLOURS
    from trackmetrics.report.track_view import track_views

    every = track_views(diagnosis, log)
    return draw(comparison_scene(every, every[:TRACK_COLOURS]), backend, dark)
