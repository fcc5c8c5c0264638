"""The innovations of some updates of a track, and their whitening."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _covariances
from trackmetrics.diagnostics.results import Bias
from trackmetrics.logs.columns import Columns, Floats, Integers, Strings


@dataclass(frozen=True, eq=False)
class Innovations:
    """The innovations of some updates of a track, NaN where a component is missing."""

    values: Floats
    covariances: Floats
    types: Strings
    """The measurement type of each update; empty strings if unknown."""

    def __len__(self) -> int:
        """The number of updates."""
        return len(self.values)

    @cached_property
    def valid(self) -> NDArray[np.bool_]:
        """Which components have a value."""
        valid: NDArray[np.bool_] = ~np.isnan(self.values)
        return valid

    @cached_property
    def whitened(self) -> Floats:
        """Whitened update by update, 0 where a component is missing."""
        return _covariances.whitened(self.values, self.covariances, self.valid)

    @property
    def sums(self) -> tuple[float, float]:
        """The NIS of all updates together, and its degrees of freedom."""
        return float((self.whitened**2).sum()), float(self.valid.sum())

    @property
    def scale(self) -> float:
        """The mean NIS per degree of freedom; 1 if consistent."""
        total, dof = self.sums
        return total / dof


def innovations_at(
    rows: Integers, columns: Columns, values: Floats, covariances: Floats
) -> Innovations:
    """The innovations (wrapped) of these updates, of each the components that have a variance."""
    valid = _covariances.valid_components(values[rows], covariances[rows])
    some = valid.any(axis=1)
    rows, valid = rows[some], valid[some]
    types = columns.measurement_type
    names = np.full(len(rows), "", object) if types is None else types[rows].astype(str)
    kept = np.where(valid, values[rows], np.nan)
    return Innovations(kept, covariances[rows], names.astype(object))


def subtract_biases(innovations: Innovations, biases: Sequence[Bias]) -> Innovations:
    """The innovations minus the biases of their components; the same object where there is none."""
    if not biases:
        return innovations
    values = innovations.values.copy()
    for bias in biases:
        values[innovations.types == (bias.measurement_type or ""), bias.index] -= bias.value
    return Innovations(values, innovations.covariances, innovations.types)
