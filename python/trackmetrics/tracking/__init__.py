"""Scores over the identities of tracks."""

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

__all__ = [
    "CLEARMOT",
    "HOTA",
    "PROTOCOLS",
    "BoxScores",
    "Evaluation",
    "Explanation",
    "FrameColumns",
    "IdentityScores",
    "Protocol",
    "TrackFrames",
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
    "track_fragmentation",
    "track_purity",
]
