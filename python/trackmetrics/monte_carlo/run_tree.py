"""Pairwise summation over runs on dyadic blocks: sums that do not depend on how runs were cut.

A node (start, level) is the sum of the runs ``start .. start + 2**level``, ``start`` a multiple of
``2**level``, and always its left half plus its right half. Any set of runs is a unique list of
such nodes, and two disjoint sets are joined by adding siblings: whoever added what, in whichever
batches, every node has the same bits. An interval of N runs is at most ``2 log2 N`` nodes.
"""

from collections.abc import Iterator
from functools import reduce

import numpy as np
from numpy.typing import NDArray

MAX_LEVEL = 62
"""Of a node: run numbers fit into 64 bits."""
MAX_RUNS = 1 << MAX_LEVEL
"""More runs than any sweep has."""

Floats = NDArray[np.float64]
Row = Floats | None
"""The sums of a node; None where none of its runs gave anything."""


def dyadic_blocks(first: int, stop: int, max_level: int = MAX_LEVEL) -> Iterator[tuple[int, int]]:
    """The nodes (start, level) of the runs ``first .. stop``, none above ``max_level``."""
    while first < stop:
        level = min((stop - first).bit_length() - 1, max_level)
        if first:
            level = min(level, (first & -first).bit_length() - 1)
        yield first, level
        first += 1 << level


class RunTree:
    """The nodes of a set of runs, none above ``max_level``, each with a row of sums."""

    def __init__(self, max_level: int = MAX_LEVEL) -> None:
        self.max_level = max_level
        self._nodes: dict[int, tuple[int, Row]] = {}

    def __iter__(self) -> Iterator[tuple[int, int, Row]]:
        """Start, level and row of every node, in the order of the runs."""
        for start in sorted(self._nodes):
            yield start, *self._nodes[start]

    def __len__(self) -> int:
        """How many runs."""
        return sum(1 << level for level, _ in self._nodes.values())

    def add(self, start: int, level: int, row: Row) -> None:
        """Adds a node, and joins siblings as far as there are any."""
        while level < self.max_level:
            sibling = self._nodes.get(start ^ (1 << level))
            if sibling is None or sibling[0] != level:
                break
            other = start ^ (1 << level)
            del self._nodes[other]
            row = _sum(row, sibling[1]) if start < other else _sum(sibling[1], row)
            start, level = min(start, other), level + 1
        self._nodes[start] = (level, row)

    def merge(self, other: "RunTree") -> None:
        """Adds the nodes of another tree of other runs."""
        for start, level, row in other:
            self.add(start, level, row)

    def intervals(self) -> list[tuple[int, int]]:
        """The runs as intervals ``first .. stop``."""
        found: list[tuple[int, int]] = []
        for start, level, _ in self:
            stop = start + (1 << level)
            if found and found[-1][1] == start:
                found[-1] = (found[-1][0], stop)
            else:
                found.append((start, stop))
        return found

    def raise_max_level(self, max_level: int) -> None:
        """Allows larger nodes."""
        nodes = list(self)
        self.max_level, self._nodes = max_level, {}
        for node in nodes:
            self.add(*node)

    def total(self) -> Row:
        """The sum of all nodes, in the order of the runs."""
        return reduce(_sum, (row for _, _, row in self), None)


def first_overlap(ours: RunTree, theirs: RunTree) -> tuple[int, int] | None:
    """The first interval of runs that both trees have."""
    intervals, others = ours.intervals(), theirs.intervals()
    i = j = 0
    while i < len(intervals) and j < len(others):
        first = max(intervals[i][0], others[j][0])
        stop = min(intervals[i][1], others[j][1])
        if first < stop:
            return first, stop
        if intervals[i][1] <= others[j][1]:
            i += 1
        else:
            j += 1
    return None


def _sum(left: Row, right: Row) -> Row:
    if left is None or right is None:
        return right if left is None else left
    return left + right
