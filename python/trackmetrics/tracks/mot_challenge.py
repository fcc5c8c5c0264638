"""MOTChallenge files: a line for each box, ``frame,id,left,top,width,height[,confidence,...]``.

Truth of MOT16 and later goes on with a class and a visibility (9 columns), truth of MOT15 and
results with a position x, y, z (10 columns; -1 in all of them where there is none).
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import opening
from trackmetrics._tables.opening import Content
from trackmetrics.tracks import cells
from trackmetrics.tracks.cells import Cells
from trackmetrics.tracks.written import column_or, refuse_others, whole

_COLUMNS = ("frame", "id", "left", "top", "width", "height", "confidence")
_NEEDED = 6
_WITH_CLASS, _WITH_POSITION = 9, 10


@dataclass(frozen=True)
class Boxes:
    """The boxes of one file, in its order."""

    frames: NDArray[np.int64]
    """The frame of each box, shape (N,)."""
    ids: NDArray[np.int64]
    """The target or track of each box, shape (N,)."""
    boxes: NDArray[np.float64]
    """Left, top, width and height in pixels, shape (N, 4)."""
    confidence: NDArray[np.float64]
    """The seventh column, shape (N,): in a truth file 0 for a box that does not count; NaN where
    the file has none."""

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        return f"Boxes({len(self)} of {self.targets} ids)"

    @property
    def targets(self) -> int:
        """How many different ids."""
        return len(np.unique(self.ids))

    @property
    def centres(self) -> NDArray[np.float64]:
        """The middle of each box in pixels, shape (N, 2)."""
        return self.boxes[:, :2] + self.boxes[:, 2:] / 2

    def counted(self) -> "Boxes":
        """The boxes that count as truth: a confidence of at least 1, or none.

        Raises ValueError where there are boxes and none of them counts.
        """
        keep = ~(self.confidence < 1)
        if len(keep) and not keep.any():
            least, most = self.confidence.min(), self.confidence.max()
            raise ValueError(
                f"none of the {len(keep)} boxes counts as truth: column 7 (confidence) is below 1 "
                f"in all of them (from {least:g} to {most:g})"
            )
        return Boxes(self.frames[keep], self.ids[keep], self.boxes[keep], self.confidence[keep])

    def by_frame(self, first: int, last: int) -> list[NDArray[np.intp]]:
        """The places of the boxes of each frame from first to last, in the order of the file."""
        order = np.argsort(self.frames, kind="stable")
        starts = np.searchsorted(self.frames[order], np.arange(first, last + 2))
        return np.split(order, starts)[1:-1]


def read_mot_challenge(path: str | os.PathLike[str], *, progress: bool = False) -> Boxes:
    """Read the first seven columns of a MOTChallenge file of truth or results.

    :func:`read_tracks` reads all of its columns.

    Parameters
    ----------
    path : str or path
        A text file with a line for each box: frame, id, left, top, width, height, and optionally a
        confidence and more, separated by commas. Blank lines are passed over.
        The file may be packed (gzip, xz, zip).
    progress : bool
        Kept for callers of earlier releases: files are read whole, without a bar.

    Returns
    -------
    Boxes
        All boxes, in the order of the file.

    Raises
    ------
    ValueError
        Where a line has too few columns or a word that is not a finite number, where a frame or an
        id is not whole, or where one frame has an id twice; the message names file and line.
    OSError
        Where the file cannot be read.

    References
    ----------
    Leal-Taixé et al., "MOTChallenge 2015: Towards a benchmark for multi-target tracking", 2015,
    arXiv:1504.01942.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "gt.txt"
    ...     _ = file.write_text("1,7,10,20,4,8,1\\n2,7,12,20,4,8,1\\n")
    ...     boxes = read_mot_challenge(file)
    >>> boxes
    Boxes(2 of 1 ids)
    >>> boxes.centres[0]
    array([12., 24.])
    """
    found = Cells(opening.read(path, may_be_empty=True), ",", os.fspath(path))
    found.need(_COLUMNS[:_NEEDED])
    frames, ids = (found.whole(i, _COLUMNS[i]) for i in (0, 1)) if len(found) else _nothing()
    boxes = _boxes(found)
    confidence = np.full(len(found), np.nan)
    if found.width > _NEEDED:
        confidence = found.numbers(_NEEDED, _COLUMNS[_NEEDED])
    _refuse_duplicates(found, frames, ids)
    return Boxes(frames, ids, boxes, confidence)


def _nothing() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)


def _boxes(found: Cells) -> NDArray[np.float64]:
    if not len(found):
        return np.empty((0, 4))
    return np.stack([found.numbers(i, _COLUMNS[i]) for i in range(2, 6)], axis=1)


def _refuse_duplicates(found: Cells, frames: NDArray[np.int64], ids: NDArray[np.int64]) -> None:
    order = np.lexsort((ids, frames))
    same = (np.diff(frames[order]) == 0) & (np.diff(ids[order]) == 0)
    if same.any():
        second = int(order[1:][same].min())
        first = int(np.flatnonzero((frames == frames[second]) & (ids == ids[second]))[0])
        raise ValueError(
            f"{found.where(second)}: frame {frames[second]} has id {ids[second]} twice, "
            f"first on line {found.lines[first]}"
        )


def read(content: Content) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """All columns of a file as a track table takes them, and the line of each row."""
    found = Cells(content, ",")
    found.need(_COLUMNS[:_NEEDED], most=_WITH_POSITION, same=True)
    if not len(found):
        frames, ids = _nothing()
        return {"time": frames, "id": ids, "box": np.empty((0, 4))}, found.lines
    columns: dict[str, Any] = {
        "time": found.whole(0, "frame"),
        "id": found.whole(1, "id"),
        "box": _boxes(found),
    }
    if found.width > _NEEDED:
        columns["score"] = found.numbers(6, "confidence")
    if found.width in (8, _WITH_CLASS):
        columns["cls"] = found.whole(7, "class")
    if found.width == _WITH_CLASS:
        columns["other"] = {"visibility": found.numbers(8, "visibility")}
    if found.width == _WITH_POSITION:
        position = np.stack([found.numbers(i, "xyz"[i - 7]) for i in (7, 8, 9)], axis=1)
        if (position != -1).any():
            columns["position"] = position
    return columns, found.lines


def write(path: Path, columns: Mapping[str, Any]) -> None:
    """Write the columns of a track table as MOTChallenge text."""
    held = ("time", "id", "box", "score", "cls", "position", "visibility")
    refuse_others("MOTChallenge", columns, held)
    if columns.get("cls") is not None and columns.get("position") is not None:
        raise ValueError(
            "a MOTChallenge file holds cls or position, not both: leave one out with "
            "table.without('cls')"
        )
    n = len(columns["time"])
    if columns.get("box") is None:
        raise ValueError("a MOTChallenge file holds boxes, and the table has none")
    parts = [whole("time", columns["time"]), whole("id", columns["id"]), *columns["box"].T]
    score, cls, position = (columns.get(name) for name in ("score", "cls", "position"))
    visibility = columns["other"].get("visibility")
    if cls is not None:
        parts += [column_or(score, n, 1.0), whole("cls", cls), column_or(visibility, n, -1.0)]
    elif score is not None or position is not None:
        parts.append(column_or(score, n, 1.0))
        parts += list(np.full((3, n), -1.0) if position is None else _three(position).T)
    cells.write(path, parts, ",")


def _three(position: NDArray[np.float64]) -> NDArray[np.float64]:
    if position.shape[1] != 3:
        raise ValueError(
            f"position has {position.shape[1]} coordinates, a MOTChallenge file holds 3"
        )
    return position
