"""Chooses the Rust kernels or their NumPy reference implementations; the only importer of either.

``kernels`` is the module in use. A public function calls ``_backend.kernels.f(...)``, so that a
change of
backend is seen at the next call. ``TRACKMETRICS_BACKEND`` asks for one by name; without it the Rust
kernels are taken, and their reference implementations where the package was built without an
extension. A backend that
was asked for and is missing, an extension that does not load, or one of another build, is an error
and never a silent fallback.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import Any

from trackmetrics._version import __version__

_MODULES = {"native": "trackmetrics._native", "numpy": "trackmetrics._numpy"}


def _load(name: str) -> ModuleType:
    if name not in _MODULES:
        raise ValueError(f"backend must be one of {sorted(_MODULES)}, got {name!r}")
    module = import_module(_MODULES[name])
    if module.__version__ != __version__:
        raise ImportError(
            f"the extension trackmetrics._native is version {module.__version__}, "
            f"the package is {__version__}: install trackmetrics again"
        )
    return module


def _built() -> str:
    """The backend where none is asked for."""
    try:
        import_module(_MODULES["native"])
    except ModuleNotFoundError as error:
        if error.name != _MODULES["native"]:
            raise
        return "numpy"
    return "native"


_name = os.environ.get("TRACKMETRICS_BACKEND") or _built()
kernels: Any = _load(_name)


def backend() -> str:
    """Name of the backend that computes: ``"native"`` (Rust) or ``"numpy"``."""
    return _name


@contextmanager
def use_backend(name: str) -> Iterator[None]:
    """Compute with the backend ``name`` inside a ``with`` block, in every thread of the process.

    >>> import trackmetrics
    >>> with trackmetrics.use_backend("numpy"):
    ...     trackmetrics.backend()
    'numpy'
    """
    global _name, kernels
    before = _name, kernels
    _name, kernels = name, _load(name)
    try:
        yield
    finally:
        _name, kernels = before


def threads() -> int:
    """How many threads a kernel may use (the NumPy backend uses one of its own)."""
    return int(kernels.threads())


def set_threads(count: int) -> None:
    """Let kernels use at most ``count`` threads; 0 for as many as the machine has.

    The environment variable ``TRACKMETRICS_THREADS`` sets the same at import. Results have the same
    bits with one thread or with many.
    """
    from trackmetrics import _check  # only needed here: it imports NumPy

    threads = _check.whole("count", count)
    if not 0 <= threads < 2**31:
        raise ValueError(f"count must be a whole number of threads, at least 0, got {count!r}")
    kernels.set_threads(threads)


if "TRACKMETRICS_THREADS" in os.environ:
    set_threads(int(os.environ["TRACKMETRICS_THREADS"]))
