"""The rules in which TrackEval and py-motmetrics differ, in one table."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.tracking.similarity import EPS, PairMeasure

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Protocol:
    """The rules of one implementation of CLEAR MOT and of the identity scores."""

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
    ),
}

# TrackEval's weight of a continued pair. It rounds similarities to 1e-13, so that another weight
# could break ties in another way.
_CONTINUED = 1000.0


def find_protocol(name: str) -> Protocol:
    """The protocol of that name."""
    if name not in PROTOCOLS:
        expected = " or ".join(map(repr, PROTOCOLS))
        raise ValueError(f"protocol must be {expected}, got {name!r}")
    return PROTOCOLS[name]


@dataclass(frozen=True, eq=False)
class Matches:
    """The matched pairs of all frames, in the order of time."""

    truth_rows: Codes
    """Row of the truth, shape (k,)."""
    track_rows: Codes
    """Row of the tracks."""
    values: Floats
    """Similarity or, for py-motmetrics, distance of the pair."""
    continued: NDArray[np.bool_]
    """Whether the pair was fixed as the continuation of an earlier one."""


def match(measure: PairMeasure, protocol: Protocol) -> Matches:
    """Match truth and tracks frame by frame."""
    truth, tracks = measure.frames.truth, measure.frames.tracks
    last = np.full(len(truth.names), -1, dtype=np.int64)
    found: list[tuple[Codes, Codes, Floats, NDArray[np.bool_]]] = []
    for t, rows, columns in measure.frames.slices():
        ids, others = truth.ids[rows], tracks.ids[columns]
        wanted = last[ids][:, None] == others
        if protocol.most_similar:
            values = measure.similarities(t, rows, columns)
            least = measure.similarity_threshold - protocol.tolerance
            i, j, fixed = _most_similar(values, wanted, least)
        else:
            values = measure.distances(t, rows, columns)
            i, j, fixed = _continue_then_assign(values, wanted)
        if protocol.forgets:
            last[:] = -1
        last[ids[i]] = others[j]
        found.append((i + rows.start, j + columns.start, values[i, j], fixed))
    if not found:
        none = np.empty(0, dtype=np.int64)
        return Matches(none, none, np.empty(0), np.empty(0, dtype=np.bool_))
    return Matches(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def _most_similar(
    similarities: Floats, wanted: NDArray[np.bool_], least: float
) -> tuple[Codes, Codes, NDArray[np.bool_]]:
    """Rows and columns of the pairs with the largest total score."""
    scores = _CONTINUED * wanted + similarities
    scores[similarities < least] = 0
    rows, columns = linear_sum_assignment(scores, maximize=True)
    kept = scores[rows, columns] > EPS
    rows, columns = rows[kept], columns[kept]
    return rows, columns, wanted[rows, columns]


def _continue_then_assign(
    distances: Floats, wanted: NDArray[np.bool_]
) -> tuple[Codes, Codes, NDArray[np.bool_]]:
    """Rows and columns of the continued pairs, then of the largest assignment of least cost."""
    rows, columns = np.nonzero(wanted & np.isfinite(distances))
    columns, first = np.unique(columns, return_index=True)  # the first target that wants it
    rows = rows[first]
    free = distances.copy()
    free[rows] = np.nan
    free[:, columns] = np.nan
    finite = np.isfinite(free)
    if not finite.any():
        return rows, columns, np.ones(len(rows), dtype=np.bool_)
    # A cost that no assignment takes where it can have one more pair instead.
    large = 2 * min(free.shape) * (np.abs(free[finite]).max() + 1) + 1
    more, others = linear_sum_assignment(np.where(finite, free, large))
    kept = finite[more, others]
    continued = np.repeat([True, False], [len(rows), int(kept.sum())])
    return np.append(rows, more[kept]), np.append(columns, others[kept]), continued
