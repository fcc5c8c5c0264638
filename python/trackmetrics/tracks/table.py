"""Tracks or truth as a table of columns, one row for each object at each time."""

import os
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors
from trackmetrics.tracks import box_format as forms
from trackmetrics.tracks import formats, frames, identities, masks, named, objects

Floats = NDArray[np.float64]
Codes = NDArray[np.int64]


class RepeatedRowError(ValueError):
    """Two rows have the same time and id."""

    def __init__(self, first: int, second: int, time: Any, label: Any) -> None:
        super().__init__(
            f"rows {first} and {second} both have time {time} and id {label}; "
            "an id may be there once at a time"
        )
        self.first, self.second, self.time, self.id = first, second, time, label


@dataclass(frozen=True, eq=False, repr=False)
class TrackTable:
    """Tracks or truth: a row for each object at each time, in columns.

    Made by :meth:`from_columns` and the other ``from_`` methods, or :func:`read_tracks`. No two
    rows have the same time and id. A column that is not there is None.

    Examples
    --------
    >>> table = TrackTable.from_columns(
    ...     time=[1, 1, 2], id=["ferry", "tug", "ferry"], position=[[0, 0], [9, 9], [1, 0]]
    ... )
    >>> table
    TrackTable(3 rows, 2 ids, 2 times from 1 to 2; position)
    >>> table.with_ids(["ferry"]).position
    array([[0., 0.],
           [1., 0.]])
    """

    time: NDArray[Any]
    """Frame number, time or date of each row, shape (N,)."""
    id: NDArray[Any]
    """Target or track of each row, shape (N,)."""
    codes: Codes
    """A number for the id of each row, ``0 .. len(names) - 1``, shape (N,)."""
    names: tuple[Hashable, ...]
    """The id behind each code."""
    box: Floats | None = None
    """Left, top, width and height, shape (N, 4)."""
    box_3d: Floats | None = None
    """x, y, z of the middle, length, width, height and yaw about z in radians, shape (N, 7)."""
    position: Floats | None = None
    """Position, shape (N, d)."""
    velocity: Floats | None = None
    """Velocity, shape (N, d)."""
    covariance: Floats | None = None
    """Covariance of the position, shape (N, d, d)."""
    score: Floats | None = None
    """Confidence, shape (N,)."""
    cls: NDArray[Any] | None = None
    """Class, shape (N,)."""
    mask: NDArray[Any] | None = None
    """Run-length string of the mask (COCO's), shape (N,)."""
    mask_size: Codes | None = None
    """Height and width of the mask's picture, shape (N, 2)."""
    other: Mapping[str, NDArray[Any]] | None = None
    """Other columns by name, each of length N."""
    counts_frames: bool = False
    """Whether times are numbers of frames, so that one between two others is a frame without
    rows."""

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        n, ids, times = len(self), len(self.names), np.unique(self.time)
        span = f" from {times[0]} to {times[-1]}" if len(times) else ""
        there = [name for name in _DATA if getattr(self, name) is not None and name != "mask_size"]
        listed = ", ".join([*there, *(self.other or ())])
        return (
            f"TrackTable({n} row{'s' * (n != 1)}, {ids} id{'s' * (ids != 1)}, {len(times)} "
            f"time{'s' * (len(times) != 1)}{span}; {listed or 'no other column'})"
        )

    @classmethod
    def from_columns(
        cls_,  # noqa: N804 - cls is a column
        *,
        time: Any,
        id: Any,
        box: Any = None,
        box_3d: Any = None,
        position: Any = None,
        velocity: Any = None,
        covariance: Any = None,
        score: Any = None,
        cls: Any = None,
        mask: Any = None,
        mask_size: Any = None,
        box_format: str = "ltwh",
        other: Mapping[str, Any] | None = None,
        counts_frames: bool = False,
    ) -> "TrackTable":
        """Take columns with a row for each object at each time, in any order.

        Parameters
        ----------
        time : array_like of shape (N,)
            Numbers or dates, in any order.
        id : array_like of shape (N,)
            Target or track of each row; anything hashable.
        box : array_like of shape (N, 4) or (N, 7), optional
            Boxes in the form that ``box_format`` names, or 3-D boxes: x, y, z of the middle,
            length, width, height, yaw about z in radians.
        box_3d : array_like of shape (N, 7), optional
            3-D boxes where there are 2-D boxes as well.
        position, velocity : array_like of shape (N, d), optional
            Position and velocity in any unit.
        covariance : array_like of shape (N, d, d), optional
            Covariance of the position.
        score : array_like of shape (N,), optional
            Confidence.
        cls : array_like of shape (N,), optional
            Class; anything hashable.
        mask : list, optional
            Run-length strings, dictionaries with ``size`` and ``counts``, or arrays of pixels.
        mask_size : array_like of shape (2,) or (N, 2), optional
            Height and width in pixels, where ``mask`` holds strings.
        box_format : {"ltwh", "ltrb"}
            Left, top, width and height, or left, top, right and bottom.
        other : mapping, optional
            Other columns by name.
        counts_frames : bool
            Whether times are numbers of frames, so that a number between two others is a frame
            without rows.

        Returns
        -------
        TrackTable

        Raises
        ------
        ValueError
            Where two rows have the same time and id (the message names both), columns differ in
            length, or a number is not finite.
        """
        forms.check(box_format)
        times = identities.times("time", time)
        n = len(times)
        ids = identities.labels("id", id, n)
        codes, names = identities.encode("id", ids)
        _refuse_repeated(times, ids, codes)
        box = None if box is None else _check.floats("box", box)
        if box is not None and box.ndim == 2 and box.shape[1] == 7:
            box, box_3d = None, box
        box = forms.to_ltwh("box", _rows("box", box, (n, 4)), box_format)
        if mask is not None:
            mask, mask_size = masks.columns(mask, mask_size, n)
        position = _rows("position", position, (n, None))
        d = None if position is None else position.shape[1]
        covariance = _rows("covariance", covariance, (n, d, d))
        if covariance is not None and covariance.shape[1] != covariance.shape[2]:
            raise errors.shape("covariance", covariance.shape, f"({n}, d, d)")
        return cls_(
            times,
            ids,
            codes,
            names,
            box=box,
            box_3d=_rows("box_3d", box_3d, (n, 7)),
            position=position,
            velocity=_rows("velocity", velocity, (n, None)),
            covariance=covariance,
            score=_rows("score", score, (n,), finite=False),
            cls=None if cls is None else identities.labels("cls", cls, n),
            mask=mask,
            mask_size=mask_size,
            other={
                name: column
                if isinstance(column, np.ndarray)
                else identities.labels(name, column, n)
                for name, column in (other or {}).items()
            },
            counts_frames=counts_frames,
        )

    @classmethod
    def from_dict(
        cls, table: Mapping[str, Any], *, columns: named.Mapped | None = None
    ) -> "TrackTable":
        """Take named columns: ``time``, ``id``, ``left``, ``top``, ``width``, ``height``, ``x``,
        ``y``, ``cls``, ``score`` ..., or what ``columns`` maps to them; the rest is kept in
        ``other``."""
        arrays = {name: c if isinstance(c, np.ndarray) else _array(c) for name, c in table.items()}
        return cls.from_columns(**named.take(arrays, columns or {}))

    @classmethod
    def from_frame(cls, frame: Any, *, columns: named.Mapped | None = None) -> "TrackTable":
        """Take a data frame of pandas, Polars or PyArrow, with names as in :meth:`from_dict`."""
        return cls.from_columns(**named.take(frames.columns(frame), columns or {}))

    @classmethod
    def from_frames(
        cls, frames: Sequence[Mapping[str, Any]], *, times: Any = None, box_format: str = "ltwh"
    ) -> "TrackTable":
        """Take a list of frames, each a mapping with ``id`` and other columns; ``times`` are
        0, 1, 2, ... where they are not given."""
        found = objects.from_frames(frames, times)
        return cls.from_columns(**found, box_format=box_format, counts_frames=times is None)

    @classmethod
    def from_detections(cls, detections: Iterable[Any], *, times: Any = None) -> "TrackTable":
        """Take ``supervision.Detections`` with a ``tracker_id``, one object a frame."""
        found = objects.from_detections(detections, times)
        return cls.from_columns(**found, counts_frames=times is None)

    @classmethod
    def from_stone_soup(
        cls,
        tracks: Iterable[Any],
        *,
        position: Sequence[int],
        velocity: Sequence[int] | None = None,
    ) -> "TrackTable":
        """Take Stone Soup's tracks or ground-truth paths.

        ``position`` and ``velocity`` are the places of their components in the state vector. Where
        a track has several states of one time, as a prediction and its update, the last is taken.
        """
        return cls.from_columns(**objects.from_stone_soup(tracks, position, velocity))

    def rows(self, which: Any) -> "TrackTable":
        """The rows that an array of numbers or of truth values, or a slice, names."""
        taken: dict[str, Any] = {
            name: None if getattr(self, name) is None else getattr(self, name)[which]
            for name in ("time", "id", *_DATA)
        }
        ids = self.id[which]
        codes, names = identities.encode("id", ids)
        other = {name: column[which] for name, column in (self.other or {}).items()}
        return replace(self, **taken, codes=codes, names=names, other=other)

    def between(self, first: Any = None, last: Any = None) -> "TrackTable":
        """The rows from one time to another, both included."""
        keep = np.ones(len(self), dtype=np.bool_)
        if first is not None:
            keep &= self.time >= first
        if last is not None:
            keep &= self.time <= last
        return self.rows(keep)

    def with_ids(self, ids: Iterable[Hashable]) -> "TrackTable":
        """The rows of these ids."""
        wanted = set(ids)
        return self.rows(
            np.array([name in wanted for name in self.names], dtype=np.bool_)[self.codes]
        )

    def with_classes(self, classes: Iterable[Hashable]) -> "TrackTable":
        """The rows of these classes."""
        if self.cls is None:
            raise ValueError("the table has no classes (cls)")
        codes, names = identities.encode("cls", self.cls)
        wanted = set(classes)
        return self.rows(np.array([name in wanted for name in names], dtype=np.bool_)[codes])

    def without(self, *names: str) -> "TrackTable":
        """The table without these columns."""
        for name in names:
            if name not in _DATA and name not in (self.other or {}):
                raise ValueError(f"the table has no column {name!r} that can be left out")
        drop: dict[str, Any] = {name: None for name in names if name in _DATA}
        if "mask" in drop:
            drop["mask_size"] = None
        other = {name: c for name, c in (self.other or {}).items() if name not in names}
        return replace(self, **drop, other=other)

    def columns(self) -> dict[str, Any]:
        """The columns as :meth:`from_columns` takes them."""
        found = {name: getattr(self, name) for name in ("time", "id", *_DATA)}
        return {
            **{k: c for k, c in found.items() if c is not None},
            "other": dict(self.other or {}),
        }

    def to_dict(self) -> dict[str, NDArray[Any]]:
        """Named columns, one a component, as :meth:`from_dict` takes them."""
        return named.give(self.columns())

    def pixels(self) -> list[NDArray[np.bool_]]:
        """The masks as arrays of height x width (needs pycocotools, the extra ``masks``)."""
        if self.mask is None or self.mask_size is None:
            raise ValueError("the table has no masks")
        return masks.pixels(self.mask, self.mask_size)

    def write(self, path: str | os.PathLike[str], *, format: str | None = None) -> None:
        """Write a file that :func:`read_tracks` reads.

        ``format`` is one of ``"motchallenge"``, ``"kitti"``, ``"kitti_mots"``, ``"csv"`` and
        ``"parquet"``; the endings ``.csv`` and ``.parquet`` need none. A column that the format
        cannot hold is an error.
        """
        formats.to_write(Path(path), format).write(Path(path), self.columns())


_DATA = tuple(f.name for f in fields(TrackTable) if f.default is None and f.name != "other")


def _array(values: Any) -> NDArray[Any]:
    array = np.asarray(values)
    return identities.labels("column", values) if array.dtype.kind in "USO" else array


def _rows(
    argument: str, values: Any, shape: tuple[int | None, ...], *, finite: bool = True
) -> Floats | None:
    if values is None:
        return None
    array = _check.floats(argument, values)
    if shape[0] == 0 and array.size == 0:
        return np.empty(tuple(size or 0 for size in shape))
    sizes = zip(array.shape, shape, strict=False)
    if array.ndim != len(shape) or any(b is not None and a != b for a, b in sizes):
        listed = ", ".join("d" if size is None else str(size) for size in shape)
        raise errors.shape(argument, array.shape, f"({listed}{',' * (len(shape) == 1)})")
    wrong = np.argwhere(~np.isfinite(array))
    if finite and len(wrong):
        raise errors.not_finite(argument, wrong[0].tolist(), float(array[tuple(wrong[0])]))
    return array


def _refuse_repeated(times: NDArray[Any], ids: NDArray[Any], codes: Codes) -> None:
    order = np.lexsort((codes, times))
    same = (times[order][1:] == times[order][:-1]) & (np.diff(codes[order]) == 0)
    if same.any():
        second = int(order[1:][same].min())
        both = (times == times[second]) & (codes == codes[second])
        raise RepeatedRowError(int(np.argmax(both)), second, times[second], ids[second])
