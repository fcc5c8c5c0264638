"""The rules in which TrackEval, py-motmetrics and the paper of CLEAR MOT differ, in one table.

The paper is Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR
MOT metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309. Its section
2.1.2 gives the mapping procedure that ``"bernardin"`` follows:

1. a mapping (target, track) made before is kept where both are present and within the threshold;
2. the other targets get tracks one to one, at the least total distance of pairs within the
   threshold; a pair that contradicts an earlier mapping replaces it, and is a mismatch.

What it leaves open is taken from where it was first answered: of two targets that were both mapped
to one track the first in the order of the rows keeps it, and there are as many new pairs as can be
(py-motmetrics); mostly tracked, mostly lost and fragmentations are those of Li, Huang and Nevatia,
"Learning to associate: HybridBoosted multi-target tracker for crowded scene", CVPR 2009,
doi:10.1109/CVPR.2009.5206735.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trackmetrics._similarity import EPS


@dataclass(frozen=True)
class Protocol:
    """The rules of CLEAR MOT and of the identity scores, by one implementation or by the paper."""

    name: str
    """What ``protocol=`` calls it."""
    forgets: bool
    """Continuation. True: only pairs of the last frame that had both sides are continued. False:
    the last pair of a target is continued, however long ago it was."""
    most_similar: bool
    """Objective. True: continued pairs and the other pairs in one assignment of largest total
    similarity, where a continued pair counts 1000 more. False: continued pairs are fixed first;
    then as many pairs as possible, and of these the least total distance."""
    tolerance: float
    """Threshold rounding: how far a similarity may be below the threshold in CLEAR MOT. The
    identity scores have no tolerance in either implementation."""
    edge_is_mostly_tracked: bool
    """Whether a target that is matched in exactly 80 % of its rows is mostly tracked."""
    own_frames: bool
    """Fragmentation. True: matched rows are consecutive in the target's own rows. False: in the
    frames that have both sides, so that an absence of the target interrupts too."""
    motp_is_distance: bool
    """Whether MOTP is a mean distance (0 is best) or a mean similarity (1 is best)."""
    empty_is_zero: bool
    """Empty sides. True: ratios without a denominator are 0, and every accuracy is 0 without
    truth. False: they are NaN or minus infinity."""
    transfers: bool
    """Whether transfers, ascends and migrates are counted."""
    source: str
    """Where the rules stand."""
    sources: Mapping[str, str]
    """Where each rule stands: the name of a field above, and the place."""

    def ratio(self, part: float, whole: float) -> float:
        """A quotient, with this protocol's value where the denominator is 0."""
        if self.empty_is_zero:
            return float(part / max(1.0, whole))
        if whole == 0:
            return float("nan") if part == 0 else float(np.copysign(np.inf, part))
        return float(part / whole)


PROTOCOLS = {
    "trackeval": Protocol(
        name="trackeval",
        forgets=True,
        most_similar=True,
        tolerance=EPS,
        edge_is_mostly_tracked=False,
        own_frames=False,
        motp_is_distance=False,
        empty_is_zero=True,
        transfers=False,
        source="TrackEval 1.3.0, trackeval/metrics/clear.py and identity.py",
        sources={
            "forgets": "clear.py, eval_sequence: prev_timestep_tracker_id",
            "most_similar": "clear.py, eval_sequence: score_mat = 1000 * continued + similarity",
            "tolerance": "clear.py: similarity < threshold - eps; identity.py: >= threshold",
            "edge_is_mostly_tracked": "clear.py: MT counts tracked_ratio > 0.8",
            "own_frames": "clear.py: gt_frag_count, runs of matched frames less one",
            "motp_is_distance": "clear.py, _compute_final_fields: MOTP_sum / CLR_TP",
            "empty_is_zero": "clear.py and identity.py: denominators are np.maximum(1, ...)",
            "transfers": "not in clear.py",
        },
    ),
    "motmetrics": Protocol(
        name="motmetrics",
        forgets=False,
        most_similar=False,
        tolerance=0.0,
        edge_is_mostly_tracked=True,
        own_frames=True,
        motp_is_distance=True,
        empty_is_zero=False,
        transfers=True,
        source="py-motmetrics 1.4.0, motmetrics/mot.py and metrics.py",
        sources={
            "forgets": "mot.py, MOTAccumulator.update, step 1: self.m holds the last match",
            "most_similar": "mot.py, update, steps 1 and 2; lap.py, add_expensive_edges",
            "tolerance": "distances.py: a distance above the threshold is NaN",
            "edge_is_mostly_tracked": "metrics.py, mostly_tracked: tracked[tracked >= 0.8]",
            "own_frames": "metrics.py, num_fragmentations: diff between first and last detection",
            "motp_is_distance": "metrics.py, motp: sum of D / num_detections",
            "empty_is_zero": "math_util.py, quiet_divide",
            "transfers": "mot.py, update: TRANSFER, ASCEND and MIGRATE",
        },
    ),
    "bernardin": Protocol(
        name="bernardin",
        forgets=False,
        most_similar=False,
        tolerance=0.0,
        edge_is_mostly_tracked=False,
        own_frames=True,
        motp_is_distance=True,
        empty_is_zero=False,
        transfers=False,
        source="Bernardin and Stiefelhagen, 2008",
        sources={
            "forgets": "mapping procedure: a pair is kept while it is valid",
            "most_similar": "mapping procedure: kept pairs first; the rest as py-motmetrics",
            "tolerance": "valid correspondences: none beyond the threshold",
            "edge_is_mostly_tracked": "Li, Huang and Nevatia, 2009: more than 80 %",
            "own_frames": "Li, Huang and Nevatia, 2009: interruptions of a true trajectory",
            "motp_is_distance": "definition of MOTP: total distance of the pairs / number of pairs",
            "empty_is_zero": "open in the paper: undefined is NaN here",
            "transfers": "the paper counts mismatches of targets only",
        },
    ),
}


def find_protocol(name: str) -> Protocol:
    """The protocol of that name."""
    if name not in PROTOCOLS:
        *most, last = map(repr, PROTOCOLS)
        expected = f"{', '.join(most)} or {last}"
        raise ValueError(f"protocol must be {expected}, got {name!r}")
    return PROTOCOLS[name]
