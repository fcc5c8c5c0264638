"""MOTChallenge files: a line for each box, ``frame,id,left,top,width,height[,confidence,...]``."""

import io
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import opening
from trackmetrics._tables.polars_columns import polars

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
    """Read a MOTChallenge file of truth or results.

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
    name = os.fspath(path)
    content = opening.read(path, may_be_empty=True)
    if content.kind != "text":
        raise ValueError(f"{name} is a {content.kind} file, expected text")
    table = _read_whole(content.data)
    if table is None:
        table = _read_by_line(name, content.data.decode())
    return Boxes(
        table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2:6], table[:, 6]
    )


def _read_whole(data: bytes) -> NDArray[np.float64] | None:
    """The first seven columns by Polars; None where it is absent or something is wrong."""
    pl = polars()
    if pl is None or not data.strip():
        return None
    try:
        frame = pl.read_csv(
            io.BytesIO(data),
            has_header=False,
            infer_schema_length=0,
            quote_char=None,
            columns=list(range(min(len(_COLUMNS), data.partition(b"\n")[0].count(b",") + 1))),
        )
        cells = frame.select(pl.all().str.strip_chars().cast(pl.Float64))
        table: NDArray[np.float64] = cells.to_numpy()
    except pl.exceptions.PolarsError:
        return None
    if not _NEEDED <= table.shape[1] <= len(_COLUMNS):
        return None
    if table.shape[1] == _NEEDED:
        table = np.column_stack([table, np.full(len(table), np.nan)])
    elif not np.isfinite(table).all():
        return None
    whole = table[:, :2]
    if not np.isfinite(table[:, :_NEEDED]).all() or (np.abs(whole) > 2**53).any():
        return None
    if (whole != np.trunc(whole)).any() or _has_duplicates(whole.astype(np.int64)):
        return None
    return table


def _has_duplicates(keys: NDArray[np.int64]) -> bool:
    order = np.lexsort(keys.T)
    return bool((np.diff(keys[order], axis=0) == 0).all(axis=1).any())


def _read_by_line(name: str, text: str) -> NDArray[np.float64]:
    """The same line by line, with a message that names the first line that is wrong."""
    rows: list[list[float]] = []
    lines: dict[tuple[float, float], int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        row = _row(f"{name}:{number}", line)
        first = lines.setdefault((row[0], row[1]), number)
        if first != number:
            raise ValueError(
                f"{name}:{number}: frame {row[0]:.0f} has id {row[1]:.0f} twice, "
                f"first on line {first}"
            )
        rows.append(row)
    return np.array(rows).reshape(len(rows), len(_COLUMNS))


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
