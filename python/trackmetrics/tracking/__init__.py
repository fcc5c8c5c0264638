"""Scores over the identities of tracks."""

from trackmetrics.tracking.index_scores import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)
from trackmetrics.tracking.label_score import BoxScores, paired_labels, score_boxes

__all__ = [
    "BoxScores",
    "identity_switches",
    "mot_metrics",
    "paired_labels",
    "score_boxes",
    "track_fragmentation",
    "track_purity",
]
