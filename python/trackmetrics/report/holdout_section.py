"""Section of the page about held-out reports: how well each track predicted them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from trackmetrics.report.theme import segment_role
from trackmetrics.report.track_view import TrackView
from trackmetrics.vessel import HeldOutResult

DECADES = 2.0
"""The axis of scales reaches this many powers of ten on either side of 1."""


@dataclass(frozen=True)
class Prediction:
    """A row of the table: the held-out reports of one track."""

    index: int
    """Position of the track in the overview."""
    held_out: HeldOutResult
    """Result of the test."""
    verdict_fused: str
    """Verdict of the reports that the filter was given."""
    interval_left: float
    """Lower end of the interval on the axis of scales, in percent."""
    interval_width: float
    """Length of the interval, in percent."""
    scale_position: float
    """Position of the scale itself, in percent."""

    @property
    def role(self) -> str:
        """Colour of the interval, the same as that of a segment."""
        return segment_role(self.held_out.verdict)


def predictions(
    views: list[TrackView], held_out: Mapping[str, HeldOutResult] | None
) -> list[Prediction]:
    """The rows of the table, the largest scale first."""
    rows = [
        _prediction(index, view, held_out[view.track.track])
        for index, view in enumerate(views)
        if held_out and view.track.track in held_out
    ]
    return sorted(rows, key=lambda row: -row.held_out.scale)


def _prediction(index: int, view: TrackView, held_out: HeldOutResult) -> Prediction:
    left, right = map(_percent, held_out.interval)
    return Prediction(
        index=index,
        held_out=held_out,
        verdict_fused=view.track.verdict,
        interval_left=left,
        interval_width=max(right - left, 1.0),
        scale_position=_percent(held_out.scale),
    )


def _percent(scale: float) -> float:
    """Position of a scale on the axis; 1 is in the middle, values beyond an end are at the end."""
    decades = math.log10(scale) if scale > 0 else -DECADES
    return 50.0 + 50.0 * min(max(decades / DECADES, -1.0), 1.0)
