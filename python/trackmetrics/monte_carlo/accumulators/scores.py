"""Scores of runs: means over runs, and paired differences between settings."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _deprecated
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.run_tree import Floats

BLOCKS = 1024
"""Of more runs than this, blocks of equally many are kept."""


def block_level_for(runs: int) -> int:
    """The least level of blocks that are at most ``BLOCKS`` for this many runs."""
    return max(0, (max(runs, 1) - 1) // BLOCKS).bit_length()


class ScoreAccumulator(Accumulator):
    """Scores of runs by name, kept run by run up to 1024 runs, and by blocks of runs above.

    Two settings that saw the same random numbers are compared by the differences of their runs, or
    of the means of their blocks, which have less variance than the scores themselves.

    Parameters
    ----------
    block_level : int
        A block is ``2**block_level`` runs.

    Examples
    --------
    >>> scores = ScoreAccumulator()
    >>> scores.update({"ospa": [1.0, 3.0]}, first_run=0)
    >>> scores.means()
    {'ospa': 2.0}
    """

    kind = "ScoreAccumulator"

    @_deprecated.parameters(level="block_level")
    def __init__(self, block_level: int = 0) -> None:
        super().__init__({})
        self._tree.max_level = block_level

    def update(self, batch: Mapping[str, Any], first_run: int) -> None:
        """Takes in scores of runs, ``{name: (runs,)}``; NaN for a run that has none."""
        names = list(batch)
        values = np.array([batch[name] for name in names], dtype=np.float64).T
        if values.ndim != 2:
            raise ValueError("scores must be one number a run for every name")
        if np.isinf(values).any():
            run, column = np.argwhere(np.isinf(values))[0]
            raise ValueError(f"{names[column]}[{run}] is not finite: {values[run, column]}")
        runs = len(values)
        self._require_new(first_run, runs)
        self._take_shape({"names": names})
        given = ~np.isnan(values)
        columns = np.ascontiguousarray(np.hstack([np.where(given, values, 0.0), given]))
        for start, stop in self._blocks(first_run, first_run + runs):
            rows = _backend.kernels.run_sums(columns[start - first_run : stop - first_run], start)
            self._add_nodes(start, stop - start, rows, {})

    def _blocks(self, first: int, stop: int) -> list[tuple[int, int]]:
        """The runs, cut where blocks end, so that no node is larger than a block."""
        size = 1 << self._tree.max_level
        cuts = [first, *range((first // size + 1) * size, stop, size), stop]
        return [(a, b) for a, b in pairwise(cuts) if a < b]

    coarsen = _deprecated.attribute("merge_blocks")

    def merge_blocks(self, level: int) -> None:
        """Joins blocks into blocks of ``2**level`` runs."""
        self._tree.raise_max_level(max(level, self._tree.max_level))

    @property
    def names(self) -> list[str]:
        """The scores."""
        return list(self.shape["names"]) if self.shape else []

    def result(self) -> dict[str, float]:
        """As :meth:`means`."""
        return self.means()

    def means(self) -> dict[str, float]:
        """The mean of each score over the runs that have it; NaN where none has."""
        total = self._total()
        if total is None:
            return dict.fromkeys(self.names, float("nan"))
        sums, counts = np.split(total, 2)
        with np.errstate(invalid="ignore"):
            return dict(zip(self.names, (sums / counts).tolist(), strict=True))

    def blocks(self, name: str) -> tuple[NDArray[np.int64], Floats]:
        """First run and mean score of each complete block, in the order of the runs."""
        column, level = self.names.index(name), self._tree.max_level
        starts, means = [], []
        for start, height, row in self._tree:
            if height == level and row is not None and row[len(row) // 2 + column] == 1 << level:
                starts.append(start)
                means.append(row[column] / (1 << level))
        return np.array(starts, np.int64), np.array(means, np.float64)

    def _sizes(self) -> tuple[int, dict[str, tuple[int, ...]]]:
        return 2 * len(self.names), {}
