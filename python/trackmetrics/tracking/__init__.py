"""Scores over the identities of tracks."""

from trackmetrics.tracking.associations import associate
from trackmetrics.tracking.clear_mot import CLEARMOT, clear_mot
from trackmetrics.tracking.evaluation import (
    Evaluation,
    average_classes,
    combine,
    evaluate,
    evaluate_sequences,
)
from trackmetrics.tracking.explanation import Explanation, explain
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
from trackmetrics.tracking.preprocess import preprocess_kitti, preprocess_mot_challenge
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
    "Evaluation",
    "Explanation",
    "FrameColumns",
    "IdentityScores",
    "Protocol",
    "TrackFrames",
    "associate",
    "average_classes",
    "clear_mot",
    "combine",
    "evaluate",
    "evaluate_sequences",
    "explain",
    "hota",
    "identity_scores",
    "identity_switches",
    "mot_metrics",
    "paired_labels",
    "preprocess_kitti",
    "preprocess_mot_challenge",
    "score_boxes",
    "siap",
    "track_fragmentation",
    "track_purity",
    "vace",
]
