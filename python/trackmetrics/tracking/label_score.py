"""Scores of a tracker's boxes against the truth, over the centres of the boxes and their ids.

In each frame, truth and tracks are paired within a threshold; scores over identities count on the
ids of these pairs, misses and MOTP are those of :func:`trackmetrics.mot_metrics`.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.point_sets import ospa_over_time
from trackmetrics.results import Result
from trackmetrics.tracking.index_scores import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)

if TYPE_CHECKING:
    from trackmetrics.tracks import Boxes

Indices = NDArray[np.intp]


def _row(label: str, text: str, note: str) -> dict[str, str]:
    """Metadata of a field: the row of the printed table that shows it."""
    return {"label": label, "text": text, "note": note}


@dataclass(frozen=True)
class BoxScores(Result):
    """The scores of a tracker's boxes against the truth."""

    threshold: float
    """Largest distance of a pair, in pixels."""
    cutoff: float
    """Cutoff of OSPA, in pixels."""
    order: float
    """Order of OSPA."""
    frames: int
    """Number of frames compared."""
    true_boxes: int
    """Number of boxes of the truth."""
    true_ids: int
    """Number of targets."""
    track_boxes: int
    """Number of boxes of the tracker."""
    track_ids: int
    """Number of tracks."""
    ospa_mean: float = field(
        metadata=_row(
            "OSPA", "{:.2f} px", "mean over frames, cutoff {cutoff:g} px, order {order:g}"
        )
    )
    """Mean OSPA over the frames, in pixels; 0 is best."""
    ospa_worst: float = field(
        metadata=_row("OSPA, worst frame", "{:.2f} px", "in frame {ospa_worst_frame}")
    )
    """Largest OSPA of a frame, in pixels; 0 is best."""
    ospa_worst_frame: int
    """The first frame that has it."""
    misses: int = field(
        metadata=_row("misses", "{}", "of {true_boxes} boxes of {true_ids} targets")
    )
    """Number of boxes of the truth without a pair; 0 is best."""
    false_alarms: int = field(
        metadata=_row("false alarms", "{}", "of {track_boxes} boxes of {track_ids} tracks")
    )
    """Number of boxes of the tracker without a pair; 0 is best."""
    motp: float = field(
        metadata=_row("MOTP", "{:.2f} px", "mean distance of pairs within {threshold:g} px")
    )
    """Mean distance of the pairs, in pixels; 0 is best. NaN without a pair."""
    track_purity: float = field(
        metadata=_row("track purity", "{:.4f}", "pairs with the track's main target")
    )
    """Fraction of the pairs that belong to the main target of their track; 1 is best. NaN without a
    pair."""
    track_fragmentation: int = field(
        metadata=_row("track fragmentation", "{}", "changes of track, per target")
    )
    """Number of times that a target passes from one track to another; 0 is best."""
    identity_switches: int = field(
        metadata=_row("identity switches", "{}", "changes of target, per track")
    )
    """Number of times that a track passes from one target to another; 0 is best."""


def score_boxes(
    truth: "Boxes",
    tracks: "Boxes",
    *,
    threshold: float = 50.0,
    cutoff: float = 100.0,
    order: float = 2.0,
) -> BoxScores:
    """Score a tracker's boxes against the truth, over the centres of the boxes.

    Parameters
    ----------
    truth : Boxes
        The boxes of the targets that count.
    tracks : Boxes
        The boxes of the tracker.
    threshold : float
        Largest distance of a pair, in pixels.
    cutoff, order : float
        Parameters ``c`` (in pixels) and ``p`` of OSPA.

    Returns
    -------
    BoxScores
        OSPA, misses, false alarms and MOTP over the frames from the first to the last of either
        input; purity, fragmentation and switches over the ids of :func:`paired_labels`.

    Raises
    ------
    ValueError
        If neither input has a box, or a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from trackmetrics.tracks import Boxes
    >>> boxes = np.array([[0.0, 0, 2, 2], [1.0, 0, 2, 2]])
    >>> truth = Boxes(np.array([1, 2]), np.array([1, 1]), boxes, np.ones(2))
    >>> tracks = Boxes(np.array([1, 2]), np.array([7, 8]), boxes + [3, 0, 0, 0], np.ones(2))
    >>> scores = score_boxes(truth, tracks)
    >>> scores.motp, scores.track_fragmentation
    (3.0, 1)
    """
    numbers = np.concatenate([truth.frames, tracks.frames])
    if not len(numbers):
        raise ValueError("neither file has a box that counts")
    first, last = int(numbers.min()), int(numbers.max())
    indices = truth.by_frame(first, last), tracks.by_frame(first, last)
    x = [truth.centres[i] for i in indices[0]]
    y = [tracks.centres[j] for j in indices[1]]
    distances = ospa_over_time(x, y, c=cutoff, p=order)
    worst = int(np.argmax(distances))
    frames = mot_metrics(x, y, threshold=threshold)
    labels = paired_labels(truth, tracks, zip(*indices, strict=True), threshold)
    has_pairs = labels.shape[1] > 0  # the functions of pytcl call the undefined 0 and 1
    return BoxScores(
        threshold=threshold,
        cutoff=cutoff,
        order=order,
        frames=last - first + 1,
        true_boxes=len(truth),
        true_ids=truth.targets,
        track_boxes=len(tracks),
        track_ids=tracks.targets,
        ospa_mean=float(distances.mean()),
        ospa_worst=float(distances[worst]),
        ospa_worst_frame=first + worst,
        misses=frames.num_misses,
        false_alarms=frames.num_false_positives,
        motp=frames.motp if frames.num_misses < len(truth) else math.nan,
        track_purity=track_purity(*labels[:2]) if has_pairs else math.nan,
        track_fragmentation=track_fragmentation(*labels),
        identity_switches=identity_switches(*labels),
    )


def paired_labels(
    truth: "Boxes", tracks: "Boxes", frames: Iterable[tuple[Indices, Indices]], threshold: float
) -> NDArray[np.int64]:
    """Pair truth and tracks in each frame within a threshold.

    Parameters
    ----------
    truth, tracks : Boxes
        The boxes to pair.
    frames : iterable of (indices, indices)
        For each frame the indices of its boxes in ``truth`` and in ``tracks``.
    threshold : float
        Largest distance of a pair, in pixels.

    Returns
    -------
    ndarray of int, shape (3, pairs)
        Target, track and frame of every pair: in each frame as many pairs as possible, at the
        least total distance among those matchings.
    """
    pairs = [np.empty((3, 0), dtype=np.int64)]
    for i, j in frames:
        near = _near_pairs(truth.centres[i], tracks.centres[j], threshold)
        i, j = i[near[0]], j[near[1]]
        pairs.append(np.stack([truth.ids[i], tracks.ids[j], truth.frames[i]]))
    return np.concatenate(pairs, axis=1)


def _near_pairs(
    x: NDArray[np.float64], y: NDArray[np.float64], threshold: float
) -> tuple[Indices, Indices]:
    distances = np.linalg.norm(x[:, None] - y[None], axis=-1)
    near = distances <= threshold
    # One pair beyond the threshold costs more than any number of pairs within it.
    beyond = (min(near.shape) + 1) * distances[near].max(initial=1.0)
    rows, columns = linear_sum_assignment(np.where(near, distances, beyond))
    kept = near[rows, columns]
    return rows[kept], columns[kept]
