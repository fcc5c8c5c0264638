"""Identity scores: IDF1, IDP and IDR of one assignment of whole tracks to targets."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from trackmetrics import _backend
from trackmetrics.results import Result
from trackmetrics.tracking.frames import TrackFrames, as_frames
from trackmetrics.tracking.protocols import Protocol, find_protocol
from trackmetrics.tracking.similarity import PairMeasure, pair_measure
from trackmetrics.tracks import TrackTable


@dataclass(frozen=True)
class IdentityScores(Result):
    """Identity scores of a sequence."""

    idf1: float
    """``idtp / (idtp + idfp / 2 + idfn / 2)`` in [0, 1]; 1 is best."""
    idp: float
    """Precision ``idtp / (idtp + idfp)`` in [0, 1]; 1 is best."""
    idr: float
    """Recall ``idtp / (idtp + idfn)`` in [0, 1]; 1 is best."""
    idtp: int
    """Truth rows that the target's own track is within the threshold of."""
    idfn: int
    """All other truth rows; 0 is best."""
    idfp: int
    """Track rows that are not within the threshold of the track's own target; 0 is best."""


def identity_scores(
    frames: TrackFrames | TrackTable,
    tracks: TrackTable | None = None,
    *,
    similarity: str | Sequence[Any] = "iou",
    threshold: float = 0.5,
    protocol: str = "trackeval",
) -> IdentityScores:
    """Scores of the one-to-one assignment of whole tracks to targets that has most pairs.

    With ``n(i, j)`` the number of frames in which target i and track j are within the threshold,
    whatever else is near, and the largest assignment over all targets and tracks,

        IDTP = max sum of n(i, j),  IDFN = truth rows - IDTP,  IDFP = track rows - IDTP

    Parameters
    ----------
    frames, tracks, similarity, threshold
        As in :func:`clear_mot`.
    protocol : {"trackeval", "motmetrics", "bernardin"}
        The implementation whose numbers are wanted; the paper of CLEAR MOT has no identity scores,
        and ``"bernardin"`` takes those of py-motmetrics. They differ in the rounding at the
        threshold (a similarity of at least ``threshold``, or a distance ``1 - similarity`` of at
        most ``1 - threshold``) and in ratios without a denominator (0, or NaN).

    Returns
    -------
    IdentityScores
        Counts, of which ``idfn`` and ``idfp`` are 0 at best, and ratios in [0, 1], 1 at best.

    Raises
    ------
    ValueError, TypeError
        As in :func:`clear_mot`.

    References
    ----------
    Ristani, Solera, Zou, Cucchiara and Tomasi, "Performance measures and a data set for
    multi-target, multi-camera tracking", ECCV workshops, 2016, doi:10.1007/978-3-319-48881-3_2.

    Examples
    --------
    A target is followed by track 7 in two frames and by track 8 in one:

    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 3], ["ferry"] * 3, [1, 2, 3], [7, 7, 8],
    ...     truth_positions=[[0.0], [1.0], [2.0]], track_positions=[[0.0], [1.0], [2.0]],
    ... )
    >>> scores = identity_scores(frames, similarity="euclidean", threshold=1.0)
    >>> scores.idtp, scores.idfn, scores.idfp
    (2, 1, 1)
    >>> scores.idf1
    0.6666666666666666
    """
    rules = find_protocol(protocol)
    return identity_scores_of(pair_measure(as_frames(frames, tracks), similarity, threshold), rules)


def identity_scores_of(measure: PairMeasure, rules: Protocol) -> IdentityScores:
    """The identity scores of pairs that were found before."""
    truth, tracks = measure.frames.truth, measure.frames.tracks
    by_distance = rules.motp_is_distance
    limit = measure.distance_threshold if by_distance else measure.similarity_threshold
    kernel = _backend.kernels.identities
    *_, idtp = kernel(truth.coded(), tracks.coded(), measure.pairs, by_distance, limit)
    return identity_of_counts(idtp, len(truth) - idtp, len(tracks) - idtp, rules)


def identity_of_counts(idtp: int, idfn: int, idfp: int, rules: Protocol) -> IdentityScores:
    """Identity scores of the three counts."""
    return IdentityScores(
        idf1=rules.ratio(idtp, idtp + idfp / 2 + idfn / 2),
        idp=rules.ratio(idtp, idtp + idfp),
        idr=rules.ratio(idtp, idtp + idfn),
        idtp=idtp,
        idfn=idfn,
        idfp=idfp,
    )
