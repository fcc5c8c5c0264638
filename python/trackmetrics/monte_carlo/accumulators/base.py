"""The base of all accumulators: the same bits for runs in any order and in any batches."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, _deprecated
from trackmetrics.monte_carlo import serialization
from trackmetrics.monte_carlo.run_tree import (
    MAX_LEVEL,
    MAX_RUNS,
    Floats,
    RunTree,
    dyadic_blocks,
    first_overlap,
)

Counts = NDArray[np.int64]


class Accumulator(ABC):
    """Sums over runs on the tree of run numbers, and counts, which add up the same in any order.

    Memory is O(numbers of one run x log runs). A subclass sets ``kind``, keeps what it was made
    with in ``settings`` (of numbers, strings and lists) and what it learns from its first run in
    ``shape``.
    """

    kind: ClassVar[str]

    def __init__(self, settings: dict[str, Any]) -> None:
        self.settings = settings
        self.shape: dict[str, Any] | None = None
        self._tree = RunTree()
        self._counts: dict[str, Counts] = {}
        self._skipped = 0

    @property
    def runs(self) -> int:
        """Number of runs with a result."""
        return len(self._tree) - self._skipped

    @property
    def intervals(self) -> list[tuple[int, int]]:
        """Runs that were added, those without a result included, as pairs ``first, stop``."""
        return self._tree.intervals()

    def __repr__(self) -> str:
        intervals = ", ".join(f"{first}..{stop}" for first, stop in self.intervals)
        return f"<{type(self).__name__} of {self.runs} runs{intervals and ': '}{intervals}>"

    def add_empty_runs(self, first_run: int, runs: int = 1) -> None:
        """Adds runs without a result: they count as done and change no sum."""
        self._require_new(first_run, runs)
        self._cover(first_run, runs)
        self._skipped += runs

    def merge(self, other: Self) -> None:
        """Adds the runs of ``other``, which must be other runs, accumulated in the same way.

        Raises
        ------
        ValueError
            Where ``other`` was made with other settings or shapes, or has a run that is here too.
        """
        self.require_mergeable(other)
        if self.shape is None:
            self.shape = other.shape
        self._tree.merge(other._tree)
        self._add_counts(other._counts)
        self._skipped += other._skipped

    def require_mergeable(self, other: "Accumulator") -> None:
        """Raise what :meth:`merge` would raise, and change nothing."""
        if type(other) is not type(self):
            raise TypeError(f"cannot merge a {type(other).__name__} into a {self.kind}")
        if other.settings != self.settings:
            raise ValueError(_difference("settings", self.settings, other.settings))
        if self.shape is not None and other.shape is not None and self.shape != other.shape:
            raise ValueError(_difference("shapes", self.shape, other.shape))
        if overlap := first_overlap(self._tree, other._tree):
            raise ValueError(f"the runs {overlap[0]}..{overlap[1]} are in both")

    def to_bytes(self) -> bytes:
        """Everything as bytes: the same bytes for the same runs, however they were cut."""
        nodes = list(self._tree)
        rows = [row for _, _, row in nodes if row is not None]
        arrays: dict[str, NDArray[Any]] = {
            "nodes": np.array([[s, lv, r is not None] for s, lv, r in nodes], np.int64),
            "rows": np.stack(rows) if rows else np.empty((0, 0)),
            **{f"count {name}": counts for name, counts in sorted(self._counts.items())},
        }
        header = {
            "settings": self.settings,
            "shape": self.shape,
            "skipped": self._skipped,
            "top": self._tree.max_level,
        }
        return serialization.pack(self.kind, header, arrays)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """What ``to_bytes`` was called on.

        Raises
        ------
        ValueError
            Where ``data`` are damaged, of another kind, or of a format that this version cannot
            read. Sizes are checked before memory is taken for them.
        """
        with serialization.refusing_malformed():
            header, arrays = serialization.unpack(data, cls.kind)
            made = cls._from_settings(header["settings"])
            made._read_header(header)
            made._read_nodes(arrays.pop("nodes"), arrays.pop("rows"))
            prefix = "count "
            made._counts = {name.removeprefix(prefix): array for name, array in arrays.items()}
            made._require_sizes()
            return made

    def _read_header(self, header: dict[str, Any]) -> None:
        shape, top = header["shape"], serialization.whole(header["top"])
        if not isinstance(self.settings, dict) or not isinstance(shape, dict | None):
            raise ValueError("settings and shape must be mappings")
        if not 0 <= top <= MAX_LEVEL:
            raise ValueError(f"level {top} of {MAX_LEVEL}")
        self.shape, self._tree = shape, RunTree(top)
        self._skipped = serialization.whole(header["skipped"])

    def _read_nodes(self, nodes: NDArray[Any], rows: NDArray[Any]) -> None:
        """The tree of the runs; nodes must be aligned, in order and without overlap."""
        if nodes.dtype != np.int64 or rows.dtype != np.float64 or rows.ndim != 2:
            raise ValueError("nodes and rows have other types")
        given_rows, end = iter(rows), 0
        for start, level, has_row in nodes.reshape(-1, 3).tolist():
            valid = 0 <= level <= self._tree.max_level and has_row in (0, 1)
            if not valid or start < end or start % (1 << level) or start >= MAX_RUNS:
                raise ValueError(f"node ({start}, {level}) is not one")
            end = start + (1 << level)
            self._tree.add(start, level, next(given_rows) if has_row else None)
        if sum(nodes.reshape(-1, 3)[:, 2].tolist()) != len(rows):
            raise ValueError("as many rows as nodes with one")
        if not 0 <= self._skipped <= len(self._tree):
            raise ValueError(f"{self._skipped} runs skipped of {len(self._tree)}")

    def _require_sizes(self) -> None:
        """Whether sums and counts have the sizes that settings and shape give them."""
        expected = self._sizes()
        if expected is None:
            return
        width, counts = expected
        widths = {len(row) for _, _, row in self._tree if row is not None}
        found = {name: array.shape for name, array in self._counts.items()}
        if widths - {width} or found != (counts if self.runs or found else {}):
            raise ValueError("sums or counts have other sizes than the shape says")

    def _sizes(self) -> tuple[int, dict[str, tuple[int, ...]]] | None:
        """Numbers of a row of sums, and the shape of each count; None where it is not known."""
        return None

    @abstractmethod
    def result(self) -> Any:
        """The statistics of the runs so far."""

    @classmethod
    def _from_settings(cls, settings: dict[str, Any]) -> Self:
        made = cls.__new__(cls)
        Accumulator.__init__(made, settings)
        return made

    def empty_copy(self) -> Self:
        """An accumulator with the same settings and no run."""
        made = self._from_settings(self.settings)
        made._tree.max_level = self._tree.max_level
        return made

    def renumbered(self, run: int) -> Self:
        """A copy of one run, numbered 0, as the run of this number."""
        nodes = list(self._tree)
        if [(start, level) for start, level, _ in nodes] != [(0, 0)]:
            raise ValueError(
                f"an accumulator of one run must hold run 0, this holds {self.intervals}"
            )
        made = self.empty_copy()
        made.shape, made._counts, made._skipped = self.shape, self._counts, self._skipped
        made._tree.add(run, 0, nodes[0][2])
        return made

    covered = _deprecated.attribute("intervals")
    skip = _deprecated.attribute("add_empty_runs")
    moved_to = _deprecated.attribute("renumbered")

    def _cover(self, first_run: int, runs: int) -> None:
        """Says that these runs are in, without sums."""
        for start, level in dyadic_blocks(first_run, first_run + runs, self._tree.max_level):
            self._tree.add(start, level, None)

    def _add_nodes(
        self, first_run: int, runs: int, rows: Floats, counts: dict[str, Counts]
    ) -> None:
        """Takes in the rows of the dyadic blocks of a batch of runs."""
        nodes = dyadic_blocks(first_run, first_run + runs, self._tree.max_level)
        for (start, level), row in zip(nodes, rows, strict=True):
            self._tree.add(start, level, row)
        self._add_counts(counts)

    def _add_counts(self, counts: dict[str, Counts]) -> None:
        for name, array in counts.items():
            known = self._counts.get(name)
            self._counts[name] = array.copy() if known is None else known + array

    def _require_new(self, first_run: int, runs: int) -> None:
        _check.count("first_run", first_run, 0)
        new = RunTree()
        for start, level in dyadic_blocks(first_run, first_run + runs):
            new.add(start, level, None)
        if overlap := first_overlap(self._tree, new):
            raise ValueError(f"the runs {overlap[0]}..{overlap[1]} are in already")

    def _take_shape(self, shape: dict[str, Any]) -> None:
        """Every run has the shape of the first."""
        if self.shape is None:
            self.shape = shape
        elif self.shape != shape:
            raise ValueError(_difference("shapes", self.shape, shape))

    def _total(self) -> Floats | None:
        return self._tree.total()


def _difference(what: str, ours: dict[str, Any], theirs: dict[str, Any]) -> str:
    names = [name for name in {**ours, **theirs} if ours.get(name) != theirs.get(name)]
    parts = (f"{name} is {theirs.get(name)}, expected {ours.get(name)}" for name in names)
    return f"runs of other {what}: {'; '.join(parts)}"
