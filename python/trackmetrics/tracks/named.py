"""Track tables as named columns: data frames, CSV and Parquet, with a mapping of names."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import headings
from trackmetrics._tables.errors import value

Mapped = Mapping[str, str | Sequence[str]]
LTWH, LTRB = ("left", "top", "width", "height"), ("left", "top", "right", "bottom")
_SINGLE = ("time", "id", "cls", "score", "mask")
_ALIASES = {
    **{"frame": "time", "timestamp": "time", "track_id": "id", "track": "id"},
    **{"class": "cls", "category": "cls", "confidence": "score", "conf": "score"},
}
_VECTORS = ("box_3d", "position", "velocity", "covariance")
TEXT = ("id", "cls", "mask", "track_id", "track", "class", "category")
"""Columns whose cells are text in a text file; whole numbers become numbers again."""


def take(table: Mapping[str, Any], mapping: Mapped, file: str = "the table") -> dict[str, Any]:
    """The arguments of a track table out of named columns; the others stay under their names."""
    left = dict(table)
    for heading, name in headings.match(
        list(left), dict.fromkeys((*_SINGLE, *LTWH, *LTRB))
    ).items():
        left[name] = left.pop(heading)
    found: dict[str, Any] = {}
    for name, wanted in mapping.items():
        names = [wanted] if isinstance(wanted, str) else list(wanted)
        for heading in names:
            if heading not in left:
                raise ValueError(
                    f"{file} has no column {heading!r} for {name}; "
                    f"{headings.nearest(heading, list(left))}"
                )
        parts = [left.pop(heading) for heading in names]
        found[name] = parts[0] if isinstance(wanted, str) else np.stack(parts, axis=1)
    for name in _SINGLE:
        aliases = [name, *(a for a, to in _ALIASES.items() if to == name)]
        present = [alias for alias in aliases if alias in left]
        if present and name not in found:
            found[name] = left.pop(present[0])
    _take_groups(left, found, file)
    for name in ("time", "id"):
        if name not in found:
            raise ValueError(
                f"{file} has no column {name!r}; {headings.nearest(name, list(left))}. Name it "
                f"with columns={{{name!r}: ...}}"
            )
    found["id"], found["time"] = _whole(found["id"]), _times(found["time"], file)
    if "cls" in found:
        found["cls"] = _whole(found["cls"])
    return {**found, "other": left}


def _take_groups(left: dict[str, Any], found: dict[str, Any], file: str) -> None:
    """Boxes, positions and the like, which have one column a component."""
    if "box" not in found:
        for names, form in ((LTWH, "ltwh"), (LTRB, "ltrb")):
            if all(name in left for name in names):
                found["box"] = np.stack([left.pop(name) for name in names], axis=1)
                found["box_format"] = form
                break
    for name in _VECTORS:
        parts = [c for c in left if re.fullmatch(rf"{name}\[\d+\]", c)]
        parts.sort(key=lambda c: int(c[len(name) + 1 : -1]))
        if name not in found and parts:
            found[name] = np.stack([left.pop(part) for part in parts], axis=1)
            if name == "covariance":
                found[name] = _square(found[name], file)
    if "position" not in found and "x" in left and "y" in left:
        axes = [axis for axis in "xyz" if axis in left]
        found["position"] = np.stack([left.pop(axis) for axis in axes], axis=1)
    sizes = ("mask_height", "mask_width")
    if "mask" in found and all(size in left for size in sizes):
        found["mask_size"] = np.stack([left.pop(s) for s in sizes], axis=1).astype(np.int64)


def _square(columns: Any, file: str) -> Any:
    rows, count = columns.shape
    side = math.isqrt(count)
    if side * side != count:
        raise ValueError(
            f"{file} has {count} columns covariance[0] and on, expected the d x d of a matrix"
        )
    return columns.reshape(rows, side, side)


def _whole(labels: Any) -> Any:
    """Text that is whole numbers throughout, as such: ``"7"``, but not ``"007"``."""
    if not isinstance(labels, np.ndarray) or labels.dtype != object or not len(labels):
        return labels
    if set(map(type, labels)) != {str}:
        return labels
    text = labels.astype(str)
    try:
        numbers = text.astype(np.int64)
    except (ValueError, OverflowError):
        return text
    return numbers if (numbers.astype(text.dtype) == text).all() else text


def _times(times: Any, file: str) -> Any:
    """Numbers as they are (whole ones as integers), ISO dates as dates."""
    if not isinstance(times, np.ndarray) or times.dtype.kind in "iumM":
        return times
    if times.dtype.kind == "f":
        whole = np.isfinite(times).all() and (times == np.trunc(times)).all()
        return times.astype(np.int64) if whole and (np.abs(times) < 2**53).all() else times
    try:
        return np.array([str(t).removesuffix("Z") for t in times], dtype="datetime64[us]")
    except ValueError:
        raise ValueError(
            f"{file}: time must hold numbers or ISO 8601 dates, got {value(times[0])} in row 0"
        ) from None


def give(columns: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """A track table as named columns, each of one axis."""
    out: dict[str, NDArray[Any]] = {"time": columns["time"], "id": _plain(columns["id"])}
    if columns.get("cls") is not None:
        out["cls"] = _plain(columns["cls"])
    if columns.get("score") is not None:
        out["score"] = columns["score"]
    if columns.get("box") is not None:
        out |= dict(zip(LTWH, columns["box"].T, strict=True))
    for name in _VECTORS:
        if columns.get(name) is not None:
            flat = columns[name].reshape(len(columns["time"]), -1)
            out |= {f"{name}[{i}]": part for i, part in enumerate(flat.T)}
    if columns.get("mask") is not None:
        height, width = columns["mask_size"].T
        out |= {"mask": columns["mask"], "mask_height": height, "mask_width": width}
    return {name: np.ascontiguousarray(c) for name, c in {**out, **columns["other"]}.items()}


def _plain(labels: NDArray[Any]) -> NDArray[Any]:
    """Labels as integers or text: ids of other kinds have no form in a table."""
    if labels.dtype.kind in "iu":
        return labels
    for row, label in enumerate(labels.tolist()):
        if not isinstance(label, str):
            raise TypeError(
                f"row {row}: an id or class must be text, or all of them whole numbers, to be "
                f"written, got {type(label).__name__}"
            )
    return labels.astype(object)
