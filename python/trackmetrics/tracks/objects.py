"""Columns out of what trackers give: lists of frames, detections, Stone Soup's tracks."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np


def from_frames(frames: Sequence[Mapping[str, Any]], times: Any = None) -> dict[str, Any]:
    """The rows of a list of frames, each a mapping of the same columns without ``time``."""
    frames = list(frames)
    times = np.arange(len(frames)) if times is None else np.asarray(times)
    if len(times) != len(frames):
        raise ValueError(f"times has {len(times)} elements, frames has {len(frames)}")
    filled = [(t, frame) for t, frame in enumerate(frames) if len(frame.get("id", ()))]
    names = set().union(*(frame for _, frame in filled)) if filled else {"id"}
    for t, frame in filled:
        lacking = names - frame.keys()
        if lacking:
            raise ValueError(f"frames[{t}] has no {min(lacking)}, which other frames have")
        for name in names:
            if len(frame[name]) != len(frame["id"]):
                raise ValueError(
                    f"frames[{t}][{name!r}] has {len(frame[name])} rows, id has {len(frame['id'])}"
                )
    counts = [len(frame.get("id", ())) for frame in frames]
    joined = {name: _joined([frame[name] for _, frame in filled]) for name in sorted(names)}
    return {"time": np.repeat(times, counts), **joined}


def _joined(parts: list[Any]) -> Any:
    if parts and all(isinstance(part, np.ndarray) for part in parts):
        return np.concatenate(parts)
    return [row for part in parts for row in part]


def from_detections(detections: Iterable[Any], times: Any = None) -> dict[str, Any]:
    """The rows of ``supervision.Detections``, one object a frame."""
    frames = []
    for t, found in enumerate(detections):
        if found.tracker_id is None and len(found.xyxy):
            raise ValueError(f"detections[{t}] has no tracker_id: run a tracker first")
        frame = {"id": [] if found.tracker_id is None else found.tracker_id, "box": found.xyxy}
        given = (("score", found.confidence), ("cls", found.class_id), ("mask", found.mask))
        frames.append(frame | {name: value for name, value in given if value is not None})
    return {**from_frames(frames, times), "box_format": "ltrb"}


def from_stone_soup(
    tracks: Iterable[Any], position: Sequence[int], velocity: Sequence[int] | None
) -> dict[str, Any]:
    """The states of Stone Soup's tracks or ground-truth paths; the last one of each time."""
    chosen = [*position, *(velocity or ())]
    times, ids, values, covariances = [], [], [], []
    for track in tracks:
        states = {state.timestamp: state for state in track}
        for time, state in states.items():
            vector = np.ravel(getattr(state, "mean", state.state_vector)).astype(np.float64)
            times.append(time)
            ids.append(str(track.id))
            values.append(vector[chosen])
            covariance = getattr(state, "covar", None)
            if covariance is not None:
                covariances.append(np.asarray(covariance, np.float64)[np.ix_(position, position)])
    found = np.array(values, dtype=np.float64).reshape(len(values), len(chosen))
    is_date = any(hasattr(time, "year") for time in times)
    columns: dict[str, Any] = {
        "time": np.array(times, dtype="datetime64[us]" if is_date else None),
        "id": ids,
        "position": found[:, : len(position)],
    }
    if velocity is not None:
        columns["velocity"] = found[:, len(position) :]
    if covariances and len(covariances) == len(times):
        columns["covariance"] = np.stack(covariances)
    return columns
