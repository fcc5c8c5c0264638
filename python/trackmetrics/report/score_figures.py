"""Figures of scores: OSPA and GOSPA over time, RMSE over runs, coverage of regions."""

from collections.abc import Sequence
from typing import Any

from trackmetrics.logs import State
from trackmetrics.report.draw import Backend, draw


def ospa_figure(
    results: Sequence[Any],
    *,
    times: Any = None,
    unit: str = "m",
    title: str = "OSPA over time",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """OSPA over time, and below it its localisation and cardinality parts.

    Parameters
    ----------
    results
        One :class:`trackmetrics.OSPAResult` a frame.
    times
        Times of the steps in seconds; without them the axis counts steps.
    unit
        Unit of the points.
    title, backend, dark
        Heading; ``"matplotlib"`` or ``"plotly"``; whether for a dark page.

    Returns
    -------
    matplotlib.figure.Figure or plotly.graph_objects.Figure
        The figure.

    Examples
    --------
    >>> from trackmetrics import ospa
    >>> results = [ospa([[0.0, 0.0]], [[0.1 * k, 0.0]], c=10, p=2) for k in range(5)]
    >>> figure = ospa_figure(results, times=[0, 60, 120, 180, 240])
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['OSPA (m)', 'parts (m)']
    """
    from trackmetrics.report.score_scenes import ospa_scene

    return draw(ospa_scene(results, times, unit, title), backend, dark)


def gospa_figure(
    results: Any,
    *,
    times: Any = None,
    unit: str = "m",
    p: float = 2.0,
    title: str = "GOSPA over time",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """GOSPA over time, and below it its parts on each other: they add up to ``distance ** p``.

    ``results`` is the result of a sequence, or one result a frame, with the fields
    ``distance``, ``localization``, ``missed`` and ``false``, computed with this ``p`` and
    ``alpha = 2``. The other parameters are those of :func:`ospa_figure`.
    """
    from trackmetrics.report.score_scenes import gospa_scene

    return draw(gospa_scene(results, times, unit, p, title), backend, dark)


def rmse_figure(
    statistics: Any,
    *,
    states: Sequence[State | str],
    times: Any = None,
    title: str = "RMSE over the runs",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """RMSE of each state over Monte Carlo runs, with its interval at each step.

    Parameters
    ----------
    statistics
        Statistics over runs: fields ``rmse`` of shape (steps, n), ``rmse_interval`` (steps, n, 2),
        ``runs`` (steps,) and ``confidence``.
    states
        The states, as names or :class:`trackmetrics.diagnostics.State` with their units.
    times, title, backend, dark
        As in :func:`ospa_figure`.

    Returns
    -------
    matplotlib.figure.Figure or plotly.graph_objects.Figure
        One panel a state.

    Raises
    ------
    ValueError
        If there are not as many states as components, or not as many times as steps.
    """
    from trackmetrics.report.score_scenes import rmse_scene

    named = [State(state) if isinstance(state, str) else state for state in states]
    return draw(rmse_scene(statistics, times, named, title), backend, dark)


def coverage_figure(
    coverage: Any,
    *,
    title: str = "Coverage of credibility regions",
    backend: Backend = "matplotlib",
    dark: bool = False,
) -> Any:
    """The coverage curve: the fraction of errors inside each region against its probability.

    ``coverage`` has the fields ``probability``, ``share``, ``lower``, ``upper`` and ``count``. A
    curve below the diagonal means an optimistic filter. The other parameters are those of
    :func:`ospa_figure`.
    """
    from trackmetrics.report.score_scenes import coverage_scene

    return draw(coverage_scene(coverage, title), backend, dark)
