"""Accumulators filled from two frames of boxes or positions."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.compat.motmetrics.distances import iou_matrix, norm2squared_matrix
from trackmetrics.compat.motmetrics.mot import MOTAccumulator
from trackmetrics.compat.motmetrics.preprocess import preprocessResult

_BOX = ["X", "Y", "Width", "Height"]
Distance = Callable[[Any, Any], NDArray[np.float64]]


def compare_to_groundtruth(
    gt: Any,
    dt: Any,
    dist: str = "iou",
    distfields: Sequence[str] | None = None,
    distth: float = 0.5,
) -> MOTAccumulator:
    """Events of a tracker's output against truth.

    Parameters
    ----------
    gt, dt : DataFrame
        Truth and the tracker's output, indexed by FrameId and Id.
    dist : {"iou", "euc", "seuc"}
        One minus intersection over union, Euclidean distance, or its square.
    distfields : list of str, optional
        Columns of the boxes or positions; by default X, Y, Width, Height.
    distth : float
        Largest distance of a pair.

    Raises
    ------
    ValueError
        Where ``dist`` is none of these.
    """
    measures: dict[str, Distance] = {
        "IOU": lambda a, b: iou_matrix(a, b, max_iou=distth),
        "EUC": lambda a, b: np.sqrt(norm2squared_matrix(a, b, max_d2=distth**2)),
        "SEUC": lambda a, b: norm2squared_matrix(a, b, max_d2=distth),
    }
    if dist.upper() not in measures:
        raise ValueError(f"dist must be 'iou', 'euc' or 'seuc', got {dist!r}")
    return _accumulate(gt, dt, distfields or _BOX, measures[dist.upper()], "")


def CLEAR_MOT_M(
    gt: Any,
    dt: Any,
    inifile: Any,
    dist: str = "iou",
    distfields: Sequence[str] | None = None,
    distth: float = 0.5,
    include_all: bool = False,
    vflag: Any = "",
) -> tuple[MOTAccumulator, dict[str, dict[int, int]]]:
    """Events after MOTChallenge's preprocessing, and how often each id appears.

    Parameters
    ----------
    gt, dt, distfields, distth
        As in :func:`compare_to_groundtruth`.
    inifile : path
        The sequence's seqinfo.ini.
    dist : str
        ``"iou"``; anything else is the squared Euclidean distance.
    include_all : bool
        Whether truth of every class counts, or only class 1.
    vflag : file, optional
        Takes a line for each switch, transfer, miss and false alarm.
    """

    def measure(a: Any, b: Any) -> Any:
        if dist.upper() == "IOU":
            return iou_matrix(a, b, max_iou=distth)
        return norm2squared_matrix(a, b, max_d2=distth)

    dt = preprocessResult(dt, gt, inifile)
    counted = gt["Confidence"] >= 0.99
    gt = gt[counted if include_all else counted & (gt["ClassId"] == 1)]
    acc = _accumulate(gt, dt, distfields or _BOX, measure, vflag)
    return acc, {"hyp": _appearances(dt), "obj": _appearances(gt)}


def _appearances(frame: Any) -> dict[int, int]:
    ids, first, counts = np.unique(
        frame.index.get_level_values(1).to_numpy().astype(np.int64),
        return_index=True,
        return_counts=True,
    )
    order = np.argsort(first)
    return dict(zip(ids[order].tolist(), counts[order].tolist(), strict=True))


def _accumulate(
    gt: Any, dt: Any, fields: Sequence[str], measure: Distance, log: Any
) -> MOTAccumulator:
    """The events of all frames of either side, in order."""
    frames = np.array(sorted({*gt.index.get_level_values(0), *dt.index.get_level_values(0)}))
    acc = MOTAccumulator()
    truth, tracks = _by_frame(gt, fields, frames), _by_frame(dt, fields, frames)
    for frame, (ids, values), (others, other_values) in zip(
        frames.tolist(), truth, tracks, strict=True
    ):
        both = len(ids) and len(others)
        distances = measure(values, other_values) if both else np.empty((0, 0))
        acc.update(ids, others, distances, frameid=frame, vf=log)
    return acc


def _by_frame(frame: Any, fields: Sequence[str], frames: NDArray[Any]) -> list[tuple[Any, Any]]:
    """Ids and values of each frame, rows in their own order."""
    codes = np.searchsorted(frames, frame.index.get_level_values(0).to_numpy())
    order = np.argsort(codes, kind="stable")
    starts = np.searchsorted(codes[order], np.arange(len(frames) + 1))
    ids = frame.index.get_level_values(1).to_numpy()[order]
    values = frame[list(fields)].to_numpy()[order]
    return [(ids[a:b], values[a:b]) for a, b in pairwise(starts)]
