"""Scores of labels over many runs: counts are summed, and ratios made of the sums."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics import errors
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.results import Result


@dataclass(frozen=True)
class LabelSummary(Result):
    """Counts over all runs, and the ratios of the sums."""

    runs: int
    """How many runs."""
    counts: dict[str, int]
    """The sum of each count."""

    def ratio(self, parts: str | list[str], whole: str | list[str]) -> float:
        """The sum of some counts over the sum of others; NaN over nothing."""
        above, below = self._sum(parts), self._sum(whole)
        return above / below if below else float("nan")

    @property
    def mota(self) -> float:
        """CLEAR accuracy of all runs: 1 less misses, false positives and switches over the truth;
        1 is best."""
        return 1.0 - self.ratio(["misses", "false_positives", "switches"], "truth")

    @property
    def purity(self) -> float:
        """Share of observations that belong to the main target of their track; 1 is best."""
        return self.ratio("pure", "observations")

    def _sum(self, names: str | list[str]) -> int:
        chosen = [names] if isinstance(names, str) else names
        for name in chosen:
            if name not in self.counts:
                raise ValueError(f"there is no count {name!r}, there are {', '.join(self.counts)}")
        return sum(self.counts[name] for name in chosen)


class LabelAccumulator(Accumulator):
    """Counts over many runs: of misses, switches, fragmentations, or whatever was counted.

    A ratio of a sequence (MOTA, purity) is not averaged over runs: its counts are summed, so that a
    long run weighs more than a short one.

    Examples
    --------
    >>> labels = LabelAccumulator()
    >>> counts = {"truth": [100, 50], "misses": [4, 6]}
    >>> labels.update(counts | {"false_positives": [0, 3], "switches": [1, 1]}, first_run=0)
    >>> labels.result().mota
    0.9
    """

    kind = "LabelAccumulator"

    def __init__(self) -> None:
        super().__init__({})

    def update(self, batch: Mapping[str, Any], first_run: int) -> None:
        """Takes in the counts of a batch of runs, ``{name: (runs,)}``.

        Raises
        ------
        ValueError
            Where a count is negative or no whole number, or runs differ in what is counted.
        """
        counts = {name: _whole(name, batch[name]) for name in sorted(batch)}
        if not counts:
            raise ValueError("batch has no counts")
        (first, column), *others = counts.items()
        for name, values in others:
            if len(values) != len(column):
                raise errors.length(name, len(values), first, len(column), "runs")
        self._require_new(first_run, len(column))
        self._take_shape({"names": list(counts)})
        sums = {name: values.sum(keepdims=True) for name, values in counts.items()}
        self._cover(first_run, len(column))
        self._add_counts(sums)

    def result(self) -> LabelSummary:
        """The sums so far."""
        return LabelSummary(self.runs, {name: int(n[0]) for name, n in self._counts.items()})

    def _sizes(self) -> tuple[int, dict[str, tuple[int, ...]]]:
        return 0, dict.fromkeys((self.shape or {"names": []})["names"], (1,))


def _whole(name: str, values: Any) -> Any:
    array = np.atleast_1d(np.asarray(values))
    if array.ndim != 1:
        raise errors.shape(name, array.shape, "(runs,)")
    for run, value in enumerate(array.tolist()):
        if value < 0 or value != int(value):
            raise errors.parameter(f"{name}[{run}]", "a whole number, at least 0", value)
    return array.astype(np.int64)
