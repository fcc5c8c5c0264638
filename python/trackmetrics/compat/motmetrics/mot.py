"""py-motmetrics' accumulator of events, frame by frame, over our assignment."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.data_frames import pandas
from trackmetrics.compat.motmetrics import _events, lap
from trackmetrics.compat.motmetrics._merging import merge_frames, renamed_counts

Row = tuple[int, int, int, float]
"""Type, object's index, hypothesis' index (-1 for none) and distance of one event."""


class MOTAccumulator:
    """Events of a tracker against truth, as ``motmetrics.MOTAccumulator`` makes them.

    Parameters
    ----------
    auto_id : bool
        Whether frames are numbered from 0; otherwise each update names its frame.
    max_switch_time : float
        Longest time, in the unit of the frame ids, since an object was last seen after which
        another hypothesis is a switch.

    Notes
    -----
    Ids that are no numbers are kept as they are, where py-motmetrics fails.

    References
    ----------
    Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
    metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309.

    Examples
    --------
    >>> acc = MOTAccumulator(auto_id=True)
    >>> acc.update([1, 2], [7], [[0.1], [0.4]])
    0
    >>> list(acc.mot_events["Type"])
    ['MATCH', 'MISS']
    """

    def __init__(self, auto_id: bool = False, max_switch_time: float = float("inf")) -> None:
        self.auto_id = auto_id
        self.max_switch_time = max_switch_time
        self.reset()

    def reset(self) -> None:
        """Forget all frames."""
        self._frame_ids: list[Any] = []
        self._parts: list[tuple[NDArray[Any], ...]] = []
        self._cached: Any = None
        self.m: dict[Any, Any] = {}
        """The last hypothesis of each object."""
        self.res_m: dict[Any, Any] = {}
        """The last object that each hypothesis was newly assigned to."""
        self.last_occurrence: dict[Any, Any] = {}
        """The last frame that each object was in."""
        self.last_match: dict[Any, Any] = {}
        """The last frame that each object was matched in."""
        self.hypHistory: dict[Any, Any] = {}
        """The last frame that each hypothesis was matched in."""

    def update(self, oids: Any, hids: Any, dists: Any, frameid: Any = None, vf: Any = "") -> Any:
        """Add a frame.

        Pairs of earlier frames are continued where their distance is finite; the others are
        matched by :func:`lap.linear_sum_assignment`.

        Parameters
        ----------
        oids, hids : array_like of shape (N,) and (M,)
            Ids of the objects and hypotheses in the frame.
        dists : array_like of shape (N, M)
            Distances; NaN or infinite where a pair may not be.
        frameid : optional
            The frame, where ``auto_id`` is not set.
        vf : file, optional
            Takes a line for each switch, transfer, miss and false alarm.

        Returns
        -------
        The id of the frame.

        Raises
        ------
        AssertionError
            Where ``frameid`` is missing, or is given with ``auto_id`` (py-motmetrics' type of
            error).
        ValueError
            Where ``dists`` does not have N x M elements.
        """
        frameid = self._next_frame(frameid)
        objects, hypotheses = np.asarray(oids), np.asarray(hids)
        distances = np.array(dists, dtype=np.float64).reshape(len(objects), len(hypotheses))
        names, others = objects.tolist(), hypotheses.tolist()
        raw = _raw_rows(distances)
        rows = self._continue(names, others, distances, frameid)
        free_objects, free_hypotheses = _free(rows, len(names), len(others))
        log: list[str] = []
        if len(names) and len(others):
            distances[~free_objects] = np.nan
            distances[:, ~free_hypotheses] = np.nan
            rows += self._assign(names, others, distances, frameid, log)
            free_objects, free_hypotheses = _free(rows, len(names), len(others))
        missed, false = np.flatnonzero(free_objects), np.flatnonzero(free_hypotheses)
        rows += [(_events.MISS, i, -1, np.nan) for i in missed.tolist()]
        rows += [(_events.FP, -1, j, np.nan) for j in false.tolist()]
        self._add(frameid, objects, hypotheses, raw, rows)
        self.last_occurrence.update(dict.fromkeys(names, frameid))
        if vf != "":
            log += [f"FN {int(frameid)} {int(names[i])}\n" for i in missed]
            log += [f"FP {int(frameid)} {int(others[j])}\n" for j in false]
            vf.write("".join(log))
        return frameid

    def _next_frame(self, frameid: Any) -> Any:
        if frameid is not None:
            if self.auto_id:
                raise AssertionError("frameid must not be given where auto_id is set")
            return frameid
        if not self.auto_id:
            raise AssertionError("frameid must be given where auto_id is not set")
        return self._frame_ids[-1] + 1 if self._frame_ids else 0

    def _continue(
        self, names: list[Any], others: list[Any], distances: Any, frameid: Any
    ) -> list[Row]:
        """Pairs of earlier frames, in the order of the objects."""
        places: dict[Any, list[int]] = {}
        for j, name in enumerate(others):
            places.setdefault(name, []).append(j)
        rows = []
        for i, name in enumerate(names):
            free = places.get(self.m[name]) if name in self.m else None
            if not free or not np.isfinite(distances[i, free[0]]):
                continue
            j = free.pop(0)
            rows.append((_events.MATCH, i, j, float(distances[i, j])))
            self.m[name] = others[j]
            self.last_match[name] = self.hypHistory[others[j]] = frameid
        return rows

    def _assign(
        self, names: list[Any], others: list[Any], distances: Any, frameid: Any, log: list[str]
    ) -> list[Row]:
        """The pairs of the assignment; switches and transfers have further events before them."""
        rows: list[Row] = []
        if not np.isfinite(distances).any() and lap.default_solver == "trackmetrics":
            return rows
        pairs = zip(*(side.tolist() for side in lap.linear_sum_assignment(distances)), strict=True)
        for i, j in pairs:
            distance = float(distances[i, j])
            if not np.isfinite(distance):
                continue
            name, other = names[i], others[j]
            is_switch = self._is_switch(name, other, frameid)
            is_transfer = other in self.res_m and self.res_m[other] != name
            is_ascend = is_switch and other not in self.hypHistory
            is_migrate = is_transfer and name not in self.last_match
            kinds = [_events.ASCEND] * is_ascend + [_events.MIGRATE] * is_migrate
            kinds += [_events.TRANSFER] * is_transfer
            kinds.append(_events.SWITCH if is_switch else _events.MATCH)
            rows += [(kind, i, j, distance) for kind in kinds]
            if is_switch:
                numbers = (name, self.last_match[name], self.m[name], frameid, other)
                log.append(_line("AS" if is_ascend else "SW", numbers))
            if is_transfer:
                numbers = (other, self.hypHistory[other], self.res_m[other], frameid, name)
                log.append(_line("MI" if is_migrate else "TR", numbers))
            self.m[name], self.res_m[other] = other, name
            self.hypHistory[other] = self.last_match[name] = frameid
        return rows

    def _is_switch(self, name: Any, other: Any, frameid: Any) -> bool:
        if name not in self.m or self.m[name] == other:
            return False
        if self.max_switch_time == float("inf"):
            return True
        return bool(abs(frameid - self.last_occurrence[name]) <= self.max_switch_time)

    def _add(
        self,
        frameid: Any,
        objects: NDArray[Any],
        hypotheses: NDArray[Any],
        raw: tuple[NDArray[Any], ...],
        rows: list[Row],
    ) -> None:
        new = np.array(rows, dtype=np.float64).reshape(-1, 4).T
        i = np.concatenate([raw[0], new[1].astype(np.int64)])
        j = np.concatenate([raw[1], new[2].astype(np.int64)])
        kinds = np.concatenate([np.zeros(len(raw[0]), np.int8), new[0].astype(np.int8)])
        d = np.concatenate([raw[2], new[3]])
        self._parts.append((kinds, _named(objects, i), _named(hypotheses, j), d))
        self._frame_ids.append(frameid)
        self._cached = None

    @property
    def events(self) -> Any:
        """All events: a pandas frame indexed by FrameId and Event, columns Type, OId, HId, D."""
        if self._cached is None:
            self._cached = self._build()
        return self._cached

    def _build(self) -> Any:
        if not self._parts:
            return _events.empty_events_frame()
        kinds, objects, hypotheses, d = map(np.concatenate, zip(*self._parts, strict=True))
        counts = np.array([len(part[0]) for part in self._parts])
        starts = np.cumsum(counts) - counts
        event_ids = np.arange(counts.sum()) - np.repeat(starts, counts)
        frame_ids = pandas().Index(self._frame_ids).repeat(counts)
        return _events.events_frame(frame_ids, event_ids, kinds, objects, hypotheses, d)

    @property
    def mot_events(self) -> Any:
        """The events without those of type RAW."""
        events = self.events
        return events[_events.type_codes(events) != _events.RAW]

    @staticmethod
    def new_event_dataframe() -> Any:
        """A frame of no events."""
        return _events.empty_events_frame()

    @staticmethod
    def new_event_dataframe_with_data(indices: Any, events: Any) -> Any:
        """A frame of events from dicts of lists, ``FrameId`` and ``Event``, ``Type``, ``OId``,
        ``HId`` and ``D``."""
        if not events:
            return _events.empty_events_frame()
        codes = np.array([_events.TYPES.index(kind) for kind in events["Type"]], dtype=np.int8)
        objects, hypotheses = (_events.id_column(np.asarray(events[key])) for key in ("OId", "HId"))
        distances = np.asarray(events["D"], dtype=np.float64)
        return _events.events_frame(
            indices["FrameId"], indices["Event"], codes, objects, hypotheses, distances
        )

    @staticmethod
    def merge_analysis(anas: Iterable[Any], infomap: Iterable[Any]) -> Any:
        """The counts of several sequences under the ids of the merged events; None where one of
        them is None."""
        return renamed_counts(anas, infomap)

    @staticmethod
    def merge_event_dataframes(
        dfs: Sequence[Any],
        update_frame_indices: bool = True,
        update_oids: bool = True,
        update_hids: bool = True,
        return_mappings: bool = False,
    ) -> Any:
        """The events of several sequences in one frame.

        Parameters
        ----------
        dfs : list of DataFrame or MOTAccumulator
            The sequences.
        update_frame_indices, update_oids, update_hids : bool
            Whether frames, objects and hypotheses of different sequences stay different.
        return_mappings : bool
            Whether to return the new names as well.

        Returns
        -------
        df : DataFrame
            The events.
        mappings : list of dict
            For each sequence ``frame_offset``, ``oid_map`` and ``hid_map``.
        """
        frames = [df.events if isinstance(df, MOTAccumulator) else df for df in dfs]
        merged, mappings = merge_frames(frames, update_frame_indices, update_oids, update_hids)
        return (merged, mappings) if return_mappings else merged


def _raw_rows(distances: NDArray[np.float64]) -> tuple[NDArray[Any], ...]:
    """Object, hypothesis and distance of the raw events: one for the frame, the finite pairs, then
    who has no finite pair."""
    finite = np.isfinite(distances)
    i, j = np.nonzero(finite)
    alone = np.flatnonzero(~finite.any(axis=1))
    others = np.flatnonzero(~finite.any(axis=0))
    objects = np.concatenate([[-1], i, alone, np.full(len(others), -1)])
    hypotheses = np.concatenate([[-1], j, np.full(len(alone), -1), others])
    values = np.full(len(objects), np.nan)
    values[1 : 1 + len(i)] = distances[i, j]
    return objects, hypotheses, values


def _free(rows: list[Row], objects: int, hypotheses: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Which objects and hypotheses are in none of the rows."""
    free = np.ones(objects, dtype=np.bool_), np.ones(hypotheses, dtype=np.bool_)
    free[0][[row[1] for row in rows]] = False
    free[1][[row[2] for row in rows]] = False
    return free


def _named(ids: NDArray[Any], rows: NDArray[Any]) -> NDArray[Any]:
    """The id at each index, NaN at -1."""
    column = _events.id_column(ids)
    with_none: NDArray[Any] = np.append(column, np.array([np.nan], dtype=column.dtype))
    taken: NDArray[Any] = with_none[rows]
    return taken


def _line(kind: str, numbers: tuple[Any, ...]) -> str:
    return " ".join([kind, *(str(int(number)) for number in numbers)]) + "\n"
