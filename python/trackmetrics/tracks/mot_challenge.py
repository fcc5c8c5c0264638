"""MOTChallenge files: a line for each box, ``frame,id,left,top,width,height[,confidence,...]``."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackmetrics._progress import watched

_COLUMNS = ("frame", "id", "left", "top", "width", "height", "confidence")
_NEEDED = 6


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
        """The boxes that count as truth: a confidence of at least 1, or none."""
        keep = ~(self.confidence < 1)
        return Boxes(self.frames[keep], self.ids[keep], self.boxes[keep], self.confidence[keep])

    def by_frame(self, first: int, last: int) -> list[NDArray[np.intp]]:
        """The places of the boxes of each frame from first to last, in the order of the file."""
        order = np.argsort(self.frames, kind="stable")
        starts = np.searchsorted(self.frames[order], np.arange(first, last + 2))
        return np.split(order, starts)[1:-1]


def read_mot_challenge(path: str | os.PathLike[str], *, progress: bool = False) -> Boxes:
    """Read a MOTChallenge file of truth or results.

    Parameters
    ----------
    path : str or path
        A text file with a line for each box: frame, id, left, top, width, height, and optionally a
        confidence and more, separated by commas. Blank lines are passed over.

    progress : bool
        Whether a bar on standard error shows how far it is, where it takes longer than a second
        (needs the extra ``progress``).

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
    rows: list[list[float]] = []
    lines: dict[tuple[float, float], int] = {}
    found = _text(path).splitlines()
    seen = watched(found, "reading", len(found), " lines") if progress else found
    for number, line in enumerate(seen, start=1):
        if not line.strip():
            continue
        row = _row(f"{os.fspath(path)}:{number}", line)
        first = lines.setdefault((row[0], row[1]), number)
        if first != number:
            raise ValueError(
                f"{os.fspath(path)}:{number}: frame {row[0]:.0f} has id {row[1]:.0f} twice, "
                f"first on line {first}"
            )
        rows.append(row)
    table = np.array(rows).reshape(len(rows), len(_COLUMNS))
    return Boxes(
        table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2:6], table[:, 6]
    )


def _text(path: str | os.PathLike[str]) -> str:
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{os.fspath(path)} is not a text file") from None


def _row(where: str, line: str) -> list[float]:
    """The first seven numbers of a line; NaN for a confidence that is not there."""
    words = line.split(",")[: len(_COLUMNS)]
    if len(words) < _NEEDED:
        needed = ",".join(_COLUMNS[:_NEEDED])
        raise ValueError(f"{where}: expected {needed} and more, got {len(words)} columns")
    row = [_number(where, column, word) for column, word in zip(_COLUMNS, words, strict=False)]
    for column, value in zip(_COLUMNS[:2], row, strict=False):
        if value != int(value) or abs(value) > 2**53:
            raise ValueError(f"{where}: {column} must be a whole number, got {value!r}")
    return row if len(row) == len(_COLUMNS) else [*row, float("nan")]


def _number(where: str, column: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise ValueError(f"{where}: {column} must be a number, got {word.strip()!r}") from None
    if not np.isfinite(value):
        raise ValueError(f"{where}: {column} must be finite, got {value!r}")
    return value
