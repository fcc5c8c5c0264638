"""Truth and tracks of one sequence, sorted by frame: the input of every score over identities."""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors
from trackmetrics.tracking.labels import labels
from trackmetrics.tracks import Boxes, TrackTable
from trackmetrics.tracks import box_format as box_formats
from trackmetrics.tracks.identities import times as times_of

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrameColumns:
    """The rows of one side, sorted by frame; within a frame in the order in which they came."""

    ids: Codes
    """Code of each row's id, ``0 .. len(names) - 1``, shape (N,)."""
    names: tuple[Hashable, ...]
    """The id behind each code."""
    starts: Codes
    """Frame t has the rows ``starts[t]`` to ``starts[t + 1] - 1``; shape (T + 1,)."""
    boxes: Floats | None
    """Left, top, width and height of each row, shape (N, 4)."""
    positions: Floats | None
    """Position of each row, shape (N, d)."""

    def __len__(self) -> int:
        return len(self.ids)

    def coded(self) -> tuple[Codes, Codes, int]:
        """Codes, starts and number of ids, as kernels take them."""
        ids, starts = (_check.plain(column, np.int64) for column in (self.ids, self.starts))
        return ids, starts, len(self.names)

    def centres(self, argument: str) -> Floats:
        """The positions; without them the centres of the boxes."""
        if self.positions is not None:
            return self.positions
        if self.boxes is not None:
            return self.boxes[:, :2] + self.boxes[:, 2:] / 2
        raise ValueError(f"{argument} has neither positions nor boxes, and the distance needs one")


@dataclass(frozen=True, eq=False)
class TrackFrames:
    """Truth and tracks of one sequence, frame by frame.

    Made by :meth:`from_boxes` or :meth:`from_columns`.

    Examples
    --------
    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 2], ["ferry", "ferry", "tug"], [1, 2], [7, 7],
    ...     truth_positions=[[0.0], [1.0], [9.0]], track_positions=[[0.5], [1.5]],
    ... )
    >>> frames
    TrackFrames(2 frames, 3 truth rows of 2 ids, 2 track rows of 1 ids)
    """

    times: NDArray[Any]
    """The frame numbers or times, rising, shape (T,)."""
    truth: FrameColumns
    """The rows of the truth."""
    tracks: FrameColumns
    """The rows of the tracks."""

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        truth, tracks = self.truth, self.tracks
        return (
            f"TrackFrames({len(self)} frames, {len(truth)} truth rows of {len(truth.names)} ids, "
            f"{len(tracks)} track rows of {len(tracks.names)} ids)"
        )

    def slices(self) -> Iterator[tuple[int, slice, slice]]:
        """Index of each frame with a row on both sides, its truth rows and its track rows."""
        a, b = self.truth.starts, self.tracks.starts
        for t in np.flatnonzero((np.diff(a) > 0) & (np.diff(b) > 0)):
            yield int(t), slice(int(a[t]), int(a[t + 1])), slice(int(b[t]), int(b[t + 1]))

    @classmethod
    def from_boxes(
        cls, truth: Boxes, tracks: Boxes, *, times: Sequence[int] | None = None
    ) -> "TrackFrames":
        """Take the boxes of two MOTChallenge files.

        Parameters
        ----------
        truth, tracks : Boxes
            As :func:`trackmetrics.tracks.read_mot_challenge` reads them. Every row counts; call
            ``truth.counted()`` first where the confidence column says which rows do.
        times : sequence of int, optional
            All frame numbers of the sequence, for frames that are empty on both sides. Without it
            all from the first to the last frame that has a box.

        Returns
        -------
        TrackFrames

        Raises
        ------
        ValueError
            Where one side has an id twice in a frame, or ``times`` lacks a frame of a box.
        """
        if times is None:
            both = np.concatenate([truth.frames, tracks.frames])
            times = range(int(both.min()), int(both.max()) + 1) if len(both) else ()
        return cls.from_columns(
            truth.frames,
            truth.ids,
            tracks.frames,
            tracks.ids,
            truth_boxes=truth.boxes,
            track_boxes=tracks.boxes,
            times=times,
        )

    @classmethod
    def from_tables(
        cls, truth: TrackTable, tracks: TrackTable, *, times: Any = None
    ) -> "TrackFrames":
        """Take two track tables.

        Without ``times``, frames are the times of the rows; where both tables count frames (files
        of MOTChallenge and KITTI do), all numbers from the first to the last.
        """
        for argument, table in (("truth", truth), ("tracks", tracks)):
            if not isinstance(table, TrackTable):
                kind = type(table).__name__
                raise TypeError(f"{argument} must be a TrackTable, got {kind}")
        sides = (truth.time, tracks.time)
        if times is None and truth.counts_frames and tracks.counts_frames:
            both = np.concatenate(sides)
            times = np.arange(both.min(), both.max() + 1) if len(both) else None
        listed = _all_times(sides, times)
        return cls(listed, _table_side(truth, listed), _table_side(tracks, listed))

    @classmethod
    def from_columns(
        cls,
        truth_times: Any,
        truth_ids: Any,
        track_times: Any,
        track_ids: Any,
        *,
        truth_boxes: Any = None,
        track_boxes: Any = None,
        truth_positions: Any = None,
        track_positions: Any = None,
        box_format: str = "ltwh",
        times: Any = None,
    ) -> "TrackFrames":
        """Take columns with a row for each object in each frame, in any order.

        Parameters
        ----------
        truth_times, track_times : array_like of shape (N,) and (M,)
            Frame number or time of each row: numbers or dates. Equal times are one frame.
        truth_ids, track_ids : array_like of shape (N,) and (M,)
            Target or track of each row; anything hashable.
        truth_boxes, track_boxes : array_like of shape (N, 4) and (M, 4), optional
            Boxes in any unit, in the form that ``box_format`` names.
        truth_positions, track_positions : array_like of shape (N, d) and (M, d), optional
            Positions in any unit.
        box_format : {"ltwh", "ltrb"}
            Left, top, width and height, or left, top, right and bottom.
        times : array_like of shape (T,), optional
            All times of the sequence, for frames that are empty on both sides.

        Returns
        -------
        TrackFrames

        Raises
        ------
        ValueError
            Where one side has an id twice in a frame (the message names both rows), columns differ
            in length, a number is not finite, or ``times`` lacks the time of a row.
        """
        box_formats.check(box_format)
        columns = times_of("truth_times", truth_times), times_of("track_times", track_times)
        listed = _all_times(columns, times)
        sides = (
            _side("truth", columns[0], truth_ids, truth_boxes, truth_positions, box_format, listed),
            _side("track", columns[1], track_ids, track_boxes, track_positions, box_format, listed),
        )
        return cls(listed, *sides)


def as_frames(frames: Any, tracks: Any) -> TrackFrames:
    """The frames given, or those of two track tables."""
    if isinstance(frames, TrackTable) or tracks is not None:
        return TrackFrames.from_tables(frames, tracks)
    if not isinstance(frames, TrackFrames):
        raise TypeError(f"frames must be TrackFrames, got {type(frames).__name__}")
    return frames


def _table_side(table: TrackTable, times: NDArray[Any]) -> FrameColumns:
    frames = np.searchsorted(times, table.time) if len(table) else np.empty(0, dtype=np.int64)
    order = np.argsort(frames, kind="stable")
    return FrameColumns(
        table.codes[order],
        table.names,
        np.searchsorted(frames[order], np.arange(len(times) + 1)).astype(np.int64),
        None if table.box is None else table.box[order],
        None if table.position is None else table.position[order],
    )


def _all_times(columns: tuple[NDArray[Any], ...], times: Any) -> NDArray[Any]:
    filled = [column for column in columns if len(column)]
    if len({column.dtype.kind in "mM" for column in filled}) > 1:
        kinds = [column.dtype for column in filled]
        raise TypeError(f"truth has times of {kinds[0]}, tracks of {kinds[1]}: expected one kind")
    present = np.unique(np.concatenate(filled)) if filled else np.empty(0, dtype=np.int64)
    if times is None:
        return present
    listed = np.unique(times_of("times", times))
    missing = present[~np.isin(present, listed)]
    if len(missing):
        raise ValueError(f"times lacks {missing[0]}, the time of a row")
    return listed


def _side(
    name: str,
    column: NDArray[Any],
    ids: Any,
    boxes: Any,
    positions: Any,
    box_format: str,
    times: NDArray[Any],
) -> FrameColumns:
    """One side's rows, checked and sorted by frame."""
    ids = ids if isinstance(ids, np.ndarray) else list(ids)
    if len(ids) != len(column):
        raise errors.length(f"{name}_ids", len(ids), f"{name}_times", len(column), "rows")
    _, first, codes = np.unique(labels(f"{name}_ids", ids), return_index=True, return_inverse=True)
    frames = np.searchsorted(times, column) if len(column) else np.empty(0, dtype=np.int64)
    _refuse_duplicates(name, column, ids, frames, codes)
    order = np.argsort(frames, kind="stable")
    boxes = _rows(f"{name}_boxes", boxes, len(column), 4)
    boxes = box_formats.to_ltwh(f"{name}_boxes", boxes, box_format)
    positions = _rows(f"{name}_positions", positions, len(column), None)
    return FrameColumns(
        codes[order].astype(np.int64),
        tuple(ids[i].item() if isinstance(ids[i], np.generic) else ids[i] for i in first),
        np.searchsorted(frames[order], np.arange(len(times) + 1)).astype(np.int64),
        None if boxes is None else boxes[order],
        None if positions is None else positions[order],
    )


def _refuse_duplicates(
    name: str, column: NDArray[Any], ids: Any, frames: NDArray[Any], codes: NDArray[Any]
) -> None:
    order = np.lexsort((codes, frames))
    same = (np.diff(frames[order]) == 0) & (np.diff(codes[order]) == 0)
    if same.any():
        seconds = order[1:][same]
        second = int(seconds.min())
        first = int(order[int(np.flatnonzero(order == second)[0]) - 1])
        raise ValueError(
            f"{name} rows {first} and {second} both have time {column[second]} "
            f"and id {ids[second]}; an id may be there once in a frame"
        )


def _rows(argument: str, values: Any, length: int, width: int | None) -> Floats | None:
    if values is None:
        return None
    array = _check.floats(argument, values)
    if array.size == 0 and length == 0:
        return np.empty((0, width or 0))
    if array.ndim != 2 or len(array) != length or (width and array.shape[1] != width):
        raise errors.shape(argument, array.shape, f"({length}, {width or 'd'})")
    wrong = np.argwhere(~np.isfinite(array))
    if len(wrong):
        raise errors.not_finite(argument, wrong[0].tolist(), float(array[tuple(wrong[0])]))
    return array
