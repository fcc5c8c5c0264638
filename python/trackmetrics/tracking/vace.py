"""VACE: sequence tracking accuracy (STDA, ATA) and frame detection accuracy (FDA, SFDA).

With n(i, j) the number of frames in which target i and track j are within the threshold, and
u(i, j) the number of frames in which either is present,

    STDA = largest sum of n / u over one-to-one assignments of whole tracks
    ATA  = STDA / ((targets + tracks) / 2)
    FDA  = sum over frames of (largest sum of similarities / ((rows of truth + of tracks) / 2))
    SFDA = FDA / frames with a row
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.results import Result
from trackmetrics.tracking.frames import TrackFrames, as_frames
from trackmetrics.tracking.similarity import PairMeasure, pair_measure
from trackmetrics.tracks import TrackTable


@dataclass(frozen=True)
class VACE(Result):
    """VACE of a sequence."""

    stda: float
    """Sequence track detection accuracy: sum over pairs of a target and its track of the share of
    their frames in which they match; at most the smaller number of ids."""
    ata: float
    """Average tracking accuracy: STDA over the mean number of ids, in [0, 1]; 1 is best."""
    fda: float
    """Frame detection accuracies, summed over the frames; at most ``frames``."""
    sfda: float
    """Mean of the frame detection accuracies, in [0, 1]; 1 is best."""
    truth_ids: int
    """Number of targets."""
    track_ids: int
    """Number of tracks."""
    frames: int
    """Number of frames with a row on either side."""


def vace(
    frames: TrackFrames | TrackTable,
    tracks: TrackTable | None = None,
    *,
    similarity: str | Sequence[Any] = "iou",
    threshold: float = 0.5,
) -> VACE:
    """VACE: how long whole tracks match whole targets, and how well frames are detected.

        ATA  = STDA / ((targets + tracks) / 2)
        SFDA = FDA / frames with a row

    with STDA the largest sum, over one-to-one assignments of tracks to targets, of frames in which
    the two match over frames in which either is present, and FDA the sum over frames of the
    largest sum of similarities over the mean number of rows.

    Parameters
    ----------
    frames, tracks, similarity, threshold
        As in :func:`clear_mot`. The threshold is for STDA; FDA takes every similarity as it is.

    Returns
    -------
    VACE
        Sums, and the two scores in [0, 1], 1 at best; NaN without an id or a frame with a row.

    Raises
    ------
    ValueError, TypeError
        As in :func:`clear_mot`.

    Notes
    -----
    The numbers are those of TrackEval 1.3.0, the relaxed form with a threshold in each frame; a
    similarity has to reach the threshold exactly. Over sequences ``stda``, ``fda`` and the three
    counts add up.

    References
    ----------
    Manohar et al., "Performance evaluation of object detection and tracking in video", ACCV, 2006,
    doi:10.1007/11612704_16. Kasturi et al., "Framework for performance evaluation of face, text,
    and vehicle detection and tracking in video", IEEE Trans. Pattern Analysis and Machine
    Intelligence 31, 2009, doi:10.1109/TPAMI.2008.57.

    Examples
    --------
    A target is followed by one track in two of four frames, and by another in the third:

    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 3, 4], ["ferry"] * 4, [1, 2, 3], [7, 7, 8],
    ...     truth_boxes=[[0, 0, 2, 2]] * 4, track_boxes=[[0, 0, 2, 2]] * 3,
    ... )
    >>> scores = vace(frames)
    >>> scores.stda, round(scores.ata, 3), scores.fda, scores.sfda
    (0.5, 0.333, 3.0, 0.75)
    """
    measure = pair_measure(as_frames(frames, tracks), similarity, threshold)
    frames = measure.frames
    stda, fda = _track_accuracy(measure), _frame_accuracy(measure)
    ids = len(frames.truth.names) + len(frames.tracks.names)
    filled = int(((np.diff(frames.truth.starts) + np.diff(frames.tracks.starts)) > 0).sum())
    return VACE(
        stda=stda,
        ata=stda / (0.5 * ids) if ids else math.nan,
        fda=fda,
        sfda=fda / filled if filled else math.nan,
        truth_ids=len(frames.truth.names),
        track_ids=len(frames.tracks.names),
        frames=filled,
    )


def _track_accuracy(measure: PairMeasure) -> float:
    truth, tracks = measure.frames.truth, measure.frames.tracks
    matched = np.zeros((len(truth.names), len(tracks.names)))
    both = np.zeros_like(matched)
    for t, rows, columns in measure.frames.slices():
        near = measure.similarities(t, rows, columns) >= measure.similarity_threshold
        pairs = np.ix_(truth.ids[rows], tracks.ids[columns])
        matched[pairs] += near
        both[pairs] += 1
    rows_of = np.bincount(truth.ids, minlength=len(truth.names))
    columns_of = np.bincount(tracks.ids, minlength=len(tracks.names))
    shares = matched / (rows_of[:, None] + columns_of - both)
    if not shares.size:
        return 0.0
    return float(shares[linear_sum_assignment(shares, maximize=True)].sum())


def _frame_accuracy(measure: PairMeasure) -> float:
    total = 0.0
    for t, rows, columns in measure.frames.slices():
        similarities = measure.similarities(t, rows, columns)
        best = similarities[linear_sum_assignment(similarities, maximize=True)].sum()
        total += float(best) / (0.5 * sum(similarities.shape))
    return total
