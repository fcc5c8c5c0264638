"""Puts our functions into an installed pytcl, for code that one cannot edit."""

import sys
from collections.abc import Iterator, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, Literal

TESTED_VERSIONS = ("2.11.1",)
"""The releases of nrl-tracker that every function is compared with in the tests."""

_PACKAGE = "pytcl.performance_evaluation"
_originals: dict[str, Any] = {}


def patch_pytcl(version: Literal["tested", "any"] = "tested") -> None:
    """Replace the functions of ``pytcl.performance_evaluation`` by ours.

    Every loaded module of pytcl that re-exports one of them gets ours; modules of pytcl imported
    later find ours. Names that other code has already imported (``from pytcl... import ospa``) keep
    what they hold: patch first. Patching twice does nothing more.

    Parameters
    ----------
    version : {"tested", "any"}
        ``"tested"`` refuses a pytcl that our functions have not been compared with.

    Raises
    ------
    ImportError
        Where pytcl (PyPI: nrl-tracker) is not installed or its version has not been tested.

    Examples
    --------
    >>> import trackmetrics
    >>> trackmetrics.patch_pytcl()
    >>> from pytcl.performance_evaluation import ospa
    >>> ospa is trackmetrics.ospa
    True
    >>> trackmetrics.unpatch_pytcl()
    """
    if _originals:
        return
    peer = import_module(_PACKAGE)
    _check_version(version)
    ours = import_module("trackmetrics")
    replacements = {name: getattr(ours, name) for name in peer.__all__}
    _originals.update({name: getattr(peer, name) for name in peer.__all__})
    _replace(_originals, replacements)


def unpatch_pytcl() -> None:
    """Undo ``patch_pytcl``: pytcl's own functions stand where they stood. Harmless without it."""
    if not _originals:
        return
    ours = import_module("trackmetrics")
    _replace({name: getattr(ours, name) for name in _originals}, _originals)
    _originals.clear()


def _check_version(version: str) -> None:
    if version not in ("tested", "any"):
        raise ValueError(f"version must be 'tested' or 'any', got {version!r}")
    found = import_module("pytcl").__version__
    if version == "tested" and found not in TESTED_VERSIONS:
        raise ImportError(
            f"nrl-tracker {found} has not been compared with trackmetrics (tested: "
            f"{', '.join(TESTED_VERSIONS)}); patch_pytcl(version='any') patches it all the same"
        )


def _replace(old: Mapping[str, Any], new: Mapping[str, Any]) -> None:
    for module in _modules():
        for name in old.keys() & vars(module).keys():
            if vars(module)[name] is old[name]:
                setattr(module, name, new[name])


def _modules() -> Iterator[ModuleType]:
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "pytcl" and isinstance(module, ModuleType):
            yield module
