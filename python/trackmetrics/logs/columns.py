"""The columns of a log: one array each, one row per update.

Columns of states are ``(rows, n)``, of measurements ``(rows, m)`` with ``m`` the longest. What is
missing is NaN: single components, of a matrix with their rows and columns; the end of a shorter
measurement; a whole row.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Strings = NDArray[np.object_]


@dataclass(frozen=True)
class Columns:
    """The columns of a log or of one of its tracks, one row per update; None where absent."""

    time: Floats
    """Time of each update, rising within a track."""
    row: Integers
    """Where the update stood in what was read, for messages."""
    status: Strings | None = None
    """``"tentative"``, ``"active"``, or ``"rejected"``: tested, but not used by the filter."""
    measurement_type: Strings | None = None
    """Name of the kind of measurement."""
    observed: Integers | None = None
    """``(rows, m)``: index of the state that each component observes, -1 for none."""
    z: Floats | None = None
    """Measurement."""
    x_pred: Floats | None = None
    """Predicted state."""
    P_pred: Floats | None = None
    """Its covariance."""
    innovation: Floats | None = None
    """Measurement minus predicted measurement."""
    S: Floats | None = None
    """Covariance of the innovation."""
    R: Floats | None = None
    """Covariance of the measurement's noise."""
    H: Floats | None = None
    """``(rows, m, n)``: how each component of the measurement depends on the states."""
    nis: Floats | None = None
    """Normalised innovation squared."""
    nis_dof: Floats | None = None
    """Its degrees of freedom."""
    x: Floats | None = None
    """Updated state."""
    P: Floats | None = None
    """Its covariance."""
    A: Floats | None = None
    """``(I - K H) F``: how the error of the last update enters this one."""
    truth: Floats | None = None
    """True state."""
    error: Floats | None = None
    """Updated state minus truth, angles wrapped."""
    nees: Floats | None = None
    """Normalised estimation error squared, after the update."""
    nees_dof: Floats | None = None
    """Its degrees of freedom."""
    std: Floats | None = None
    """Claimed standard deviation of each state, after the update."""

    def __len__(self) -> int:
        """How many rows."""
        return len(self.time)

    def take(self, rows: Any) -> "Columns":
        """These rows of every column."""
        return Columns(**{k: v[rows] for k, v in vars(self).items() if v is not None})

    def replace(self, **columns: Any) -> "Columns":
        """The same with other values in some columns."""
        return dataclasses.replace(self, **columns)


def has_value(column: Floats) -> NDArray[np.bool_]:
    """Which rows of a column have a value."""
    if not len(column):
        return np.zeros(0, bool)
    rows = column.reshape(len(column), -1)
    if not rows.shape[1]:
        return np.zeros(len(column), bool)
    # Most rows have their first element: only the others are looked at further.
    there: NDArray[np.bool_] = ~np.isnan(rows[:, 0])
    if not there.all():
        others = np.flatnonzero(~there)
        there[others] = ~np.isnan(rows[others]).all(axis=1)
    return there


def rows_missing_components(vectors: Floats, types: Strings | str | None) -> NDArray[np.bool_]:
    """Which rows lack a component that they, or others of their type, have later on.

    A single text is the type of all rows.
    """
    if isinstance(types, str):
        types = np.full(len(vectors), types, object)
    there = ~np.isnan(vectors)
    lacking = np.zeros(len(vectors), bool)
    for type_ in {None} if types is None else set(types):
        rows = slice(None) if types is None else np.flatnonzero(types == type_)
        own = there[rows]
        # Without types a row may end early because it is another kind.
        expected = own.any(axis=0) if type_ is not None else _up_to_the_last(own)
        lacking[rows] = own.any(axis=1) & (expected & ~own).any(axis=1)
    return lacking


def _up_to_the_last(there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    upto: NDArray[np.bool_] = np.logical_or.accumulate(there[:, ::-1], axis=1)[:, ::-1]
    return upto
