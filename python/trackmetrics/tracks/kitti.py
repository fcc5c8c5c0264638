"""KITTI tracking labels: ``frame id type truncated occluded alpha left top right bottom height
width length x y z rotation_y [score]``, separated by blanks.

KITTI's axes are those of its camera: x to the right, y downwards, z forward, the location at the
bottom of the box. The 3-D boxes of a track table have z upwards and the location at their middle:
``(z, -x, height / 2 - y, length, width, height, -rotation_y - pi / 2)``. ``position`` keeps the
camera's x, y, z.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.opening import Content
from trackmetrics.tracks import cells
from trackmetrics.tracks.cells import Cells
from trackmetrics.tracks.written import column_or, refuse_others, whole

_NAMES: tuple[str, ...] = ("frame", "id", "type", "truncated", "occluded", "alpha")
_NAMES += ("left", "top", "right", "bottom", "height", "width", "length", "x", "y", "z")
_NAMES += ("rotation_y", "score")
DONT_CARE = "DontCare"
_OTHER = ("truncated", "occluded", "alpha")


def read(content: Content) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """The columns of a file as a track table takes them, and the line of each row.

    Regions of type DontCare have no identity: in each frame they get the ids -1, -2, ...
    """
    found = Cells(content, " ")
    found.need(_NAMES[:-1], most=len(_NAMES), same=True)
    if not len(found):
        none = np.empty(0, dtype=np.int64)
        return {"time": none, "id": none, "box": np.empty((0, 4))}, found.lines
    frames, ids, cls = found.whole(0, "frame"), found.whole(1, "id"), found.text(2)
    number = {name: found.numbers(i, name) for i, name in enumerate(_NAMES[:17]) if i > 2}
    left, top = number["left"], number["top"]
    columns: dict[str, Any] = {
        "time": frames,
        "id": _number_regions(frames, ids, cls == DONT_CARE),
        "cls": cls,
        "box": np.stack([left, top, number["right"] - left, number["bottom"] - top], axis=1),
        "box_3d": _box_3d(number),
        "position": np.stack([number[name] for name in "xyz"], axis=1),
        "other": {name: number[name] for name in _OTHER},
    }
    if found.width == len(_NAMES):
        columns["score"] = found.numbers(17, "score")
    return columns, found.lines


def _number_regions(
    frames: NDArray[np.int64], ids: NDArray[np.int64], is_region: NDArray[np.bool_]
) -> NDArray[np.int64]:
    rows = np.flatnonzero(is_region)
    rows = rows[np.argsort(frames[rows], kind="stable")]
    starts = np.searchsorted(frames[rows], frames[rows])
    numbered = ids.copy()
    numbered[rows] = starts - np.arange(len(rows)) - 1
    return numbered


def _box_3d(number: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    height = number["height"]
    place = number["z"], -number["x"], height / 2 - number["y"]
    yaw = -number["rotation_y"] - np.pi / 2
    return np.stack([*place, number["length"], number["width"], height, yaw], axis=1)


def write(path: Path, columns: Mapping[str, Any]) -> None:
    """Write the columns of a track table as KITTI tracking labels.

    What the table does not have is written as KITTI's marks of missing values: -1 for truncation
    and occlusion, -10 for angles, -1 for sizes, -1000 for places.
    """
    held = ("time", "id", "box", "box_3d", "position", "score", "cls", *_OTHER)
    refuse_others("KITTI tracking", columns, held)
    n, cls = len(columns["time"]), columns.get("cls")
    if columns.get("box") is None or cls is None:
        raise ValueError("a KITTI tracking file holds boxes and classes (cls): the table lacks one")
    ids = whole("id", columns["id"])
    ids[cls == DONT_CARE] = -1
    other, box = columns["other"], columns["box"]
    parts = [whole("time", columns["time"]), ids, cls.astype(object)]
    missing = zip(_OTHER, (-1.0, -1.0, -10.0), strict=True)
    parts += [column_or(other.get(name), n, value) for name, value in missing]
    parts += [*box[:, :2].T, *_short(box[:, :2] + box[:, 2:]).T, *_dimensions(columns, n)]
    if columns.get("score") is not None:
        parts.append(column_or(columns["score"], n, 0))
    cells.write(path, parts, " ")


def _dimensions(columns: Mapping[str, Any], n: int) -> list[NDArray[Any]]:
    """Height, width, length, x, y, z and rotation_y."""
    box, position = columns.get("box_3d"), columns.get("position")
    if position is not None and position.shape[1] != 3:
        raise ValueError(f"position has {position.shape[1]} coordinates, a KITTI file holds 3")
    if box is None:
        sizes, rotation = np.full((3, n), -1.0), np.full(n, -10.0)
        places = np.full((3, n), -1000.0)
    else:
        x, y, z, length, width, height, yaw = box.T
        sizes, rotation = np.stack([height, width, length]), _short(-yaw - np.pi / 2)
        places = _short(np.stack([-y, height / 2 - z, x]))
    if position is not None:
        places = position.T
    return [*sizes, *places, rotation]


def _short(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values without the last bits, which the change of form and back has rounded."""
    return np.char.mod("%.14g", values).astype(np.float64)
