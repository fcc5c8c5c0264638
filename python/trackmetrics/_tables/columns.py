"""Columns of tables: arrays, and lists of different lengths as one flat array."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Ragged:
    """One list a row, of any length: all elements one after the other, and the lengths.

    A row of length 0 is missing.
    """

    flat: NDArray[Any]
    lengths: NDArray[np.int64]
    nested: bool = False
    """Whether rows were lists of lists of equal lengths (matrices), row by row."""

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.lengths)

    @property
    def starts(self) -> NDArray[np.int64]:
        """Where each row begins in ``flat``."""
        starts: NDArray[np.int64] = np.cumsum(self.lengths) - self.lengths
        return starts

    def rows_of_length(self, length: int) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """The rows of this length, and their elements, ``(rows, length)``."""
        rows = np.flatnonzero(self.lengths == length)
        if len(rows) == len(self.lengths):
            return rows, self.flat.reshape(len(rows), length)
        return rows, self.flat[self.starts[rows][:, None] + np.arange(length)]

    def padded(self, width: int, fill: Any) -> NDArray[Any]:
        """``(rows, width)``: the rows side by side, padded at their ends."""
        if len(self.lengths) and (self.lengths == width).all():
            return self.flat.reshape(len(self.lengths), width)
        out = np.full((len(self.lengths), width), fill, self.flat.dtype)
        out[np.arange(width) < self.lengths[:, None]] = self.flat
        return out


def from_padded(values: NDArray[np.float64]) -> Ragged:
    """Rows without the NaN at their ends."""
    width = values.shape[1]
    if width and not np.isnan(values[:, -1]).any():
        return Ragged(values.ravel(), np.full(len(values), width))
    there = ~np.isnan(values)
    lengths = np.where(there.any(axis=1), width - np.argmax(there[:, ::-1], axis=1), 0)
    return Ragged(values[np.arange(width) < lengths[:, None]], lengths.astype(np.int64))
