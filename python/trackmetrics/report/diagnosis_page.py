"""One self-contained HTML page about a diagnosis.

The HTML comes from ``templates/``. Plotly and the figures travel compressed inside it and are
unpacked by the browser when they are looked at, so that a hundred tracks are a few megabytes.
"""

import base64
import gzip
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._format import number, p_value
from trackmetrics.diagnostics import Diagnosis
from trackmetrics.logs import EstimatorLog
from trackmetrics.report import draw_plotly, theme
from trackmetrics.report.comparison_scene import comparison_scene
from trackmetrics.report.holdout_section import predictions
from trackmetrics.report.page_tables import first_event, timeline_bars, track_tables, update_table
from trackmetrics.report.templates import environment
from trackmetrics.report.track_scene import track_scene
from trackmetrics.report.track_view import TrackView, track_views
from trackmetrics.vessel import HeldOut

SHOWN = theme.TRACK_COLOURS
"""Number of tracks that the comparison shows at first, the most severe ones."""


def render_page(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Estimator diagnosis",
    held_out: Mapping[str, HeldOut] | None = None,
) -> str:
    """The diagnosis as one HTML file: overview, comparison, and each track in full.

    The overview lists the tracks, the most severe first, with their verdicts, onset times, the
    weakest state and a summary; tracks can be switched off, sorted and searched. The
    figures are interactive and drawn when they are opened. The page follows the system's light or
    dark theme and has a switch; it needs no network.

    Parameters
    ----------
    diagnosis
        The result of :func:`trackmetrics.diagnostics.diagnose`.
    log
        The log it was made from; None shows the segments without the updates.
    title
        Heading of the page.
    held_out
        The result of :func:`trackmetrics.vessel.predictive_nis`: adds a section about the reports
        that the filter was not given.

    Returns
    -------
    str
        The page. Of its size, about two megabytes are plotly.
    """
    from plotly.offline import get_plotlyjs

    views = track_views(diagnosis, log)
    env = environment()
    env.globals.update(
        verdict_label=theme.verdict_label,
        verdict_symbol=theme.verdict_symbol,
        role=theme.verdict_role,
    )
    env.filters.update(number=number, p=p_value)
    plotly, compared = get_plotlyjs(), draw_plotly.figure(comparison_scene(views))
    html: str = env.get_template("page.html").render(
        title=title,
        warnings=diagnosis.warnings,
        counts=_counts(views),
        tracks=[_track(i, view, compared) for i, view in enumerate(views)],
        predictions=predictions(views, held_out),
        themes=theme.THEMES,
        shown=SHOWN,
        comparison=_packed({**compared, "data": []}),
        plotly=_compressed(plotly),
        plotly_licence=plotly[: plotly.index("*/")].removeprefix("/**").strip(),
        clock=views[0].clock.label if views else "minutes since start",
    )
    return html


def write_page(
    path: str | Path,
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Estimator diagnosis",
    held_out: Mapping[str, HeldOut] | None = None,
) -> None:
    """Write :func:`render_page` to a file."""
    html = render_page(diagnosis, log, title=title, held_out=held_out)
    Path(path).write_text(html, encoding="utf-8")


def _counts(views: list[TrackView]) -> dict[str, int]:
    """The number of tracks with each verdict, the most severe first."""
    counts: dict[str, int] = {}
    for view in views:
        counts[view.track.verdict] = counts.get(view.track.verdict, 0) + 1
    return counts


def _track(index: int, view: TrackView, compared: dict[str, Any]) -> dict[str, Any]:
    """The content of the template and of the browser for one track."""
    name = draw_plotly.literal(view.track.track)
    own = [trace for trace in compared["data"] if trace["name"] == name]
    figures = {
        "comparison": [{**trace, "showlegend": False} for trace in own],
        "track": draw_plotly.figure(track_scene(view, titled=False)),
        "updates": update_table(view),
    }
    return {
        "index": index,
        "on": index < SHOWN,
        "diagnosis": view.track,
        "style": view.style,
        "since": first_event(view),
        "bars": timeline_bars(view),
        "tables": track_tables(view),
        "data": _packed(figures),
    }


def _packed(content: Any) -> str:
    return _compressed(json.dumps(content, separators=(",", ":"), allow_nan=False))


def _compressed(text: str) -> str:
    """The text as the browser unpacks it; the same text gives the same bytes."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()
