"""The parts of a frame of events that metrics look at, made when they are first asked for."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.data_frames import pandas
from trackmetrics.compat.motmetrics import _events


@dataclass(frozen=True, eq=False)
class Columns:
    """Events in arrays."""

    types: NDArray[np.int8]
    objects: NDArray[Any]
    hypotheses: NDArray[Any]
    distances: NDArray[np.float64]
    frames: NDArray[np.int64]
    """Number of the event's frame."""

    @classmethod
    def of(cls, frame: Any) -> "Columns":
        """The columns of a frame of events."""
        frames = frame.index.get_level_values(0)
        return cls(
            _events.type_codes(frame),
            frame["OId"].to_numpy(),
            frame["HId"].to_numpy(),
            frame["D"].to_numpy(dtype=np.float64, na_value=np.nan),
            pandas().factorize(frames)[0].astype(np.int64),
        )

    def where(self, mask: NDArray[np.bool_]) -> "Columns":
        """The rows of a mask."""
        return Columns(*(getattr(self, name)[mask] for name in self.__dataclass_fields__))

    def count(self, kind: int) -> np.int64:
        """Number of events of a type."""
        return np.int64(np.count_nonzero(self.types == kind))


class DataFrameMap:
    """The events of a sequence, whole and in parts.

    Parameters
    ----------
    full : DataFrame
        All events.
    raw, noraw, extra : DataFrame, optional
        Events of type RAW; events without RAW, ASCEND, TRANSFER and MIGRATE; events without RAW.
        Taken from ``full`` where they are not given.
    """

    def __init__(self, full: Any, raw: Any = None, noraw: Any = None, extra: Any = None) -> None:
        self.full = full
        self._given = {"raw": raw, "noraw": noraw, "extra": extra}

    @cached_property
    def columns(self) -> Columns:
        """All events in arrays."""
        return Columns.of(self.full)

    def _mask(self, part: str) -> Any:
        types: Any = self.columns.types
        if part == "raw":
            return types == _events.RAW
        if part == "extra":
            return types != _events.RAW
        return (types != _events.RAW) & (types < _events.TRANSFER)

    def _frame(self, part: str) -> Any:
        given = self._given[part]
        return self.full[self._mask(part)] if given is None else given

    def _columns(self, part: str) -> Columns:
        given = self._given[part]
        return self.columns.where(self._mask(part)) if given is None else Columns.of(given)

    @cached_property
    def raw(self) -> Any:
        """Events of type RAW."""
        return self._frame("raw")

    @cached_property
    def noraw(self) -> Any:
        """Matches, switches, misses and false alarms."""
        return self._frame("noraw")

    @cached_property
    def extra(self) -> Any:
        """Events without those of type RAW."""
        return self._frame("extra")

    @cached_property
    def raw_columns(self) -> Columns:
        """``raw`` in arrays."""
        return self._columns("raw")

    @cached_property
    def noraw_columns(self) -> Columns:
        """``noraw`` in arrays."""
        return self._columns("noraw")

    @cached_property
    def extra_columns(self) -> Columns:
        """``extra`` in arrays."""
        return self._columns("extra")


def events_to_df_map(df: Any) -> DataFrameMap:
    """The parts of a frame of events."""
    return DataFrameMap(df)
