"""Turns labels and times of any kind into the ``int64`` arrays that kernels take.

Labels keep only what a count needs: equal labels get the same id. Times keep only their order.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors

Ids = NDArray[np.int64]


def labels(argument: str, values: Any) -> Ids:
    """An id for each label, the same for equal labels.

    Labels are anything that Python can hash and that equals itself. In a list, ``1``, ``1.0`` and
    ``True`` are equal, as in Python, and ``1`` and ``"1"`` are not.
    """
    if isinstance(values, list | tuple | range):
        _check.refuse_masked(argument, values)
        if set(map(type, values)) <= {int, bool}:
            try:
                return np.array(values, dtype=np.int64)
            except OverflowError:
                pass
        return _hashed(argument, values)
    array = _one_axis(argument, values)
    kind = array.dtype.kind
    if kind in "biu":
        # Beyond int64 an unsigned label wraps to a negative id of its own.
        return _check.plain(array, np.int64)
    if kind == "f":
        return _of_floats(_without_nan(argument, array))
    if kind in "mM":
        dates = _without_nan(argument, array)
        return _check.plain(dates, dates.dtype.newbyteorder("=")).view(np.int64)
    if kind in "US":
        return np.unique(array, return_inverse=True)[1].astype(np.int64, copy=False)
    return _hashed(argument, array.tolist())


def times(argument: str, values: Any) -> Ids | None:
    """Numbers that stand in the order of the times; ``None`` stays ``None``.

    Times are numbers, dates or anything else that can be ordered; NaN and NaT have no place.
    """
    if values is None:
        return None
    array = _one_axis(argument, values)
    kind = array.dtype.kind
    if kind in "bi":
        return _check.plain(array, np.int64)
    if kind in "fmM":
        array = _without_nan(argument, array)
    if kind in "US" and not isinstance(values, np.ndarray):
        array = np.array(values, dtype=object)  # NumPy would have made strings of numbers
    try:
        return np.unique(array, return_inverse=True)[1].astype(np.int64, copy=False)
    except TypeError:
        raise TypeError(f"{argument} holds times that cannot be ordered") from None


def _one_axis(argument: str, values: Any) -> NDArray[Any]:
    if isinstance(values, str | bytes):
        raise TypeError(f"{argument} must be a list or array, got {type(values).__name__}")
    array = _check.array(argument, values)
    if array.ndim != 1:
        raise errors.shape(argument, array.shape, "(n,)")
    return array


def _without_nan(argument: str, array: NDArray[Any]) -> NDArray[Any]:
    """NaN equals nothing and comes before nothing."""
    unequal = array != array
    if unequal.any():
        i = int(np.argmax(unequal))
        raise ValueError(f"{argument}[{i}] is {array[i]}")
    return array


def _of_floats(array: NDArray[Any]) -> Ids:
    """Whole numbers as they are; otherwise the bits, which tell numbers apart."""
    values = array.astype(np.float64) + 0.0  # -0.0 is 0.0
    with np.errstate(invalid="ignore"):
        whole = values.astype(np.int64)
    return (
        whole
        if (np.abs(values) < 2.0**53).all() and (whole == values).all()
        else values.view(np.int64)
    )


def _hashed(argument: str, values: Sequence[Any]) -> Ids:
    ids: dict[Any, int] = {}
    try:
        found = np.fromiter((ids.setdefault(v, len(ids)) for v in values), np.int64, len(values))
    except TypeError:
        raise _unhashable(argument, values) from None
    for label, i in ids.items():
        if isinstance(label, float | np.floating) and label != label:
            raise ValueError(f"{argument}[{int(np.argmax(found == i))}] is {label}")
    return found


def _unhashable(argument: str, values: Sequence[Any]) -> TypeError:
    for i, value in enumerate(values):
        try:
            hash(value)
        except TypeError:
            return TypeError(
                f"{argument}[{i}] must be a label that can be hashed, got {type(value).__name__}"
            )
    raise AssertionError("every label can be hashed")
