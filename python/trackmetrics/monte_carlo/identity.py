"""What tells one sweep from another: its function with its source, seed, grid and versions."""

import hashlib
import inspect
import json
import pickle
from collections.abc import Iterator, Mapping, Sequence
from types import CodeType
from typing import Any


def to_jsonable(value: Any) -> Any:
    """A setting's value as JSON keeps it, distinct for distinct values."""
    if isinstance(value, bool | int | float | str | type(None)):
        return value if not isinstance(value, float) else repr(value)
    if isinstance(value, list | tuple):
        return [to_jsonable(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): to_jsonable(item) for key, item in value.items()}
    return _fingerprint(value)


def _fingerprint(value: Any) -> str:
    digest = hashlib.sha256(pickle.dumps(value, protocol=4)).hexdigest()[:16]
    return f"{type(value).__name__} {digest}"


def name_of(simulate: Any) -> str:
    """``module:qualname``; a ``functools.partial`` adds what it binds."""
    if hasattr(simulate, "func") and hasattr(simulate, "keywords"):
        bound = to_jsonable([simulate.args, simulate.keywords])
        return f"{name_of(simulate.func)} with {json.dumps(bound)}"
    named = simulate if hasattr(simulate, "__qualname__") else type(simulate)
    return f"{named.__module__}:{named.__qualname__}"


def source_of(simulate: Any) -> str:
    """A hash of the source of the function, of its module, and of what it takes by default.

    Where there is no source (``exec``, a terminal), of its compiled code.
    """
    while hasattr(simulate, "func") and hasattr(simulate, "keywords"):
        simulate = simulate.func
    function = simulate if inspect.isroutine(simulate) else type(simulate)
    function = inspect.unwrap(function)
    code = getattr(function, "__code__", None)
    parts = [_source(inspect.getmodule(function)), _source(function)]
    if parts == ["", ""] and code is not None:
        parts = [*_compiled(code)]
    for name in ("__defaults__", "__kwdefaults__"):
        parts.append(_plain_values(getattr(function, name, None)))
    cells = getattr(function, "__closure__", None) or ()
    parts.append(_plain_values([_content(cell) for cell in cells]))
    return "sha256:" + hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def _source(thing: Any) -> str:
    try:
        return inspect.getsource(thing)
    except (OSError, TypeError):
        return ""


def _compiled(code: CodeType) -> Iterator[str]:
    """What a function does, as its compiled code says it, and the functions inside it."""
    yield repr((code.co_code, code.co_names, code.co_varnames))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _compiled(constant)
        else:
            yield repr(constant)


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _plain_values(values: Any) -> str:
    """Numbers and texts among these; what can change during a run does not count."""
    if isinstance(values, Mapping):
        values = [item for pair in sorted(values.items()) for item in pair]
    plain = (bool, int, float, str, tuple, type(None))
    return repr([v for v in values or () if isinstance(v, plain)])


def identity(
    simulate: Any, seed: Any, grid: Sequence[Mapping[str, Any]], version: Any, **others: Any
) -> dict[str, Any]:
    """What a checkpoint must agree in with the sweep that goes on from it."""
    from trackmetrics._backend import backend
    from trackmetrics._version import __version__

    return {
        "simulate": name_of(simulate),
        "source": source_of(simulate),
        "seed": to_jsonable(seed),
        "grid": [to_jsonable(dict(settings)) for settings in grid],
        "version": to_jsonable(version),
        "trackmetrics": __version__,
        "backend": backend(),
        **{name: to_jsonable(value) for name, value in others.items()},
    }
