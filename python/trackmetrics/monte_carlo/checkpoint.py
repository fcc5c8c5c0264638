"""A sweep on disk: one file a setting, written so that an interrupted write leaves the old file.

A checkpoint is a folder: ``sweep.json`` says which sweep it is of, ``0000.tally``, ``0001.tally``
and so on hold what is known of each setting. A file is written beside its place, forced to the
disk, and renamed over its predecessor.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables.errors import value
from trackmetrics.monte_carlo.setting_state import SettingState

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
        try:
            found = json.loads(header.read_text())
        except (ValueError, RecursionError):
            found = None
        self._require_same(found, identity)

    def _require_same(self, found: Any, identity: Mapping[str, Any]) -> None:
        ours: dict[str, Any] = json.loads(json.dumps(identity))
        if not isinstance(found, dict):
            raise ValueError(f"{self.path / _HEADER} is damaged; give another checkpoint=")
        # The hash of the source, given as version, says: go on as if the source had not changed.
        if found.get("source") is not None and ours["version"] == found["source"]:
            ours |= {"version": found.get("version"), "source": found["source"]}
        elif ours["version"] is not None or "source" not in found:  # 0.1.0 kept no source
            ours["source"] = found.get("source")
        differing = [name for name in {**found, **ours} if found.get(name) != ours.get(name)]
        if differing == ["source"]:
            raise ValueError(
                f"checkpoint {self.path} was made by another source of {ours['simulate']}: give "
                f"another checkpoint= to begin anew, or version={found['source']!r} if the results "
                "are the same"
            )
        if differing:
            parts = (f"{n} was {value(found.get(n))}, is {value(ours.get(n))}" for n in differing)
            raise ValueError(
                f"checkpoint {self.path} is of another sweep: {'; '.join(parts)}; give another "
                "checkpoint= to begin anew"
            )

    def read(self, settings: int) -> list[SettingState]:
        """What is known of each setting."""
        return [self._read(self._place(k)) for k in range(settings)]

    def _read(self, place: Path) -> SettingState:
        if not place.exists():
            return SettingState()
        try:
            return SettingState.from_bytes(place.read_bytes())
        except ValueError as error:
            raise ValueError(
                f"{place}: {error}; without this file its runs are computed again"
            ) from None

    def write(self, setting: int, state: SettingState) -> None:
        """Replaces what is known of a setting."""
        self._replace(self._place(setting), state.to_bytes())

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
