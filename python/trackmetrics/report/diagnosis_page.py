"""One self-contained page about a diagnosis: no network, no second file.

The HTML comes from ``templates/``. Plotly and the figures travel compressed inside it and are
unpacked by the browser when they are looked at, so that a hundred tracks are a few megabytes.
"""

import base64
import gzip
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics.diagnostics import Diagnosis, EstimatorLog
from trackmetrics.report import draw_plotly, theme
from trackmetrics.report.holdout_section import predictions
from trackmetrics.report.overview_scene import comparison_scene
from trackmetrics.report.page_tables import lanes, moments, track_tables, update_table
from trackmetrics.report.track_scene import track_scene
from trackmetrics.report.track_view import Subject, subjects
from trackmetrics.vessel import HeldOut

SHOWN = theme.TRACK_COLOURS
"""How many tracks the comparison shows at first, the most severe ones."""


def page(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Estimator diagnosis",
    held_out: Mapping[str, HeldOut] | None = None,
) -> str:
    """The diagnosis as one HTML file: overview, comparison, and each track in full.

    The overview lists the tracks, the most severe first, with their verdicts, since when, the
    weakest state and the paragraph in words; tracks can be switched off, sorted and searched. The
    figures are interactive and drawn when they are opened. The page follows the system's light or
    dark theme and has a switch; it needs no network.

    Parameters
    ----------
    diagnosis
        What :func:`trackmetrics.diagnostics.diagnose` found.
    log
        The log it was made from; None shows the segments without the updates.
    title
        Heading of the page.
    held_out
        What :func:`trackmetrics.vessel.predictive_nis` found: makes a section about the reports
        that the filter was not given.

    Returns
    -------
    str
        The page. Of its size, some two megabytes are plotly.
    """
    import jinja2
    from plotly.offline import get_plotlyjs

    every = subjects(diagnosis, log)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("trackmetrics.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.globals.update(words=theme.words, glyph=theme.glyph, role=theme.verdict_role)
    environment.filters.update(number=number, p=_p_value)
    plotly, compared = get_plotlyjs(), draw_plotly.figure(comparison_scene(every))
    return environment.get_template("page.html").render(
        title=title,
        warnings=diagnosis.warnings,
        counts=_counts(every),
        tracks=[_track(i, subject, compared) for i, subject in enumerate(every)],
        predictions=predictions(every, held_out),
        themes=theme.THEMES,
        shown=SHOWN,
        comparison=_packed({**compared, "data": []}),
        plotly=_compressed(plotly),
        plotly_licence=plotly[: plotly.index("*/")].removeprefix("/**").strip(),
        clock=every[0].clock.label if every else "minutes since start",
    )


def write_page(
    path: str | Path,
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Estimator diagnosis",
    held_out: Mapping[str, HeldOut] | None = None,
) -> None:
    """Write :func:`page` to a file."""
    html = page(diagnosis, log, title=title, held_out=held_out)
    Path(path).write_text(html, encoding="utf-8")


def number(value: float | None, digits: int = 3) -> str:
    """A number in a table; a dash where there is none."""
    if value is None or math.isnan(value):
        return "–"
    return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"


def _p_value(value: float) -> str:
    return number(value, 2) if value > 0 else "< 1e-300"


def _counts(every: list[Subject]) -> dict[str, int]:
    """How many tracks have each verdict, the most severe first."""
    counts: dict[str, int] = {}
    for subject in every:
        counts[subject.track.verdict] = counts.get(subject.track.verdict, 0) + 1
    return counts


def _track(index: int, subject: Subject, compared: dict[str, Any]) -> dict[str, Any]:
    """What the template and the browser need of one track."""
    name = draw_plotly.literal(subject.track.track)
    own = [trace for trace in compared["data"] if trace["name"] == name]
    figures = {
        "comparison": [{**trace, "showlegend": False} for trace in own],
        "sheet": draw_plotly.figure(track_scene(subject, titled=False)),
        "updates": update_table(subject),
    }
    return {
        "index": index,
        "on": index < SHOWN,
        "diagnosis": subject.track,
        "style": subject.style,
        "since": moments(subject),
        "lanes": lanes(subject),
        "tables": track_tables(subject),
        "data": _packed(figures),
    }


def _packed(content: Any) -> str:
    return _compressed(json.dumps(content, separators=(",", ":"), allow_nan=False))


def _compressed(text: str) -> str:
    """Text as the browser unpacks it; the same text gives the same bytes."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()
