"""The columns of a log: what each holds, and how what users have becomes one array each.

Columns of states are ``(rows, n)``, of measurements ``(rows, m)`` with ``m`` the longest. What is
missing is NaN: single components, of a matrix with their rows and columns; the end of a shorter
measurement; a whole row. Covariances may also come as their upper triangles, row by row.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Words = NDArray[np.object_]

NUMBERS = ("nis", "nis_dof", "nees", "nees_dof")
DOFS = ("nis_dof", "nees_dof")
STATES = ("x_pred", "x", "truth", "error", "std")
STATE_MATRICES = ("P_pred", "P", "A")
MEASUREMENTS = ("z", "innovation")
MEASUREMENT_MATRICES = ("S", "R")
OBSERVATIONS = ("H",)
WORDS = ("status", "measurement_type")
FLOATS = NUMBERS + STATES + STATE_MATRICES + MEASUREMENTS + MEASUREMENT_MATRICES + OBSERVATIONS
KNOWN = ("track", "time", "observed", *WORDS, *FLOATS)
COVARIANCES = ("P_pred", "P", "S", "R")


@dataclass(frozen=True)
class Columns:
    """The columns of a log or of one of its tracks, one row per update; None where absent."""

    time: Floats
    """Time of each update, rising within a track."""
    row: Integers
    """Where the update stood in what was read, for messages."""
    status: Words | None = None
    """``"tentative"``, ``"active"``, or ``"rejected"``: tested, but not used by the filter."""
    measurement_type: Words | None = None
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

    def with_(self, **columns: Any) -> "Columns":
        """The same with other values in some columns."""
        return replace(self, **columns)


def numbers(name: str, values: Any, rows: int) -> Floats:
    """One number a row; a single number stands for all rows, None for a missing one."""
    if np.ndim(values) == 0 and not isinstance(values, (str, bytes)):
        values = [values] * rows
    column = _floats(name, ["nan" if v is None else v for v in values], (len(values),))
    if len(column) != rows:
        raise ValueError(f"{name} has {len(column)} rows, the log has {rows}")
    return column


def words(name: str, values: Any, rows: int) -> Words:
    """One word a row; a single word stands for all rows, None for no word."""
    listed = [values] * rows if isinstance(values, str) else list(values)
    if len(listed) != rows:
        raise ValueError(f"{name} has {len(listed)} rows, the log has {rows}")
    column = np.empty(rows, object)
    column[:] = [None if _missing(v) else str(v) for v in listed]
    return column


def vectors(name: str, values: Any, rows: int, width: int | None) -> Floats:
    """One vector a row, padded with NaN to ``width`` or else to the longest."""
    array = _whole(values, 2, rows, width)
    if array is not None:
        return array
    listed = _rows(name, values, rows)
    parts = [np.empty(0) if v is None else _floats(f"{name}[{i}]", v, (-1,)) for i, v in listed]
    longest = max((len(p) for p in parts), default=0)
    if width is not None and longest > width:
        i = next(i for i, p in enumerate(parts) if len(p) > width)
        raise ValueError(f"{name}[{i}] has {len(parts[i])} components, expected {width}")
    column = np.full((rows, longest if width is None else width), np.nan)
    for i, part in enumerate(parts):
        column[i, : len(part)] = part
    return column


def matrices(name: str, values: Any, rows: int, width: int | None) -> Floats:
    """One square matrix a row, or the upper triangle of a covariance, padded with NaN."""
    array = _whole(values, 3, rows, width)
    if array is not None and array.shape[1] == array.shape[2]:
        return array
    empty = np.empty((0, 0))
    listed = _rows(name, values, rows)
    parts = [empty if v is None else _square(f"{name}[{i}]", v, width) for i, v in listed]
    longest = max((len(p) for p in parts), default=0)
    if width is not None and longest > width:
        i = next(i for i, p in enumerate(parts) if len(p) > width)
        found = parts[i].shape
        raise ValueError(f"{name}[{i}] has shape {found}, expected {(width, width)}")
    size = longest if width is None else width
    column = np.full((rows, size, size), np.nan)
    for i, part in enumerate(parts):
        column[i, : len(part), : len(part)] = part
    return column


def observations(name: str, values: Any, rows: int, states: int) -> Floats:
    """One ``(m, n)`` matrix a row, or all its elements row by row, padded with NaN rows."""
    listed = _rows(name, values, rows)
    empty = np.empty((0, states))
    parts = [empty if v is None else _observation(f"{name}[{i}]", v, states) for i, v in listed]
    column = np.full((rows, max((len(p) for p in parts), default=0), states), np.nan)
    for i, part in enumerate(parts):
        column[i, : len(part)] = part
    return column


def _observation(name: str, value: Any, states: int) -> Floats:
    matrix = np.asarray(value, np.float64)
    if matrix.ndim == 1 and states and matrix.size % states == 0:
        return matrix.reshape(-1, states)
    if matrix.ndim != 2 or matrix.shape[1] != states:
        raise ValueError(f"{name} has shape {matrix.shape}, expected (m, {states})")
    return matrix


def components(vectors: Floats, covariances: Floats) -> NDArray[np.bool_]:
    """``(rows, m)``: which components have both a value and a variance."""
    there: NDArray[np.bool_] = ~np.isnan(vectors)
    return there & ~np.isnan(covariances.diagonal(axis1=1, axis2=2))


def present(column: Floats) -> NDArray[np.bool_]:
    """Which rows of a column have a value."""
    if not len(column):
        return np.zeros(0, bool)
    there: NDArray[np.bool_] = np.logical_not(np.isnan(column.reshape(len(column), -1)).all(axis=1))
    return there


def incomplete(vectors: Floats, kinds: Words | str | None) -> NDArray[np.bool_]:
    """Which rows lack a component although they, or others of their kind, have a later one.

    A single word is the kind of all rows.
    """
    if isinstance(kinds, str):
        kinds = np.full(len(vectors), kinds, object)
    there = ~np.isnan(vectors)
    lacking = np.zeros(len(vectors), bool)
    for kind in {None} if kinds is None else set(kinds):
        rows = slice(None) if kinds is None else np.flatnonzero(kinds == kind)
        own = there[rows]
        # Without kinds a row may end early because it is another kind.
        expected = own.any(axis=0) if kind is not None else _up_to_the_last(own)
        lacking[rows] = own.any(axis=1) & (expected & ~own).any(axis=1)
    return lacking


def _up_to_the_last(there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    upto: NDArray[np.bool_] = np.logical_or.accumulate(there[:, ::-1], axis=1)[:, ::-1]
    return upto


def indices(name: str, values: Any, rows: int, states: Mapping[str, int]) -> Integers:
    """The states that each row observes, by name or index, padded with -1."""
    if isinstance(values, Mapping):
        raise TypeError(f"{name} must hold one list of states a row")
    if _are_indices(values, rows, max(len(states), 1)):
        return np.array(values, np.int64)
    listed = [() if _missing(v) else v for v in values]
    if len(listed) != rows:
        raise ValueError(f"{name} has {len(listed)} rows, the log has {rows}")
    found = [[state_index(f"{name}[{i}]", s, states) for s in row] for i, row in enumerate(listed)]
    column = np.full((rows, max(map(len, found), default=0)), -1, np.int64)
    for i, part in enumerate(found):
        column[i, : len(part)] = part
    return column


def _are_indices(values: Any, rows: int, states: int) -> bool:
    """Whether a column is a whole array of indices: no element needs a look by itself."""
    if not isinstance(values, np.ndarray) or values.ndim != 2 or values.dtype.kind != "i":
        return False
    return len(values) == rows and bool(((values >= -1) & (values < states)).all())


def state_index(name: str, state: Any, states: Mapping[str, int]) -> int:
    """The index of a state that is named by its name or index; -1 stays."""
    if isinstance(state, str):
        if state in states:
            return states[state]
        raise ValueError(f"{name}: no state {state!r}; the log has {', '.join(states) or 'none'}")
    index = int(state)
    if index != state or not -1 <= index < max(len(states), 1):
        raise ValueError(f"{name}: no state {state!r}; the log has {len(states)} states")
    return index


def _missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and np.isnan(value))


def _rows(name: str, values: Any, rows: int) -> Iterable[tuple[int, Any]]:
    listed: Sequence[Any] = values
    if len(listed) != rows:
        raise ValueError(f"{name} has {len(listed)} rows, the log has {rows}")
    return enumerate(None if _missing(v) else v for v in listed)


def _floats(name: str, values: Any, shape: tuple[int, ...]) -> Floats:
    try:
        return np.asarray(values, np.float64).reshape(shape)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must hold numbers, got {values!r}"[:200]) from None


def _whole(values: Any, axes: int, rows: int, width: int | None) -> Floats | None:
    """A column that already is one array of the right form, as float64."""
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        return None
    if values.ndim != axes or len(values) != rows or width not in (None, values.shape[-1]):
        return None
    return np.array(values, np.float64)


def _square(name: str, value: Any, width: int | None) -> Floats:
    """A matrix, from its rows, from all its elements or from its upper triangle."""
    matrix = np.asarray(value, np.float64)
    if matrix.ndim == 2 and matrix.shape[0] == matrix.shape[1]:
        return matrix
    size, full = matrix.size, math.isqrt(matrix.size)
    half = math.isqrt(2 * size)
    whole, triangle = full * full == size, half * (half + 1) == 2 * size
    if matrix.ndim < 2 and whole and (not triangle or width in (None, full)):
        return matrix.reshape(full, full)
    if matrix.ndim < 2 and triangle:
        return _from_triangle(matrix.ravel(), half)
    raise ValueError(f"{name} has shape {matrix.shape}, expected a square matrix")


def _from_triangle(flat: Floats, n: int) -> Floats:
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n)] = flat
    return matrix + np.triu(matrix, 1).T
