"""CLEAR MOT with the rules of TrackEval, of py-motmetrics or of the paper."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics.results import Result
from trackmetrics.tracking.frames import TrackFrames, as_frames
from trackmetrics.tracking.matches import Event, Matches, match
from trackmetrics.tracking.protocols import Protocol, find_protocol
from trackmetrics.tracking.similarity import PairMeasure, pair_measure
from trackmetrics.tracks import TrackTable


@dataclass(frozen=True)
class CLEARMOT(Result):
    """CLEAR MOT of a sequence. What a ratio is without a denominator is a rule of the protocol."""

    mota: float
    """Accuracy ``1 - (fn + fp + idsw) / (tp + fn)``: 1 is best, and it has no lower bound."""
    motp: float
    """Mean over the pairs: similarity in [0, 1], 1 is best (``"trackeval"``), or distance in its
    unit, 0 is best (the others)."""
    moda: float
    """Accuracy without switches ``1 - (fn + fp) / (tp + fn)``: 1 is best."""
    precision: float
    """``tp / (tp + fp)`` in [0, 1]; 1 is best."""
    recall: float
    """``tp / (tp + fn)`` in [0, 1]; 1 is best."""
    f1: float
    """``tp / (tp + fn / 2 + fp / 2)`` in [0, 1]; 1 is best."""
    tp: int
    """Number of pairs."""
    fn: int
    """Number of truth rows without a pair; 0 is best."""
    fp: int
    """Number of track rows without a pair; 0 is best."""
    idsw: int
    """Identity switches: pairs of a target whose last pair was with another track; 0 is best."""
    frag: int
    """Fragmentations: interruptions between the pairs of a target; 0 is best."""
    mt: int
    """Mostly tracked targets: matched in more than 80 % of their rows (or at least 80 %)."""
    pt: int
    """Partially tracked targets: at least 20 %, and not mostly tracked."""
    ml: int
    """Mostly lost targets: less than 20 %; 0 is best."""
    mtr: float
    """Fraction of targets that are mostly tracked, in [0, 1]; 1 is best."""
    ptr: float
    """Fraction of targets that are partially tracked, in [0, 1]."""
    mlr: float
    """Fraction of targets that are mostly lost, in [0, 1]; 0 is best."""
    smota: float
    """``(motp_sum - fp - idsw) / (tp + fn)``: 1 is best. NaN where MOTP is a distance."""
    motal: float
    """MOTA with ``log10(idsw)`` for ``idsw``; 1 is best."""
    motp_sum: float
    """Sum that MOTP is the mean of."""
    fp_per_frame: float
    """False alarms per frame; 0 is best. NaN without frames."""
    frames: int
    """Number of frames."""
    transfers: float
    """Newly assigned pairs of a track whose last assigned pair was with another target; 0 is best.
    NaN where the protocol does not count them, as the next two."""
    ascends: float
    """Switches to a track that had no pair before."""
    migrates: float
    """Transfers to a target that had no pair before."""


def clear_mot(
    frames: TrackFrames | TrackTable,
    tracks: TrackTable | None = None,
    *,
    similarity: str | Sequence[Any] = "iou",
    threshold: float = 0.5,
    protocol: str = "trackeval",
) -> CLEARMOT:
    """CLEAR MOT: detections, switches and fragmentations, from frame-by-frame pairs.

    In each frame truth and tracks are matched one to one within a threshold; a target keeps its
    track where it can. Over all frames,

        MOTA = 1 - (misses + false alarms + identity switches) / truth rows
        MOTP = mean similarity (or distance) of the pairs

    Parameters
    ----------
    frames : TrackFrames or TrackTable
        Truth and tracks of one sequence, or the truth alone.
    tracks : TrackTable, optional
        The tracks, where ``frames`` is the truth.
    similarity : {"iou", "euclidean"} or list of array_like
        Intersection over union of the boxes; Euclidean distance of the positions (of the centres of
        the boxes where there are none); or for each frame a matrix of similarities in [0, 1], truth
        rows x track rows in the order of ``frames``, where NaN excludes a pair.
    threshold : float
        Least similarity of a pair; for ``"euclidean"`` its largest distance, in the unit of the
        positions. A pair at the threshold counts.
    protocol : {"trackeval", "motmetrics", "bernardin"}
        The implementation whose numbers are wanted, or the paper; see Notes.

    Returns
    -------
    CLEARMOT
        Counts, of which ``fn``, ``fp``, ``idsw`` and ``frag`` are 0 at best, and ratios.

    Raises
    ------
    ValueError
        Where ``similarity``, ``threshold`` or ``protocol`` is none of these, boxes or positions are
        missing, or a matrix has the wrong shape or a value outside [0, 1].
    TypeError
        Where ``frames`` is no TrackFrames.

    Notes
    -----
    ``"trackeval"`` gives the numbers of TrackEval 1.3.0, ``"motmetrics"`` those of py-motmetrics
    1.4.0, and ``"bernardin"`` the definition of the paper below, with the conventions of its
    successors where it has none. The rules in which they differ are fields of
    ``trackmetrics.tracking.PROTOCOLS``, each with its source:
    continuation, objective of the assignment, edge of mostly tracked, fragmentation, threshold
    rounding, direction of MOTP and empty sides. With TrackEval's rules the Euclidean similarity is
    ``max(0, 1 - d / (2 * threshold))``, so that its threshold is 0.5. Where a sequence has no truth
    or no track at all, TrackEval reports 0 frames; here ``frames`` and ``fp_per_frame`` have their
    values.

    References
    ----------
    Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
    metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309.

    Examples
    --------
    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 3, 4], ["ferry"] * 4, [1, 2, 4], [7, 7, 8],
    ...     truth_positions=[[0.0], [1.0], [2.0], [3.0]], track_positions=[[0.5], [1.0], [3.0]],
    ... )
    >>> scores = clear_mot(frames, similarity="euclidean", threshold=1.0)
    >>> scores.mota, scores.fn, scores.idsw, scores.recall
    (0.5, 1, 1, 0.75)
    >>> scores.motp
    0.9166666666666666
    >>> clear_mot(frames, similarity="euclidean", threshold=1.0, protocol="motmetrics").motp
    0.16666666666666666
    """
    rules = find_protocol(protocol)
    return clear_mot_of(pair_measure(as_frames(frames, tracks), similarity, threshold), rules)


def clear_mot_of(measure: PairMeasure, rules: Protocol) -> CLEARMOT:
    """CLEAR MOT of pairs that were found before."""
    return clear_of_matches(measure.frames, match(measure, rules), rules)


def clear_of_matches(frames: TrackFrames, matches: Matches, rules: Protocol) -> CLEARMOT:
    """Counts and ratios of the matches of a sequence."""
    counts = _counts(frames, matches, rules)
    transfers = (matches.count(event) for event in (Event.TRANSFER, Event.ASCEND, Event.MIGRATE))
    transfer, ascend, migrate = transfers if rules.transfers else (math.nan,) * 3
    return CLEARMOT(
        **_ratios(counts, len(frames.truth.names), matches.total, rules),
        **counts,
        motp_sum=matches.total,
        fp_per_frame=counts["fp"] / len(frames) if len(frames) else math.nan,
        frames=len(frames),
        transfers=transfer,
        ascends=ascend,
        migrates=migrate,
    )


def _counts(frames: TrackFrames, matches: Matches, rules: Protocol) -> dict[str, int]:
    truth, tp = frames.truth, int(matches.matched.sum())
    share = matches.matched / np.bincount(truth.ids, minlength=len(truth.names))
    mt = int((share >= 0.8 if rules.edge_is_mostly_tracked else share > 0.8).sum())
    pt = int((share >= 0.2).sum()) - mt
    return {
        "tp": tp,
        "fn": len(truth) - tp,
        "fp": len(frames.tracks) - tp,
        "idsw": matches.count(Event.SWITCH),
        "frag": matches.count(Event.FRAGMENTATION),
        "mt": mt,
        "pt": pt,
        "ml": len(truth.names) - mt - pt,
    }


def combine_clear(results: Sequence[CLEARMOT], rules: Protocol) -> CLEARMOT:
    """CLEAR MOT of several sequences from the sums of their counts."""
    counts = {n: sum(getattr(r, n) for r in results) for n in _COUNTS}
    frames, total = sum(r.frames for r in results), sum(r.motp_sum for r in results)
    targets = counts["mt"] + counts["pt"] + counts["ml"]
    more = {n: sum(getattr(r, n) for r in results) for n in ("transfers", "ascends", "migrates")}
    return CLEARMOT(
        **_ratios(counts, targets, total, rules),
        **counts,
        **more,
        motp_sum=total,
        fp_per_frame=counts["fp"] / frames if frames else math.nan,
        frames=frames,
    )


_COUNTS = ("tp", "fn", "fp", "idsw", "frag", "mt", "pt", "ml")


def _ratios(counts: dict[str, int], targets: int, total: float, rules: Protocol) -> dict[str, Any]:
    tp, fn, fp, idsw = (counts[name] for name in ("tp", "fn", "fp", "idsw"))
    truth, ratio = tp + fn, rules.ratio
    accuracies = {
        "mota": tp - fp - idsw,
        "moda": tp - fp,
        "smota": math.nan if rules.motp_is_distance else total - fp - idsw,
        "motal": tp - fp - (math.log10(idsw) if idsw else 0),
    }
    if not truth and rules.empty_is_zero:
        accuracies = dict.fromkeys(accuracies, 0)
    lost = ratio(counts["ml"], targets)
    return {
        **{name: ratio(part, truth) for name, part in accuracies.items()},
        "motp": ratio(total, tp),
        "precision": ratio(tp, tp + fp),
        "recall": ratio(tp, truth),
        "f1": ratio(tp, tp + fn / 2 + fp / 2),
        "mtr": ratio(counts["mt"], targets),
        "ptr": ratio(counts["pt"], targets),
        "mlr": 1.0 if not targets and rules.empty_is_zero else lost,
    }
