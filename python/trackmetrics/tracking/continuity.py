"""Continuity of the association of targets: the track changes and the longest segment of SIAP."""

import numpy as np
from numpy.typing import NDArray

from trackmetrics.tracking.associations import Associations, clock
from trackmetrics.tracking.frames import TrackFrames

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]
Sums = tuple[float, float]


def track_changes_and_longest(
    frames: TrackFrames, pairs: Associations, as_stonesoup: bool
) -> tuple[Sums, Sums]:
    """Numerators and denominators of the rate of track number change and of the longest segment."""
    frame = np.repeat(np.arange(len(frames)), np.diff(frames.truth.starts))
    order = np.lexsort((frame, frames.truth.ids))
    own_times = np.split(
        clock(frames)[frame[order]], np.flatnonzero(np.diff(frames.truth.ids[order])) + 1
    )
    changes, tracked, longest, lifetime = 0, 0.0, 0.0, 0.0
    for code, times in enumerate(own_times if len(frame) else []):
        lifetime += float(times[-1] - times[0])
        own = pairs.truth == code
        if not own.any():
            continue
        limits, track = pairs.limits[own], pairs.track[own]
        needed = _stonesoup_number(times, limits, track) if as_stonesoup else _least(times, limits)
        changes += max(needed - 1, 0)
        tracked += _covered(times, limits)
        durations = np.bincount(track, limits[:, 1] - limits[:, 0])
        longest += float(durations.max() if as_stonesoup else np.diff(limits, axis=1).max())
    return (changes, tracked), (longest, lifetime)


def _covered(times: Floats, limits: Floats) -> float:
    """Length of the union of the intervals within the lifetime of the target."""
    clipped = np.clip(limits, times[0], times[-1])
    clipped = clipped[np.argsort(clipped[:, 0])]
    reached = np.maximum.accumulate(clipped[:, 1])
    start = np.maximum(clipped[:, 0], np.append(clipped[0, 0], reached[:-1]))
    return float(np.maximum(clipped[:, 1] - start, 0).sum())


def _least(times: Floats, limits: Floats) -> int:
    """Least number of associations that cover the times of the target at which it has one."""
    count, k = 0, 0
    while k < len(times):
        here = (limits[:, 0] <= times[k]) & (times[k] <= limits[:, 1])
        if here.any():
            count += 1
            k = int(np.searchsorted(times, limits[here, 1].max(), side="right"))
        else:
            k += 1
    return count


def _stonesoup_number(times: Floats, limits: Floats, track: Codes) -> int:
    """The number of associations that Stone Soup counts.

    Tracks go by the end of their last association. The count stops where an association ends at
    the time that is looked at, or at a time at which the target has no row.
    """
    last = np.full(track.max() + 1, -np.inf)
    np.maximum.at(last, track, limits[:, 1])
    order = np.argsort(-last[track], kind="stable")
    count, k = 0, 0
    while k < len(times):
        here = np.flatnonzero((limits[order, 0] <= times[k]) & (times[k] <= limits[order, 1]))
        if not len(here):
            k += 1
            continue
        count += 1
        end = limits[order[here[0]], 1]
        after = k + 1 + int(np.searchsorted(times[k + 1 :], end))
        if after >= len(times) or times[after] != end:
            break
        k = after + 1
    return count
