"""The global assignment of hypotheses to objects that the ID metrics are counted from."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from trackmetrics._tables.data_frames import pandas
from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.compat.motmetrics import lap
from trackmetrics.compat.motmetrics._frame_map import DataFrameMap

Codes = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class IdentityCounts:
    """Frames of each object, of each hypothesis, and of each pair with a finite distance."""

    objects: NDArray[Any]
    object_frames: Codes
    hypotheses: NDArray[Any]
    hypothesis_frames: Codes
    pairs: tuple[Codes, Codes, Codes]
    """Index of the object, index of the hypothesis, number of frames."""

    @classmethod
    def of(cls, df: DataFrameMap) -> "IdentityCounts":
        """Count the raw events of a sequence."""
        columns = df.raw_columns
        objects, i = _factorized(columns.objects)
        hypotheses, j = _factorized(columns.hypotheses)
        near = (i >= 0) & (j >= 0) & ~np.isnan(columns.distances)
        keys, numbers = np.unique(i[near] * len(hypotheses) + j[near], return_counts=True)
        width = max(len(hypotheses), 1)
        return cls(
            objects,
            _frames_of(i, columns.frames, len(objects)),
            hypotheses,
            _frames_of(j, columns.frames, len(hypotheses)),
            (keys // width, keys % width, numbers.astype(np.int64)),
        )

    def true_positives(self) -> int:
        """Largest number of frames that a one-to-one assignment of hypotheses has."""
        return sum(self._blocks())

    def _blocks(self) -> Iterator[int]:
        """The assignment of each connected part of the graph of pairs."""
        i, j, numbers = self.pairs
        if not len(numbers):
            return
        sides = len(self.objects), len(self.hypotheses)
        graph = coo_array((numbers, (i, sides[0] + j)), shape=(sum(sides), sum(sides)))
        _, component = connected_components(graph, directed=False)
        order = np.argsort(component[i], kind="stable")
        starts = np.flatnonzero(np.diff(component[i][order])) + 1
        for part in np.split(order, starts):
            rows, row = np.unique(i[part], return_inverse=True)
            columns, column = np.unique(j[part], return_inverse=True)
            table = np.zeros((len(rows), len(columns)))
            table[row, column] = numbers[part]
            yield int(table[linear_sum_assignment(table, maximize=True)].sum())


def _factorized(ids: NDArray[Any]) -> tuple[NDArray[Any], Codes]:
    """Sorted ids, and the index of each row's id; -1 for none."""
    codes, names = pandas().factorize(ids, sort=True)
    return np.asarray(names), codes.astype(np.int64)


def _frames_of(codes: Codes, frames: Codes, number: int) -> Codes:
    """Number of different frames of each id."""
    present = codes >= 0
    width = int(frames.max()) + 1 if len(frames) else 1
    keys = np.unique(codes[present] * width + frames[present])
    return np.bincount(keys // width, minlength=number).astype(np.int64)


def extract_counts_from_df_map(df: DataFrameMap) -> tuple[dict[Any, int], ...]:
    """Frames of each object, of each hypothesis, and of each pair (object, hypothesis) within the
    threshold, as dicts."""
    counts = IdentityCounts.of(df)
    objects, hypotheses = counts.objects.tolist(), counts.hypotheses.tolist()
    pairs = zip(*(column.tolist() for column in counts.pairs), strict=True)
    return (
        dict(zip(objects, counts.object_frames.tolist(), strict=True)),
        dict(zip(hypotheses, counts.hypothesis_frames.tolist(), strict=True)),
        {(objects[i], hypotheses[j]): number for i, j, number in pairs},
    )


class IdentityAssignment(dict[str, Any]):
    """py-motmetrics' dict of the global assignment.

    ``fpmatrix``, ``fnmatrix``, ``costs`` of shape (N + M, N + M), ``rids``, ``cids`` and
    ``min_cost``; the matrices are made when one of them, or what the dict holds, is asked for.
    """

    def __init__(self, counts: IdentityCounts) -> None:
        super().__init__()
        self.counts = counts
        tp = counts.true_positives()
        self.idfp = float(counts.hypothesis_frames.sum() - tp)
        self.idfn = float(counts.object_frames.sum() - tp)

    def __missing__(self, key: str) -> Any:
        self._fill()
        if key not in dict.keys(self):
            raise KeyError(key)
        return dict.__getitem__(self, key)

    def _fill(self) -> None:
        if dict.__len__(self):
            return
        counts = self.counts
        n, m = len(counts.objects), len(counts.hypotheses)
        fp, fn = np.zeros((n + m, n + m)), np.zeros((n + m, n + m))
        fp[:n, :m] = counts.hypothesis_frames
        fn[:n, :m] = counts.object_frames[:, None]
        fp[n:, :m], fn[:n, m:] = np.nan, np.nan
        fn[np.arange(n), m + np.arange(n)] = counts.object_frames
        fp[n + np.arange(m), np.arange(m)] = counts.hypothesis_frames
        i, j, numbers = counts.pairs
        fp[i, j] -= numbers
        fn[i, j] -= numbers
        costs = fp + fn
        rows, columns = lap.linear_sum_assignment(costs)
        self.update(fpmatrix=fp, fnmatrix=fn, rids=rows, cids=columns, costs=costs)
        self["min_cost"] = costs[rows, columns].sum()

    def keys(self) -> Any:
        """Names of the parts."""
        self._fill()
        return super().keys()

    def values(self) -> Any:
        """The parts."""
        self._fill()
        return super().values()

    def items(self) -> Any:
        """Names and parts."""
        self._fill()
        return super().items()

    def get(self, key: str, default: Any = None) -> Any:
        """A part, or ``default``."""
        self._fill()
        return super().get(key, default)

    def __iter__(self) -> Iterator[str]:
        self._fill()
        return super().__iter__()

    def __len__(self) -> int:
        self._fill()
        return super().__len__()

    def __contains__(self, key: object) -> bool:
        self._fill()
        return super().__contains__(key)
