"""KITTI MOTS text: ``frame id class height width mask``, the mask as a run-length string."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.opening import Content
from trackmetrics.tracks import cells
from trackmetrics.tracks.cells import Cells
from trackmetrics.tracks.written import refuse_others, whole

_NAMES = ("frame", "id", "class", "height", "width", "mask")


def read(content: Content) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """The columns of a file as a track table takes them, and the line of each row."""
    found = Cells(content, " ")
    found.need(_NAMES, most=len(_NAMES))
    if not len(found):
        none = np.empty(0, dtype=np.int64)
        return {"time": none, "id": none}, found.lines
    numbers = [found.whole(i, name) for i, name in enumerate(_NAMES[:5])]
    return {
        "time": numbers[0],
        "id": numbers[1],
        "cls": numbers[2],
        "mask": found.text(5),
        "mask_size": np.stack(numbers[3:], axis=1),
    }, found.lines


def write(path: Path, columns: Mapping[str, Any]) -> None:
    """Write the columns of a track table as KITTI MOTS text."""
    refuse_others("KITTI MOTS", columns, ("time", "id", "cls", "mask", "mask_size"))
    if columns.get("mask") is None or columns.get("cls") is None:
        raise ValueError("a KITTI MOTS file holds masks and classes (cls): the table lacks one")
    parts = [whole(name, columns[name]) for name in ("time", "id", "cls")]
    cells.write(path, [*parts, *columns["mask_size"].T, columns["mask"]], " ")
