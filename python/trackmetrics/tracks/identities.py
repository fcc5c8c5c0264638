"""Ids, classes and times as arrays: labels are anything that Python can hash."""

from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors

Codes = NDArray[np.int64]


def labels(argument: str, given: Any, length: int | None = None) -> NDArray[Any]:
    """Labels as an array of one axis: integers and text as they are, all else as objects.

    In a list ``1`` and ``"1"`` stay different labels.
    """
    _check.refuse_masked(argument, given)
    if isinstance(given, str | bytes):
        raise TypeError(f"{argument} must be a list or array, got {type(given).__name__}")
    values: NDArray[Any]
    if isinstance(given, np.ndarray):
        values = given
    else:
        given = list(given)
        kinds = set(map(type, given))
        if kinds <= {int, np.int64, np.int32}:
            values = np.array(given, dtype=np.int64)
        elif kinds == {str}:
            values = np.array(given)
        else:
            values = _objects(given)
    if values.ndim != 1:
        raise errors.shape(argument, values.shape, "(N,)")
    if length is not None and len(values) != length:
        raise errors.length(argument, len(values), "time", length, "rows")
    if values.dtype.kind in "iu":
        values = values.astype(np.int64, copy=False)
    elif values.dtype.kind in "fmM":
        unequal = np.flatnonzero(values != values)
        if len(unequal):
            raise ValueError(f"{argument}[{unequal[0]}] is {values[unequal[0]]}")
        whole = values.dtype.kind == "f" and (values == np.trunc(values)).all()
        if whole and (np.abs(values) < 2**53).all():
            values = values.astype(np.int64)
    return values


def times(argument: str, given: Any) -> NDArray[Any]:
    """Finite numbers or dates as an array of one axis."""
    array = _check.array(argument, given)
    if array.ndim != 1:
        raise errors.shape(argument, array.shape, "(N,)")
    if not len(array):
        return np.empty(0, dtype=np.int64)
    if array.dtype == object:
        array = _dates(argument, array)
    if array.dtype.kind not in "iufmM":
        raise TypeError(f"{argument} must hold numbers or dates, got dtype {array.dtype}")
    wrong = np.flatnonzero(~np.isfinite(array))
    if len(wrong):
        raise ValueError(f"{argument}[{wrong[0]}] is {array[wrong[0]]}, expected a finite time")
    return array


def _dates(argument: str, values: NDArray[np.object_]) -> NDArray[np.datetime64]:
    try:
        return values.astype("datetime64[us]")
    except (ValueError, TypeError) as error:
        raise TypeError(f"{argument} must hold numbers or dates: {error}") from None


def _objects(values: list[Any]) -> NDArray[np.object_]:
    array = np.empty(len(values), dtype=object)
    array[:] = [v.item() if isinstance(v, np.generic) else v for v in values]
    return array


def encode(argument: str, values: NDArray[Any]) -> tuple[Codes, tuple[Hashable, ...]]:
    """A code from 0 on for each label, and the labels behind the codes."""
    if values.dtype != object:
        names, codes = np.unique(values, return_inverse=True)
        return codes.astype(np.int64, copy=False), tuple(names.tolist())
    found: dict[Hashable, int] = {}
    codes = np.empty(len(values), dtype=np.int64)
    for row, label in enumerate(values):
        try:
            codes[row] = found.setdefault(label, len(found))
        except TypeError:
            raise TypeError(
                f"{argument}[{row}] must be a label that can be hashed, got {type(label).__name__}"
            ) from None
        if label is None or label != label:
            raise ValueError(f"{argument}[{row}] is {label}, expected an id")
    return codes, tuple(found)
