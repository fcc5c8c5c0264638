"""Scores over the identities of tracks."""

from trackmetrics.tracking.associations import associate
from trackmetrics.tracking.clear_mot import CLEARMOT, clear_mot
from trackmetrics.tracking.frames import FrameColumns, TrackFrames
from trackmetrics.tracking.hota import HOTA, hota
from trackmetrics.tracking.identity_scores import IdentityScores, identity_scores
from trackmetrics.tracking.index_scores import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)
from trackmetrics.tracking.label_score import BoxScores, paired_labels, score_boxes
from trackmetrics.tracking.protocols import PROTOCOLS, Protocol
from trackmetrics.tracking.siap import SIAP, siap
from trackmetrics.tracking.vace import VACE, vace

__all__ = [
    "CLEARMOT",
    "HOTA",
    "PROTOCOLS",
    "SIAP",
    "VACE",
    "BoxScores",
    "FrameColumns",
    "IdentityScores",
    "Protocol",
    "TrackFrames",
    "associate",
    "clear_mot",
    "hota",
    "identity_scores",
    "identity_switches",
    "mot_metrics",
    "paired_labels",
    "score_boxes",
    "siap",
    "track_fragmentation",
    "track_purity",
    "vace",
]
