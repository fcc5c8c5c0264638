"""Frames of events, built in columns."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.data_frames import pandas

TYPES = ("RAW", "FP", "MISS", "SWITCH", "MATCH", "TRANSFER", "ASCEND", "MIGRATE")
"""The types of events, in the order of the categories."""
RAW, FP, MISS, SWITCH, MATCH, TRANSFER, ASCEND, MIGRATE = range(len(TYPES))


def events_frame(
    frame_ids: Any,
    event_ids: Any,
    types: NDArray[np.int8],
    objects: Any,
    hypotheses: Any,
    distances: Any,
) -> Any:
    """py-motmetrics' frame of events from one column each; ``types`` are indices of ``TYPES``."""
    pd = pandas()
    index = pd.MultiIndex.from_arrays([frame_ids, event_ids], names=["FrameId", "Event"])
    kind = pd.Categorical.from_codes(types, categories=list(TYPES))
    columns = {"Type": kind, "OId": objects, "HId": hypotheses, "D": distances}
    return pd.DataFrame(columns, index=index)


def empty_events_frame() -> Any:
    """A frame of no events, which rows can be added to."""
    pd = pandas()
    none = np.empty(0)
    columns = {"Type": pd.Categorical([], categories=list(TYPES))}
    columns |= dict.fromkeys(("OId", "HId", "D"), none)
    index = pd.MultiIndex(levels=[[], []], codes=[[], []], names=["FrameId", "Event"])
    return pd.DataFrame(columns, index=index)


def type_codes(frame: Any) -> NDArray[np.int8]:
    """The index into ``TYPES`` of each row's type; -1 for a type that is none of them."""
    column = frame["Type"]
    categories = getattr(column.dtype, "categories", None)
    if categories is None or tuple(categories) != TYPES:
        column = pandas().Series(pandas().Categorical(column, categories=list(TYPES)))
    codes: NDArray[np.int8] = column.cat.codes.to_numpy()
    return codes


def id_column(ids: NDArray[Any]) -> NDArray[Any]:
    """Ids as numbers, as py-motmetrics keeps them; where they are none, as they are."""
    if ids.dtype.kind in "biuf":
        return ids.astype(np.float64)
    try:
        return ids.astype(np.float64)
    except (TypeError, ValueError):
        return ids.astype(object)
