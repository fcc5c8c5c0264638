"""A sweep on disk: one file a setting, replaced as a whole, so that every moment is a good one.

A checkpoint is a folder: ``sweep.json`` says which sweep it is of, ``0000.tally``, ``0001.tally``
and so on hold what is known of each setting. A file is written beside its place, forced to the
disk, and renamed over its predecessor.
"""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from trackmetrics.monte_carlo.setting_state import Tally

_HEADER = "sweep.json"


class Checkpoint:
    """The folder of one sweep."""

    def __init__(self, path: str | os.PathLike[str], identity: Mapping[str, Any]) -> None:
        self.path = Path(path)
        if self.path.is_file():
            raise ValueError(f"checkpoint {self.path} is a file, expected a folder or nothing")
        self.path.mkdir(parents=True, exist_ok=True)
        for rest in self.path.glob("*.part"):
            rest.unlink()
        header = self.path / _HEADER
        if not header.exists():
            if any(self.path.iterdir()):
                raise ValueError(f"checkpoint {self.path} is a folder with other things in it")
            self._replace(header, json.dumps(identity, indent=1).encode())
        self._require_same(json.loads(header.read_text()), identity)

    def _require_same(self, found: Mapping[str, Any], ours: Mapping[str, Any]) -> None:
        ours = json.loads(json.dumps(ours))
        differing = [name for name in {**found, **ours} if found.get(name) != ours.get(name)]
        if differing:
            words = (f"{n} was {found.get(n)!r}, is {ours.get(n)!r}" for n in differing)
            raise ValueError(f"checkpoint {self.path} is of another sweep: {'; '.join(words)}")

    def read(self, settings: int) -> list[Tally]:
        """What is known of each setting."""
        return [self._read(self._place(k)) for k in range(settings)]

    def _read(self, place: Path) -> Tally:
        if not place.exists():
            return Tally()
        try:
            return Tally.from_bytes(place.read_bytes())
        except ValueError as error:
            raise ValueError(
                f"{place}: {error}; without this file its runs are computed again"
            ) from None

    def write(self, setting: int, tally: Tally) -> None:
        """Replaces what is known of a setting."""
        self._replace(self._place(setting), tally.to_bytes())

    def _place(self, setting: int) -> Path:
        return self.path / f"{setting:04d}.tally"

    def _replace(self, place: Path, data: bytes) -> None:
        part = place.with_suffix(".part")
        with open(part, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, place)
        _sync_folder(self.path)


def _sync_folder(path: Path) -> None:
    """Forces a rename to the disk, where a folder can be opened (not on Windows)."""
    if os.name != "posix":
        return
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def described(value: Any) -> Any:
    """A setting's value as JSON keeps it, distinct for distinct values."""
    if isinstance(value, bool | int | float | str | type(None)):
        return value if not isinstance(value, float) else repr(value)
    if isinstance(value, list | tuple):
        return [described(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): described(item) for key, item in value.items()}
    return _fingerprint(value)


def _fingerprint(value: Any) -> str:
    import hashlib
    import pickle

    digest = hashlib.sha256(pickle.dumps(value, protocol=4)).hexdigest()[:16]
    return f"{type(value).__name__} {digest}"


def name_of(simulate: Any) -> str:
    """``module:qualname``; a ``functools.partial`` adds what it binds."""
    if hasattr(simulate, "func") and hasattr(simulate, "keywords"):
        bound = described([simulate.args, simulate.keywords])
        return f"{name_of(simulate.func)} with {json.dumps(bound)}"
    named = simulate if hasattr(simulate, "__qualname__") else type(simulate)
    return f"{named.__module__}:{named.__qualname__}"


def identity(
    simulate: Any, seed: Any, grid: Sequence[Mapping[str, Any]], version: Any, **others: Any
) -> dict[str, Any]:
    """What a checkpoint must agree in with the sweep that goes on from it."""
    from trackmetrics._backend import backend
    from trackmetrics._version import __version__

    return {
        "simulate": name_of(simulate),
        "seed": described(seed),
        "grid": [described(dict(settings)) for settings in grid],
        "version": described(version),
        "trackmetrics": __version__,
        "backend": backend(),
        **{name: described(value) for name, value in others.items()},
    }
