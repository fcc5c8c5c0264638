"""One self-contained HTML page about a diagnosis.

The HTML comes from ``templates/``. Plotly, the figures and the tables of the tracks are compressed
inside it; the browser unpacks and builds them when a track is opened.
"""

import base64
import gc
import gzip
import json
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from trackmetrics._format import number, p_value
from trackmetrics._progress import with_progress
from trackmetrics.diagnostics import Diagnosis
from trackmetrics.logs import EstimatorLog
from trackmetrics.report import draw_plotly, theme
from trackmetrics.report.comparison_scene import Comparison
from trackmetrics.report.holdout_section import predictions
from trackmetrics.report.packing import FORMS, PackedArrays
from trackmetrics.report.page_tables import (
    first_event,
    quantity_verdicts,
    timeline_bars,
    track_tables,
    update_table,
)
from trackmetrics.report.templates import environment
from trackmetrics.report.track_scene import track_scene
from trackmetrics.report.track_view import TrackView, track_views
from trackmetrics.vessel import HeldOutResult

SHOWN = theme.TRACK_COLOURS
"""Number of tracks that the comparison shows at first, the most severe ones."""
MAX_PLAIN_ROWS = 200
"""The overview of more tracks than this is compressed, too, and needs JavaScript."""
BLOCK = 40
"""Number of tracks whose figures are compressed together and unpacked at once."""


def render_page(
    diagnosis: Diagnosis,
    log: EstimatorLog | None = None,
    *,
    title: str = "Estimator diagnosis",
    held_out: Mapping[str, HeldOutResult] | None = None,
    progress: bool = False,
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
    progress
        Whether a bar on standard error counts the tracks, if this takes longer than a second
        (needs the extra ``progress``).

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
    plotly, comparison = get_plotlyjs(), Comparison(views)
    tracks = [_row(i, view) for i, view in enumerate(views)]
    rows = ""
    if len(views) > MAX_PLAIN_ROWS:
        rows = _compressed(env.get_template("rows.html").render(tracks=tracks).encode())
    html: str = env.get_template("page.html").render(
        title=title,
        warnings=diagnosis.warnings,
        counts=_counts(views),
        tracks=tracks,
        rows=rows,
        predictions=predictions(views, held_out),
        themes=theme.THEMES,
        shown=SHOWN,
        block_size=BLOCK,
        forms=FORMS,
        blocks=_blocks(views, comparison, progress),
        comparison=_compressed(_json(draw_plotly.figure(comparison.scene(()))).encode()),
        plotly=_compressed(plotly.encode()),
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
    held_out: Mapping[str, HeldOutResult] | None = None,
    progress: bool = False,
) -> None:
    """Write :func:`render_page` to a file."""
    html = render_page(diagnosis, log, title=title, held_out=held_out, progress=progress)
    Path(path).write_text(html, encoding="utf-8")


def _counts(views: list[TrackView]) -> dict[str, int]:
    """The number of tracks with each verdict, the most severe first."""
    counts: dict[str, int] = {}
    for view in views:
        counts[view.track.verdict] = counts.get(view.track.verdict, 0) + 1
    return counts


def _row(index: int, view: TrackView) -> dict[str, Any]:
    """One track in the template: its row of the overview."""
    return {
        "index": index,
        "on": index < SHOWN,
        "diagnosis": view.track,
        "quantity": view.quantities()[0],
        "verdicts": quantity_verdicts(view),
        "style": view.style,
        "since": first_event(view),
        "bars": timeline_bars(view),
    }


def _blocks(views: list[TrackView], comparison: Comparison, progress: bool) -> list[str]:
    """The figures and tables of the tracks, compressed in blocks of ``BLOCK`` tracks."""
    blocks: Iterable[list[TrackView]] = [views[i : i + BLOCK] for i in range(0, len(views), BLOCK)]
    if progress:
        blocks = with_progress(blocks, "drawing", -(-len(views) // BLOCK), f"x {BLOCK} tracks")
    # zlib works without the interpreter's lock: one block is compressed while the next is made.
    with _no_garbage_collection(), ThreadPoolExecutor(1) as pool:
        parts = [pool.submit(_compressed, _block(block, comparison)) for block in blocks]
        return [part.result() for part in parts]


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Figures are many small objects without cycles; the search for cycles costs a fifth."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _block(views: list[TrackView], comparison: Comparison) -> bytes:
    arrays = PackedArrays()
    tracks = [_content(view, comparison, arrays) for view in views]
    # One list for each part of all tracks: similar parts compress best beside each other.
    return arrays.payload({part: [track[part] for track in tracks] for part in tracks[0]})


def _content(view: TrackView, comparison: Comparison, arrays: PackedArrays) -> dict[str, Any]:
    """What the browser draws and lists when a track is opened."""
    arrays.begin_track()
    own = draw_plotly.figure(comparison.scene([view]), arrays)["data"]
    figure = draw_plotly.figure(track_scene(view, titled=False), arrays)
    return {
        "comparison": [{**trace, "showlegend": False} for trace in own],
        "layout": figure["layout"],
        "data": figure["data"],
        "tables": [vars(table) for table in track_tables(view)],
        "updates": update_table(view, arrays),
    }


def _json(content: Any) -> str:
    return json.dumps(content, separators=(",", ":"), allow_nan=False)


def _compressed(content: bytes) -> str:
    """The content as the browser unpacks it; the same content gives the same text."""
    return base64.b64encode(gzip.compress(content, 8, mtime=0)).decode()
