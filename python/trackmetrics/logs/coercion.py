"""What users hold, as one array a column.

A column may be an array, a list with None for missing rows, a masked array, or a
:class:`~trackmetrics._tables.columns.Ragged` column from a file. Arrays and ragged columns are
converted whole; only lists of Python objects are walked.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.columns import Ragged
from trackmetrics._tables.errors import shown, value
from trackmetrics.logs.columns import Floats, Integers, Strings
from trackmetrics.logs.schema import COVARIANCE_FORMS

_MISSING_TYPES = ("NAType", "NaTType", "MaskedConstant")


def as_scalars(name: str, values: Any, rows: int) -> Floats:
    """One number a row; a single number stands for all rows, None for a missing one."""
    if np.ndim(values) == 0 and not isinstance(values, (str, bytes, Ragged)):
        values = [values] * rows
    _check_rows(name, values, rows)
    if isinstance(values, Ragged):
        if (values.lengths > 1).any():
            row = int(np.argmax(values.lengths > 1))
            raise ValueError(f"{name}[{row}] must be a number, got {values.lengths[row]} numbers")
        values = values.padded(1, np.nan)[:, 0]
    array = _filled(values)
    if array is None:
        array = np.array([_number(name, i, v) for i, v in enumerate(values)], np.float64)
    return _shaped(name, array, (rows,))


def as_strings(name: str, values: Any, rows: int) -> Strings:
    """One text a row; a single text stands for all rows, None for a missing one."""
    if isinstance(values, str):
        values = [values] * rows
    _check_rows(name, values, rows)
    if isinstance(values, Ragged):
        raise ValueError(f"{name}[0] must be text, got a list")
    column = np.empty(rows, object)
    if isinstance(values, np.ndarray) and values.dtype.kind in "fiu":
        column[:] = _number_texts(values)
        return column
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if not set(map(type, listed)) <= {str, type(None)}:
        listed = [None if is_missing(v) else _as_text(name, i, v) for i, v in enumerate(listed)]
    column[:] = listed
    return column


def _as_text(name: str, row: int, given: Any) -> str:
    if isinstance(given, (list, tuple, dict, np.ndarray)):
        raise ValueError(f"{name}[{row}] must be text, got {value(given)}")
    return given.decode() if isinstance(given, bytes) else str(given)


def _number_texts(values: NDArray[Any]) -> list[str | None]:
    """Numbers as text, whole ones without a point; a text for each different one."""
    different, place = np.unique(values, return_inverse=True)
    texts = np.array([None if v != v else _text(v) for v in different.tolist()], object)
    return list(texts[place])


def _text(number: Any) -> str:
    return str(int(number)) if float(number).is_integer() else str(number)


def as_vectors(name: str, values: Any, rows: int, width: int | None) -> Floats:
    """One vector a row, padded with NaN to ``width`` or else to the longest."""
    array = _whole(values, 2, rows, width)
    if array is not None:
        return array
    ragged = as_ragged(name, values, rows)
    longest = int(ragged.lengths.max(initial=0))
    if width is not None and longest > width:
        row = int(np.argmax(ragged.lengths > width))
        raise ValueError(f"{name}[{row}] has {ragged.lengths[row]} components, expected {width}")
    return ragged.padded(longest if width is None else width, np.nan)


def as_matrices(
    name: str,
    values: Any,
    rows: int,
    width: int | None,
    sizes: Integers | None = None,
    form: str | None = None,
    *,
    may_be_smaller: bool = False,
) -> Floats:
    """One square matrix a row, padded with NaN.

    A row is a matrix, or a list of all its elements, of its upper triangle row by row, or of its
    diagonal: which, the number of elements decides with ``sizes`` (the size of each row's matrix, 0
    where it is not known). Where it is not known, two readings are an error; ``form`` decides. A
    matrix smaller than its size is an error unless it ``may_be_smaller``.
    """
    if form is not None and form not in COVARIANCE_FORMS:
        raise ValueError(
            f"covariance_forms[{name!r}] must be one of {shown(COVARIANCE_FORMS)}, "
            f"got {value(form)}"
        )
    if sizes is None:
        sizes = np.full(rows, width or 0)
    array = _whole(values, 3, rows, width)
    if array is not None and array.shape[1] == array.shape[2]:
        _check_size(name, array.shape[1], sizes, np.arange(rows))
        return array
    ragged = as_ragged(name, values, rows, square=True)
    largest = 0
    blocks = []
    most = int(sizes.max(initial=0)) + 1
    keys = ragged.lengths * most + sizes
    for key in np.flatnonzero(np.bincount(keys, minlength=1)).tolist():
        length, size = divmod(key, most)
        if not length:
            continue
        own = np.flatnonzero(keys == key)
        found = _form(f"{name}[{own[0]}]", length, size, form, ragged.nested)
        elements = (
            ragged.rows_of_length(length)[1]
            if len(own) == rows
            else (ragged.flat[ragged.starts[own][:, None] + np.arange(length)])
        )
        matrices = _FROM[found](np.asarray(elements, np.float64))
        if not may_be_smaller:
            _check_size(name, matrices.shape[1], sizes, own)
        largest = max(largest, matrices.shape[1])
        if width is not None and matrices.shape[1] > width:
            got = matrices.shape[1:]
            raise ValueError(f"{name}[{own[0]}] has shape {got}, expected {(width, width)}")
        blocks.append((own, matrices))
    size = largest if width is None else width
    if len(blocks) == 1 and len(blocks[0][0]) == rows and largest == size:
        return blocks[0][1]
    column = np.full((rows, size, size), np.nan)
    for own, matrices in blocks:
        n = matrices.shape[1]
        column[own[:, None, None], np.arange(n)[:, None], np.arange(n)] = matrices
    return column


def _check_size(name: str, size: int, sizes: Integers, rows: Integers) -> None:
    """A matrix with fewer components than its vector is an error."""
    small = sizes[rows] > size
    if small.any():
        row = int(rows[np.argmax(small)])
        raise ValueError(
            f"{name}[{row}] is {size} x {size}, the vectors of its row have {sizes[row]} "
            "components; mark missing components by NaN"
        )


def _form(place: str, length: int, size: int, form: str | None, nested: bool) -> str:
    """Which form so many elements of a matrix have."""
    if nested or form is not None:
        found = "full" if nested else str(form)
        if found == "diagonal" or _is_count(length, found):
            return found
        raise ValueError(f"{place} has {length} elements, which is no {found} square matrix")
    if size:
        counts = {size * size: "full", size * (size + 1) // 2: "upper", size: "diagonal"}
        if length in counts:
            return counts[length]
    possible = [f for f in ("full", "upper") if _is_count(length, f)]
    if length == 1 or (len(possible) == 1 and (size or length == 1)):
        return possible[0]
    if not possible and not size:
        possible = ["diagonal"]
    if not possible:
        raise ValueError(
            f"{place} has shape ({length},), expected a square matrix of size {size}, its upper "
            "triangle or its diagonal"
        )
    if size:
        return possible[0]
    column = place.partition("[")[0]
    readings = [*possible, "diagonal"] if "diagonal" not in possible else possible
    raise ValueError(
        f"{place} has {length} elements: {' or '.join(readings)}? "
        f"Give covariance_forms={{{column!r}: 'diagonal'}}, 'upper' or 'full'"
    )


def _is_count(length: int, form: str) -> bool:
    root = math.isqrt(length if form == "full" else 2 * length)
    return length == (root * root if form == "full" else root * (root + 1) // 2)


def _from_full(elements: Floats) -> Floats:
    n = math.isqrt(elements.shape[1])
    return elements.reshape(-1, n, n)


def _from_upper(elements: Floats) -> Floats:
    n = math.isqrt(2 * elements.shape[1])
    place = np.zeros((n, n), np.int64)
    i, j = np.triu_indices(n)
    place[i, j] = place[j, i] = np.arange(elements.shape[1])
    return np.take(elements, place.ravel(), axis=1).reshape(-1, n, n)


def _from_diagonal(elements: Floats) -> Floats:
    n = elements.shape[1]
    matrices = np.zeros((len(elements), n, n))
    matrices[:, np.arange(n), np.arange(n)] = elements
    return matrices


_FROM = {"full": _from_full, "upper": _from_upper, "diagonal": _from_diagonal}


def as_observations(name: str, values: Any, rows: int, states: int) -> Floats:
    """One ``(m, n)`` matrix a row, or all its elements row by row, padded with NaN rows."""
    array = _whole(values, 3, rows, states)
    if array is not None:
        return array
    ragged = as_ragged(name, values, rows)
    for i, row in enumerate(() if isinstance(values, Ragged) else values):
        if np.ndim(row) == 2 and np.shape(row)[1] != states:
            raise ValueError(f"{name}[{i}] has shape {np.shape(row)}, expected (m, {states})")
    wrong = ragged.lengths % max(states, 1) != 0
    if not states or wrong.any():
        row = int(np.argmax(wrong))
        got = ragged.lengths[row]
        raise ValueError(f"{name}[{row}] has {got} elements, expected (m, {states})")
    m = int(ragged.lengths.max(initial=0)) // states
    return ragged.padded(m * states, np.nan).reshape(rows, m, states)


def as_indices(name: str, values: Any, rows: int, states: Mapping[str, int]) -> Integers:
    """The states that each row observes, by name or index, padded with -1."""
    if isinstance(values, Mapping):
        raise TypeError(f"{name} must hold one list of states a row")
    _check_rows(name, values, rows)
    if _are_indices(values, max(len(states), 1)):
        return np.array(values, np.int64)
    ragged = values if isinstance(values, Ragged) else _ragged_objects(name, values)
    found: dict[Any, int] = {}
    flat = ragged.flat.tolist()
    for position, state in enumerate(flat):
        if state not in found:
            row = int(np.searchsorted(np.cumsum(ragged.lengths), position, side="right"))
            found[state] = state_index(f"{name}[{row}]", state, states)
    indices = np.array([found[state] for state in flat], np.int64)
    width = int(ragged.lengths.max(initial=0))
    return Ragged(indices, ragged.lengths).padded(width, -1)


def _ragged_objects(name: str, values: Any) -> Ragged:
    rows = [() if is_missing(v) else v for v in values]
    for i, row in enumerate(rows):
        if isinstance(row, str) or not hasattr(row, "__len__"):
            raise ValueError(f"{name}[{i}] must be a list of states, got {value(row)}")
    flat = np.empty(sum(map(len, rows)), object)
    flat[:] = [state for row in rows for state in row]
    return Ragged(flat, np.array([len(row) for row in rows], np.int64))


def _are_indices(values: Any, states: int) -> bool:
    """Whether a column is a whole array of indices: no element needs a look by itself."""
    if not isinstance(values, np.ndarray) or values.ndim != 2 or values.dtype.kind != "i":
        return False
    return bool(((values >= -1) & (values < states)).all())


def state_index(name: str, state: Any, states: Mapping[str, int]) -> int:
    """The index of a state that is named by its name or index; -1 stays."""
    if isinstance(state, str):
        if state in states:
            return states[state]
        raise ValueError(f"{name}: no state {value(state)}; the log has {shown(states) or 'none'}")
    is_index = isinstance(state, (int, float, np.number)) and not isinstance(state, bool)
    if not is_index or not math.isfinite(state) or int(state) != state:
        raise ValueError(f"{name}: no state {value(state)}; expected a name or an index")
    index = int(state)
    if not -1 <= index < max(len(states), 1):
        raise ValueError(f"{name}: no state {state!r}; the log has {len(states)} states")
    return index


def is_missing(given: Any) -> bool:
    """Whether a cell holds no value: None, NaN, pandas' NA, a masked element."""
    if given is None or type(given).__name__ in _MISSING_TYPES:
        return True
    return isinstance(given, (float, np.floating)) and bool(np.isnan(given))


def as_ragged(name: str, values: Any, rows: int, *, square: bool = False) -> Ragged:
    """One list of numbers a row, of any length; matrices, ``square`` or not, row by row."""
    _check_rows(name, values, rows)
    if isinstance(values, Ragged):
        return Ragged(_numbers(name, values), values.lengths, values.nested)
    array = _filled(values)
    if array is not None:
        flat = array.reshape(rows, -1)
        nested = array.ndim == 3
        if square and nested and array.shape[1] != array.shape[2]:
            raise ValueError(f"{name}[0] has shape {array.shape[1:]}, expected a square matrix")
        if array.ndim == 1:
            there = ~np.isnan(array)
            return Ragged(array[there], there.astype(np.int64))
        lengths = np.full(rows, flat.shape[1] if rows else 0, np.int64)
        return Ragged(flat.ravel(), lengths, nested)
    parts = [
        np.empty(0) if is_missing(v) else _floats(f"{name}[{i}]", v) for i, v in enumerate(values)
    ]
    lengths = np.array([part.size for part in parts], np.int64)
    nested = any(part.ndim > 1 for part in parts)
    for i, part in enumerate(parts):
        if part.ndim > 2 or (square and part.ndim == 2 and part.shape[0] != part.shape[1]):
            raise ValueError(f"{name}[{i}] has shape {part.shape}, expected a square matrix")
    flat = np.concatenate([part.ravel() for part in parts]) if parts else np.empty(0)
    return Ragged(flat, lengths, nested and all(p.ndim == 2 or not p.size for p in parts))


def _numbers(name: str, values: Ragged) -> Floats:
    if values.flat.dtype.kind in "biuf":
        return np.asarray(values.flat, np.float64)
    wrong = next((i for i, v in enumerate(values.flat) if not _is_number(v)), 0)
    row = int(np.searchsorted(np.cumsum(values.lengths), wrong, side="right"))
    raise ValueError(f"{name}[{row}] must hold numbers, got {value(values.flat[wrong])}")


def _is_number(given: Any) -> bool:
    try:
        float(given)
    except (TypeError, ValueError):
        return False
    return not isinstance(given, str) or "_" not in given


def _floats(name: str, given: Any) -> Floats:
    """A row's numbers; None and masked elements are NaN."""
    if isinstance(given, np.ma.MaskedArray):
        given = np.ma.filled(given.astype(np.float64), np.nan)
    if isinstance(given, (str, bytes)):
        raise ValueError(f"{name} must hold numbers, got {value(given)}")
    try:
        return np.asarray(given, np.float64)
    except (TypeError, ValueError):
        pass
    try:
        return np.array([np.nan if is_missing(v) else float(v) for v in given])
    except (TypeError, ValueError):
        raise ValueError(f"{name} must hold numbers, got {value(given)}") from None


def _number(name: str, row: int, given: Any) -> float:
    if is_missing(given):
        return math.nan
    try:
        return float(given)
    except (TypeError, ValueError):
        raise ValueError(f"{name}[{row}] must be a number, got {value(given)}") from None


def _filled(values: Any) -> Floats | None:
    """Values that are one array of real numbers, missing ones NaN; None for anything else."""
    if isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "biuf":
        filled: Floats = np.ma.filled(values.astype(np.float64), np.nan)
        return filled
    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf":
        return np.array(values, np.float64)
    if isinstance(values, np.ndarray | Ragged):
        return None
    if hasattr(values, "__array__") and not isinstance(values, (list, tuple)):
        array = np.asarray(values)
        return np.array(array, np.float64) if array.dtype.kind in "biuf" else None
    return None


def _whole(values: Any, axes: int, rows: int, width: int | None) -> Floats | None:
    """A column that already is one array of the right form, as float64."""
    array = _filled(values)
    if array is None or array.ndim != axes or len(array) != rows:
        return None
    return array if width in (None, array.shape[-1]) else None


def _shaped(name: str, array: Floats, shape: tuple[int, ...]) -> Floats:
    if array.size != math.prod(shape):
        raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
    return array.reshape(shape)


def _check_rows(name: str, values: Any, rows: int) -> None:
    if not hasattr(values, "__len__") or isinstance(values, (str, bytes)):
        raise ValueError(f"{name} must have one value a row, got {value(values)}")
    if len(values) != rows:
        raise ValueError(f"{name} has {len(values)} rows, the log has {rows}")
