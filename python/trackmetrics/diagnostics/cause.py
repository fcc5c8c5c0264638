"""The probable cause of an inconsistency, from the size and the correlation of the innovations.

Too large and positively correlated: process noise too small. Too large and negatively correlated:
measurement noise too small. Too small and positively correlated: measurement noise too large. Too
small and negatively correlated: process noise too large.
"""

from collections.abc import Mapping

from trackmetrics.diagnostics.results import InnovationCorrelation
from trackmetrics.diagnostics.thresholds import (
    CAUSE_ALPHA_SHARE,
    MAX_LASTING_SCALE,
    MIN_LASTING_SCALE,
)
from trackmetrics.diagnostics.whiteness import sign

CAUSES: Mapping[tuple[str, int], str] = {
    ("optimistic", 1): "process noise too small",
    ("optimistic", -1): "measurement noise too small",
    ("pessimistic", 1): "measurement noise too large",
    ("pessimistic", -1): "process noise too large",
}

CAUSE_VERDICTS = ("startup_then_pessimistic", "optimistic", "pessimistic", "partly_pessimistic")
"""Verdicts of a track that a noise covariance of the wrong size explains."""


def probable_cause(
    verdict: str, correlation: InnovationCorrelation, alpha: float, is_heavy_tailed: bool
) -> str | None:
    """The cause of the verdict on the NIS; None where the innovations do not show it.

    Outliers too make innovations large and negatively correlated, so that "measurement noise too
    small" is not named where there are any.
    """
    side = next((s for s in ("optimistic", "pessimistic") if s in verdict), None)
    if side is None:
        return None
    lasting = _lasting_sign(correlation, CAUSE_ALPHA_SHARE * alpha, side == "optimistic")
    cause = CAUSES.get((side, lasting))
    return None if cause == "measurement noise too small" and is_heavy_tailed else cause


def _lasting_sign(correlation: InnovationCorrelation, alpha: float, is_optimistic: bool) -> int:
    """The sign of the correlation if the second half has the same, and the same side; else 0.

    What a bad start leaves behind fades in the second half.
    """
    scale = correlation.second_half_scale
    if is_optimistic:
        lasts = MIN_LASTING_SCALE < scale < MAX_LASTING_SCALE
    else:
        lasts = scale < 1 / MIN_LASTING_SCALE
    found = sign(correlation, alpha)
    return found if found * correlation.second_half_z > 0 and lasts else 0
