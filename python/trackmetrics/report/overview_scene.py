"""Scene of all tracks: one row each with the segments of its NIS and NEES over time."""

from collections.abc import Sequence
from textwrap import wrap

from trackmetrics.diagnostics import QuantityVerdict
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    HLine,
    Panel,
    Points,
    Primitive,
    Rects,
    Scene,
    Text,
    floats,
)
from trackmetrics.report.theme import segment_role, verdict_label, verdict_role, verdict_symbol
from trackmetrics.report.track_view import TrackView

ROW_HEIGHT = 24.0
"""Height of a track in the overview, in pixels."""
_EXPLANATION = (
    "Upper half NIS, lower half NEES; red: covariance too small, blue: too large, "
    "green: consistent; ▲ onset, ◆ alarm"
)


def overview_scene(views: Sequence[TrackView], title: str) -> Scene:
    """Each track's segments of NIS and NEES over time, the most severe track at the top."""
    frame = Frame(left=190.0, right=210.0)
    bounds = frame.rows(110.0, [ROW_HEIGHT * max(len(views), 1)], 0.0)[0]
    primitives = [primitive for i, view in enumerate(views) for primitive in _row(view, -float(i))]
    panel = Panel(
        bounds,
        tuple(primitives),
        title=_EXPLANATION,
        x_label=views[0].clock.label if views else "minutes since start",
        y_label="",
        x_limits=views[0].x_limits if views else (0.0, 1.0),
        y_limits=(-len(views) + 0.4, 0.6),
        ticks=tuple((-float(i), _short(s.track.track)) for i, s in enumerate(views)),
    )
    return Scene(
        frame.width, bounds.top + bounds.height + frame.bottom, (panel,), title, summary(views)
    )


def summary(views: Sequence[TrackView]) -> str:
    """How many tracks, and how many of each verdict."""
    counts: dict[str, int] = {}
    for view in views:
        counts[view.track.verdict] = counts.get(view.track.verdict, 0) + 1
    parts = ", ".join(f"{count} {verdict_label(verdict)}" for verdict, count in counts.items())
    tracks = f"{len(views)} track{'s' if len(views) != 1 else ''}"
    return "\n".join(wrap(f"{tracks}: {parts}" if parts else tracks, 140))


def _short(name: str, length: int = 26) -> str:
    return name if len(name) <= length else name[: length - 1] + "…"


def _row(view: TrackView, y: float) -> list[Primitive]:
    primitives: list[Primitive] = [HLine(y - 0.5, "grid/0.6")]
    for verdict, low, high in ((view.track.nis, 0.04, 0.36), (view.track.nees, -0.36, -0.04)):
        if verdict is not None:
            primitives += _segment_rects(view, verdict, y + low, y + high)
            primitives += _event_markers(view, verdict, y + (low + high) / 2)
    end = view.span[1] + 0.045 * (view.span[1] - view.span[0])
    role = verdict_role(view.track.verdict)
    primitives.append(
        Text(
            end,
            y,
            f"{verdict_symbol(view.track.verdict)} {verdict_label(view.track.verdict)}",
            role,
        )
    )
    return primitives


def _segment_rects(
    view: TrackView, verdict: QuantityVerdict, low: float, high: float
) -> list[Primitive]:
    pad = 0.003 * (view.span[1] - view.span[0])
    primitives: list[Primitive] = []
    for segment in verdict.segments:
        left = floats([view.clock.at(segment.start_time) - pad])
        right = floats([view.clock.at(segment.stop_time) + pad])
        name = f"{verdict.quantity.upper()} scale {segment.scale:.3g}"
        box = Rects(
            left, right, floats([low]), floats([high]), f"{segment_role(segment.label)}/0.75", name
        )
        primitives.append(box)
    return primitives


def _event_markers(view: TrackView, verdict: QuantityVerdict, y: float) -> list[Primitive]:
    """Onset and alarm as symbols."""
    primitives: list[Primitive] = []
    for name, time, symbol in (
        ("onset", verdict.onset_time, "triangle-up"),
        ("alarm", verdict.alarm_time, "diamond"),
    ):
        if time is not None:
            x, label = view.clock([time]), f"{verdict.quantity.upper()} {name}"
            primitives.append(Points(x, floats([y]), "ink", symbol, False, 8.0, label))
    return primitives
