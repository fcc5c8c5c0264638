"""A sequence of chi-square values, and what became of it: outliers, stretches, tested ends."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from trackmetrics.logs.columns import Floats, Integers

LEAST_UPDATES = 4
LEAST_DOF = 8.0
LEAST_SEGMENT = 2
MOST_SEGMENTS = 4
MATERIAL = 1.25
"""A scale within this factor of 1 is no fault, however certain."""


@dataclass(frozen=True)
class Candidates:
    """The best partitions of one sequence, by number of cuts."""

    gains: Floats
    cuts: Integers

    def edges(self, count: int, length: int) -> list[int]:
        """The edges of its stretches, from 0 to its length."""
        return [0, *self.cuts[count, :count].tolist(), length]


@dataclass(frozen=True)
class Stretch:
    """Updates ``start:stop`` with their sum, degrees of freedom and what follows."""

    start: int
    stop: int
    sum: float
    dof: float
    scale: float
    interval: tuple[float, float]
    p_value: float
    label: str
    spike: bool = False
    """High by one value alone, and therefore called consistent."""

    def __len__(self) -> int:
        """How many updates."""
        return self.stop - self.start


@dataclass
class Trace:
    """A sequence of chi-square values, and what became of it."""

    values: Floats
    dof: Floats
    spikes: bool
    """Whether these are NIS: single large values may be outliers, and what correlates in time is
    not yet accounted for. Values of NEES come divided by their autocorrelation time."""
    least_tail: float = 1.0
    """The smallest chance of any value under a scale of 1; 1 if none is small."""
    kept: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    """The values that are not set aside."""
    outliers: tuple[int, ...] = ()
    """The values that are."""
    stretches: tuple[Stretch, ...] = ()
    """The kept values, cut where the scale changes; indices count kept values."""
    start_p: float = 1.0
    """P-value of "the beginning is not too large", and its length."""
    start_length: int = 0
    end_p: float = 1.0
    """The same of the end."""
    end_length: int = 0
    alarm: tuple[int, int] | None = None
    """Where an online monitor would have called, and where the rise began."""
    found: Candidates | None = None
    """Its partitions, where they are known."""

    @cached_property
    def sufficient(self) -> bool:
        """Whether there is enough to judge."""
        return len(self.values) >= LEAST_UPDATES and float(self.dof.sum()) >= LEAST_DOF

    def kept_values(self) -> tuple[Floats, Floats]:
        """Values and degrees of freedom without outliers."""
        if len(self.kept) == len(self.values):
            return self.values, self.dof
        return self.values[self.kept], self.dof[self.kept]
