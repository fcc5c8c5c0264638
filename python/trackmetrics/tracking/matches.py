"""The pairs of all frames by the rules of a protocol, and what happens with them."""

from dataclasses import dataclass
from enum import IntFlag
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend
from trackmetrics.tracking.protocols import Protocol
from trackmetrics.tracking.similarity import PairMeasure

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]


class Event(IntFlag):
    """What happens with a pair; several can happen at once."""

    CONTINUED = 1
    """The pair continues an earlier one."""
    SWITCH = 2
    """The target's last pair was with another track."""
    TRANSFER = 4
    """The pair is newly assigned, and so was the track's last such pair, with another target."""
    ASCEND = 8
    """A switch to a track that had no pair before."""
    MIGRATE = 16
    """A transfer to a target that had no pair before."""
    FRAGMENTATION = 32
    """The target was interrupted since its last pair."""


@dataclass(frozen=True, eq=False)
class Matches:
    """The matched pairs of a sequence, one element for each truth row.

    A truth row without a partner is a miss, a track row without one a false alarm.
    """

    partners: Codes
    """Row of the tracks, -1 for a miss; shape (N,)."""
    values: Floats
    """Similarity or, where MOTP is one, distance of the pair; NaN for a miss."""
    events: Codes
    """Sum of the :class:`Event` that happen with the pair; 0 for a miss."""
    matched: Codes
    """Number of pairs of each target."""
    total: float
    """Sum of the values."""

    def count(self, event: Event) -> int:
        """How often this happens."""
        return int(np.count_nonzero(self.events & int(event)))

    @cached_property
    def truth_rows(self) -> Codes:
        """The truth rows that have a partner, shape (k,)."""
        return np.flatnonzero(self.partners >= 0)

    @property
    def track_rows(self) -> Codes:
        """The partner of each of ``truth_rows``."""
        return self.partners[self.truth_rows]

    def has(self, event: Event) -> NDArray[np.bool_]:
        """Whether this happens with the pair of each of ``truth_rows``."""
        found: NDArray[np.bool_] = (self.events[self.truth_rows] & int(event)) != 0
        return found


def match(measure: PairMeasure, protocol: Protocol) -> Matches:
    """Match truth and tracks frame by frame."""
    truth, tracks = measure.frames.truth, measure.frames.tracks
    if protocol.most_similar:
        limit = measure.similarity_threshold - protocol.tolerance
    else:
        limit = measure.distance_threshold
    rules = protocol.forgets, protocol.most_similar, protocol.own_frames
    kernel = _backend.kernels.clear_mot
    return Matches(*kernel(truth.coded(), tracks.coded(), measure.pairs, rules, limit))
