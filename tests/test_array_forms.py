"""Arrays in every form, through every public function of both backends.

The value is that of the plain array, or the error names the argument.
"""

import array as arrays
import inspect
import runpy
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pytest

import trackmetrics as tm

_TABLE = runpy.run_path(str(Path(__file__).with_name("test_bad_arguments.py")))
GOOD, PLAIN = _TABLE["GOOD"], _TABLE["PLAIN"]
COSTS = np.array([[4.0, 1.0, 3.0], [2.0, 0.0, 5.0], [3.0, 2.0, 2.0]])
CALLS = {
    **GOOD,
    "linear_sum_assignment": {"cost_matrix": COSTS},
    "linear_sum_assignment_batch": {"costs": np.stack([COSTS, COSTS.T])},
}
SCIPYS = {"cost_matrix", "costs"}
"""What is wrong with these SciPy's own texts say, which name no argument."""


class Subclass(np.ndarray):
    """An array of another class."""


class Readable:
    """Something that NumPy reads by ``__array__``."""

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self.values, dtype=dtype)


class Interface:
    """Something that NumPy reads by ``__array_interface__``."""

    def __init__(self, values):
        self.values = values
        self.__array_interface__ = values.__array_interface__


def unaligned(values):
    raw = np.frombuffer(b"\x01" + values.tobytes(), dtype=values.dtype, offset=1)
    return raw.reshape(values.shape)


def frozen(values):
    copy = values.copy()
    copy.flags.writeable = False
    return copy


def reversed_strides(values):
    return np.flip(np.flip(values).copy())


def strided(values):
    wide = np.repeat(values, 2, axis=-1)
    return wide[..., ::2]


def structured(values):
    return values.view([("value", values.dtype)])


def half_masked(values):
    mask = np.zeros(values.shape, dtype=bool)
    mask.flat[-1] = True
    return np.ma.masked_array(values, mask)


def in_series(series):
    def of(values):
        return series(values) if values.ndim == 1 else [of(row) for row in values]

    return of


def matrix(values):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)
        return np.matrix(values) if values.ndim == 2 else values


FORMS = {
    "unaligned": unaligned,
    "byte-swapped": lambda values: values.astype(values.dtype.newbyteorder()),
    "read-only": frozen,
    "negative strides": reversed_strides,
    "strided": strided,
    "Fortran": np.asfortranarray,
    "nothing masked": np.ma.masked_array,
    "masked": half_masked,
    "a list of masked": lambda values: [*half_masked(values)],
    "matrix": matrix,
    "subclass": lambda values: values.view(Subclass),
    "0-d": lambda values: np.array(values.flat[0]),
    "structured": structured,
    "objects": lambda values: values.astype(object),
    "__array__": Readable,
    "__array_interface__": Interface,
    "memoryview": memoryview,
    "pandas": in_series(pd.Series),
    "polars": in_series(pl.Series),
    "float32": lambda values: values.astype(np.float32) if values.dtype.kind == "f" else values,
    "a list of rows": list,
    "a tuple of rows": tuple,
    "lists": np.ndarray.tolist,
    "array.array": lambda values: (
        arrays.array("d", values) if values.ndim == 1 and values.dtype.kind == "f" else values
    ),
}
PLACES = [
    (name, argument)
    for name, call in CALLS.items()
    for argument, value in call.items()
    if isinstance(value, np.ndarray)
]


def outcome(name, arguments):
    """The value, or the error."""
    try:
        return getattr(tm, name)(**arguments)
    except Exception as error:
        return error


def same(found, expected):
    if isinstance(expected, (tuple, list)):
        return len(found) == len(expected) and all(map(same, found, expected))
    if hasattr(expected, "__dataclass_fields__"):
        fields = expected.__dataclass_fields__
        return all(same(getattr(found, f), getattr(expected, f)) for f in fields)
    if expected is None or isinstance(expected, (str, bool)):
        return found == expected
    left, right = np.asarray(found), np.asarray(expected)
    return left.shape == right.shape and np.allclose(left, right, 1e-6, 1e-7, equal_nan=True)


def test_every_public_function_is_here():
    functions = {name for name in tm.__all__ if inspect.isfunction(getattr(tm, name))}
    assert functions - PLAIN == set(CALLS)


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("name", "argument"), PLACES)
def test_the_right_value_or_an_error_that_names_the_argument(name, argument, form, backend):
    call = CALLS[name]
    with tm.use_backend(backend):
        expected = outcome(name, call)
        found = outcome(name, {**call, argument: FORMS[form](call[argument])})
    assert not isinstance(expected, Exception)
    if isinstance(found, Exception):
        # A number where an array was meant does not fit the other arguments, one of which is named.
        named = [argument] if form != "0-d" else list(call)
        text = str(found)
        assert any(n in text for n in named) or (argument in SCIPYS and text), repr(found)
    else:
        assert form not in ("masked", "a list of masked"), found
        if form == "0-d":
            return  # another, smaller argument
        if isinstance(found, list):
            found = tuple(map(np.stack, zip(*found, strict=True)))
        assert same(found, expected), (found, expected)
