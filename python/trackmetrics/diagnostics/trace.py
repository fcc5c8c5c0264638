"""A sequence of chi-square values: the NIS of a track, or its NEES."""

from dataclasses import dataclass

import numpy as np

from trackmetrics.diagnostics.thresholds import MIN_DOF_TO_JUDGE, MIN_UPDATES_TO_JUDGE
from trackmetrics.logs.columns import Floats, Integers

Pair = tuple[Floats, Floats]
"""Values and their degrees of freedom."""


@dataclass(frozen=True, eq=False)
class Partitions:
    """The best partitions of a sequence into segments, by number of change points."""

    gains: Floats
    cuts: Integers

    def edges(self, count: int, length: int) -> list[int]:
        """The edges of the segments with ``count`` change points, from 0 to ``length``."""
        return [0, *self.cuts[count, :count].tolist(), length]


@dataclass(frozen=True, eq=False)
class Trace:
    """A sequence of chi-square values."""

    values: Floats
    """Values, divided by their autocorrelation time."""
    dof: Floats
    """Degrees of freedom, divided by the same."""
    rows: Integers
    """The update of each value."""
    times: Floats
    """The time of each value."""
    is_nis: bool
    """Whether these are NIS: only NIS have outliers, and a correlation not yet accounted for."""
    autocorrelation_time: float = 1.0
    """The median of the autocorrelation times."""
    partitions: Partitions | None = None
    """Its best partitions, where they are known already."""

    @property
    def is_sufficient(self) -> bool:
        """Whether there are enough values to judge."""
        n = len(self.values)
        return n >= MIN_UPDATES_TO_JUDGE and float(self.dof.sum()) >= MIN_DOF_TO_JUDGE

    @property
    def pair(self) -> Pair:
        """Values and degrees of freedom."""
        return self.values, self.dof


def no_trace() -> Trace:
    """The trace of a quantity that the log does not have."""
    empty = np.empty(0)
    return Trace(empty, empty, np.empty(0, np.int64), empty, is_nis=True)
