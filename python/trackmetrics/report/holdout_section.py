"""Reports left out, on the page: how well each track predicted what it had not been given."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from trackmetrics.report.track_view import Subject
from trackmetrics.vessel import HeldOut

_DECADES = 2.0
"""How far the axis of scales reaches on either side of 1, in powers of ten."""


@dataclass(frozen=True)
class Prediction:
    """A row of the table: one track's held-out reports."""

    index: int
    """Place of the track in the overview."""
    held: HeldOut
    """What the test found."""
    fused: str
    """Verdict of the reports that the filter was given."""
    left: float
    """Lower end of the interval on the axis of scales, in percent."""
    width: float
    """How far the interval reaches from there."""
    at: float
    """The scale itself."""

    @property
    def label(self) -> str:
        """Colour of the interval, as that of a segment."""
        return {"optimistic": "high", "pessimistic": "low"}.get(self.held.verdict, "consistent")


def predictions(every: list[Subject], held_out: Mapping[str, HeldOut] | None) -> list[Prediction]:
    """The rows, the filters that claim too much first."""
    rows = [
        _prediction(index, subject, held_out[subject.track.track])
        for index, subject in enumerate(every)
        if held_out and subject.track.track in held_out
    ]
    return sorted(rows, key=lambda row: -row.held.scale)


def _prediction(index: int, subject: Subject, held: HeldOut) -> Prediction:
    left, right = map(_percent, held.interval)
    fused = subject.track.verdict
    return Prediction(index, held, fused, left, max(right - left, 1.0), _percent(held.scale))


def _percent(scale: float) -> float:
    """Where a scale stands on the axis, 1 in its middle; beyond an end, at the end."""
    decades = math.log10(scale) if scale > 0 else -_DECADES
    return 50.0 + 50.0 * min(max(decades / _DECADES, -1.0), 1.0)
