"""The rows that the benchmarks score: MOTChallenge's and KITTI tracking's own preprocessing.

The steps are those of TrackEval 1.3.0 (``mot_challenge_2d_box.py`` and ``kitti_2d_box.py``): truth
and tracks are matched in each frame by the largest total IoU of pairs of at least 0.5; tracks that
are matched with truth that does not count go, then that truth goes.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._similarity import EPS, box_iou
from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.tracking.frames import TrackFrames
from trackmetrics.tracks import TrackTable

_LEAST_IOU = 0.5
_PEDESTRIAN = 1
_DISTRACTORS = (2, 7, 8, 12)
"""Person on vehicle, static person, distractor, reflection."""
_NON_MOT_VEHICLE = 6
_BENCHMARKS = ("MOT15", "MOT16", "MOT17", "MOT20")
_NEIGHBOURS = {"car": "van", "pedestrian": "person"}
_LEAST_HEIGHT = 25.0
Mask = NDArray[np.bool_]


def preprocess_mot_challenge(
    truth: TrackTable, tracks: TrackTable, *, benchmark: str = "MOT17"
) -> tuple[TrackTable, TrackTable]:
    """The rows that MOTChallenge scores.

    Tracks that are matched with a distractor (person on vehicle, static person, distractor,
    reflection; in MOT20 also a vehicle) are left out, then all truth that is no pedestrian or has
    the confidence flag 0. In MOT15, which has no classes, only the flag counts.

    Parameters
    ----------
    truth, tracks : TrackTable
        As :func:`trackmetrics.tracks.read_tracks` reads them, truth with ``cls`` and ``score``.
    benchmark : {"MOT15", "MOT16", "MOT17", "MOT20"}
        Whose rules.

    Returns
    -------
    truth, tracks : TrackTable
        The rows that count.

    Raises
    ------
    ValueError
        Where a table lacks boxes, truth lacks flags or classes, or a track is no pedestrian.
    """
    if benchmark not in _BENCHMARKS:
        listed = ", ".join(_BENCHMARKS)
        raise ValueError(f"benchmark must be one of {listed}, got {benchmark!r}")
    _need(truth, "truth", "box", "score")
    _need(tracks, "tracks", "box")
    counts = np.asarray(truth.score) != 0
    if benchmark == "MOT15":
        return truth.rows(counts), tracks
    _need(truth, "truth", "cls")
    if tracks.cls is not None and (tracks.cls > _PEDESTRIAN).any():
        row = int(np.argmax(tracks.cls > _PEDESTRIAN))
        raise ValueError(f"tracks row {row} has class {tracks.cls[row]}, expected 1 (pedestrian)")
    distractors = (*_DISTRACTORS, *((_NON_MOT_VEHICLE,) if benchmark == "MOT20" else ()))
    rows, columns = _match(truth, tracks)
    keep = np.ones(len(tracks), dtype=np.bool_)
    keep[columns[np.isin(truth.cls[rows], distractors)]] = False  # type: ignore[index]
    return truth.rows(counts & (truth.cls == _PEDESTRIAN)), tracks.rows(keep)


def preprocess_kitti(
    truth: TrackTable, tracks: TrackTable, *, cls: str = "car"
) -> tuple[TrackTable, TrackTable]:
    """The rows that KITTI tracking scores for one class.

    Tracks that are matched with truth of the neighbouring class (van, sitting person), truncated
    or occluded truth are left out; so are tracks without a match that are at most 25 pixels high,
    or of which more than half lies in a DontCare region. Then that truth is left out.

    Parameters
    ----------
    truth, tracks : TrackTable
        As :func:`trackmetrics.tracks.read_tracks` reads KITTI labels.
    cls : {"car", "pedestrian"}
        The class that is scored.

    Returns
    -------
    truth, tracks : TrackTable
        The rows that count.

    Raises
    ------
    ValueError
        Where a table lacks boxes or classes, or truth lacks ``truncated`` or ``occluded``.
    """
    wanted = cls.lower()
    if wanted not in _NEIGHBOURS:
        raise ValueError(f"cls must be 'car' or 'pedestrian', got {cls!r}")
    _need(truth, "truth", "box", "cls")
    _need(tracks, "tracks", "box", "cls")
    kinds = _lower(truth)
    regions = truth.rows(kinds == "dontcare")
    truth = truth.rows(np.isin(kinds, (wanted, _NEIGHBOURS[wanted])) & (truth.id >= 0))
    tracks = tracks.rows((_lower(tracks) == wanted) & (tracks.id >= 0))
    other = truth.other or {}
    for name in ("truncated", "occluded"):
        if name not in other:
            raise ValueError(f"truth has no column {name}")
    counts = (other["truncated"] <= 0) & (other["occluded"] <= 2) & (_lower(truth) == wanted)
    rows, columns = _match(truth, tracks)
    keep = np.ones(len(tracks), dtype=np.bool_)
    boxes = np.asarray(tracks.box)
    unmatched = np.ones(len(tracks), dtype=np.bool_)
    unmatched[columns] = False
    low = boxes[:, 3] <= _LEAST_HEIGHT + EPS
    keep[unmatched & (low | _in_region(tracks, regions))] = False
    keep[columns[~counts[rows]]] = False
    return truth.rows(counts), tracks.rows(keep)


def _need(table: TrackTable, argument: str, *names: str) -> None:
    for name in names:
        if getattr(table, name) is None:
            raise ValueError(f"{argument} has no column {name}, which the preprocessing needs")


def _lower(table: TrackTable) -> NDArray[Any]:
    return np.char.lower(np.asarray(table.cls).astype(str))


def _match(truth: TrackTable, tracks: TrackTable) -> tuple[Any, Any]:
    """Rows of truth and of tracks that are matched, in the order of the tables."""
    rows: list[Any] = [np.empty(0, dtype=np.int64)]
    columns: list[Any] = [np.empty(0, dtype=np.int64)]
    for own, other in _shared_frames(truth, tracks):
        iou = box_iou(truth.box[own], tracks.box[other])  # type: ignore[index]
        iou[iou < _LEAST_IOU - EPS] = 0
        i, j = linear_sum_assignment(iou, maximize=True)
        found = iou[i, j] > EPS
        rows.append(own[i[found]])
        columns.append(other[j[found]])
    return np.concatenate(rows), np.concatenate(columns)


def _shared_frames(truth: TrackTable, tracks: TrackTable) -> Any:
    """For each frame with rows on both sides, these rows."""
    frames = TrackFrames.from_tables(truth, tracks)
    first = np.argsort(truth.time, kind="stable")
    second = np.argsort(tracks.time, kind="stable")
    for _, own, other in frames.slices():
        yield first[own], second[other]


def _in_region(tracks: TrackTable, regions: TrackTable) -> Mask:
    """Which boxes lie in a region with more than half of their area."""
    inside = np.zeros(len(tracks), dtype=np.bool_)
    for own, other in _shared_frames(regions, tracks):
        region, box = np.asarray(regions.box)[own], np.asarray(tracks.box)[other]
        low = np.maximum(box[:, None, :2], region[None, :, :2])
        ends = box[:, :2] + box[:, 2:], region[:, :2] + region[:, 2:]
        high = np.minimum(ends[0][:, None], ends[1][None])
        shared = np.prod(np.maximum(high - low, 0), axis=2)
        area = np.prod(box[:, 2:], axis=1)[:, None]
        share = np.divide(shared, area, out=np.zeros_like(shared), where=area > EPS)
        inside[other] = (share > _LEAST_IOU + EPS).any(axis=1)
    return inside
