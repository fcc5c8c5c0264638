"""Scores over the identities of tracks."""

from trackmetrics.tracking.index_scores import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)

__all__ = ["identity_switches", "mot_metrics", "track_fragmentation", "track_purity"]
