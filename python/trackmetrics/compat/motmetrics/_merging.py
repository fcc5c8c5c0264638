"""Events of several sequences in one frame."""

from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any

import numpy as np

from trackmetrics._tables.data_frames import pandas
from trackmetrics.compat.motmetrics._events import empty_events_frame


def merge_frames(
    frames: Sequence[Any], new_frames: bool, new_objects: bool, new_hypotheses: bool
) -> tuple[Any, list[dict[str, Any]]]:
    """The merged events, and for each sequence what its frames and ids have become."""
    names = {"OId": count(), "HId": count()}
    renamed = {"OId": new_objects, "HId": new_hypotheses}
    offset = 0
    parts: list[Any] = []
    mappings: list[dict[str, Any]] = []
    for frame in frames:
        mapping: dict[str, Any] = {}
        part = frame.copy()
        if new_frames:
            part.index = _shifted(frame.index, offset)
            mapping["frame_offset"] = offset
            offset = _next_offset(part.index, offset, parts)
        for column, numbers in names.items():
            if renamed[column]:
                new = {old: str(next(numbers)) for old in frame[column].dropna().unique()}
                part[column] = _renamed(frame[column], new)
                mapping[f"{column[0].lower()}id_map"] = new
        parts.append(part)
        mappings.append(mapping)
    filled = [part for part in parts if len(part)]
    return pandas().concat(filled) if filled else empty_events_frame(), mappings


def _shifted(index: Any, offset: Any) -> Any:
    pd = pandas()
    frames, events = index.get_level_values(0), index.get_level_values(1)
    return pd.MultiIndex.from_arrays([frames + offset, events], names=index.names)


def _next_offset(index: Any, offset: Any, parts: Sequence[Any]) -> Any:
    """Above every frame so far, and at least their number."""
    if not len(index):
        return offset
    frames = index.get_level_values(0)
    seen = [part.index.get_level_values(0) for part in parts] + [frames]
    number = len(set().union(*(set(one) for one in seen)))
    last = max(one.max() for one in seen if len(one))
    return max(last + 1, number)


def _renamed(column: Any, new: dict[Any, str]) -> Any:
    values = [new.get(value, np.nan) for value in column]
    return np.array(values, dtype=object)


def renamed_counts(counts: Iterable[Any], mappings: Iterable[Any]) -> Any:
    """Counts per object and hypothesis under the names of the merged events."""
    merged: dict[str, dict[int, Any]] = {"hyp": {}, "obj": {}}
    for count_of, mapping in zip(counts, mappings, strict=False):
        if count_of is None:
            return None
        for side, values in count_of.items():
            new = mapping["hid_map" if side == "hyp" else "oid_map"]
            for missing in (np.nan, "nan"):
                if missing in new:
                    merged[side][int(new[missing])] = 0
            for name, number in values.items():
                merged[side][int(new[name if name in new else str(name)])] = number
    return merged
