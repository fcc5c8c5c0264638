"""Similarity and distance of truth and tracks within a frame.

TrackEval asks for a similarity in [0, 1], py-motmetrics for a distance. `PairMeasure` gives both
from one name and one threshold, and lists the pairs that are similar at all: every score is made
from those.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _check, errors
from trackmetrics._similarity import EPS, box_iou, euclidean_distances
from trackmetrics.tracking.frames import TrackFrames

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PairMeasure:
    """What the pairs of a frame are compared by; made by :func:`pair_measure`."""

    frames: TrackFrames
    """The sequence."""
    kind: str
    """``"iou"``, ``"euclidean"`` or ``"matrices"``."""
    threshold: float
    """Least similarity of a pair or, for ``"euclidean"``, its largest distance."""
    columns: tuple[Any, Any]
    """Boxes or positions of truth and tracks; the matrices and None."""

    @property
    def similarity_threshold(self) -> float:
        """The threshold as a similarity: 0.5 for Euclidean distances."""
        return 0.5 if self.kind == "euclidean" else self.threshold

    @property
    def distance_threshold(self) -> float:
        """The threshold as a distance."""
        return self.threshold if self.kind == "euclidean" else 1 - self.threshold

    @cached_property
    def pairs(self) -> tuple[Codes, Codes, Floats, Floats]:
        """The pairs of a frame that are similar at all, in the order of the truth rows: where those
        of each truth row begin, their track rows, similarities and distances. Found once."""
        kernels, starts = (
            _backend.kernels,
            (self.frames.truth.coded()[1], self.frames.tracks.coded()[1]),
        )
        if self.kind == "euclidean":
            points = (_check.plain(side, np.float64) for side in self.columns)
            found = kernels.position_pairs(*points, *starts, self.threshold)
        elif self.kind == "iou":
            boxes = (_check.plain(side, np.float64) for side in self.columns)
            found = kernels.box_pairs(*boxes, *starts, self._allows_all)
        else:
            flat = [matrix.ravel() for matrix in self.columns[0]]
            matrices = _check.plain(np.concatenate(flat) if flat else np.empty(0), np.float64)
            found = kernels.matrix_pairs(matrices, *starts, self._allows_all)
        pairs: tuple[Codes, Codes, Floats, Floats] = found
        return pairs

    @property
    def _allows_all(self) -> bool:
        """Whether the threshold is lost in rounding, so that a similarity of 0 can reach it."""
        return self.threshold <= EPS

    def similarities(self, t: int, rows: slice, columns: slice) -> Floats:
        """Similarity of every pair of frame t, in [0, 1]; 0 for a pair that is excluded."""
        if self.kind == "euclidean":
            distances = self._distances(rows, columns)
            return np.maximum(0, 1 - distances / (2 * self.threshold))
        return np.nan_to_num(self._similarities(t, rows, columns))

    def distances(self, t: int, rows: slice, columns: slice) -> Floats:
        """Distance of every pair of frame t; NaN where it is above the threshold."""
        if self.kind == "euclidean":
            distances = self._distances(rows, columns)
        else:
            distances = 1 - self._similarities(t, rows, columns)
        return np.where(distances > self.distance_threshold, np.nan, distances)

    def _distances(self, rows: slice, columns: slice) -> Floats:
        return euclidean_distances(self.columns[0][rows], self.columns[1][columns])

    def _similarities(self, t: int, rows: slice, columns: slice) -> Floats:
        if self.kind == "iou":
            return box_iou(self.columns[0][rows], self.columns[1][columns])
        matrix: Floats = self.columns[0][t]
        return matrix


def pair_measure(
    frames: TrackFrames, similarity: str | Sequence[Any], threshold: float
) -> PairMeasure:
    """Check what a caller asked for.

    ``similarity`` is ``"iou"``, ``"euclidean"`` or a matrix for each frame (truth rows x track rows
    of the frame, in [0, 1]; NaN excludes the pair).
    """
    if not isinstance(frames, TrackFrames):
        raise TypeError(f"frames must be TrackFrames, got {type(frames).__name__}")
    threshold = _check.number("threshold", threshold)
    if isinstance(similarity, str) and similarity == "euclidean":
        if not 0 < threshold < np.inf:
            raise errors.parameter("threshold", "a finite distance above 0", threshold)
        return PairMeasure(frames, "euclidean", threshold, _centres(frames))
    if not 0 < threshold <= 1:
        raise errors.parameter("threshold", "above 0 and at most 1", threshold)
    if isinstance(similarity, str):
        if similarity != "iou":
            raise ValueError(
                f"similarity must be 'iou', 'euclidean' or a matrix for each frame, "
                f"got {similarity!r}"
            )
        return PairMeasure(frames, "iou", threshold, _boxes(frames))
    return PairMeasure(frames, "matrices", threshold, (_matrices(frames, similarity), None))


def _centres(frames: TrackFrames) -> tuple[Floats, Floats]:
    truth, tracks = frames.truth.centres("truth"), frames.tracks.centres("tracks")
    if len(truth) and len(tracks) and truth.shape[1] != tracks.shape[1]:
        raise errors.dimension("track_positions", [0], tracks.shape[1], truth.shape[1])
    return truth, tracks


def _boxes(frames: TrackFrames) -> tuple[Floats, Floats]:
    truth, tracks = frames.truth.boxes, frames.tracks.boxes
    if truth is None or tracks is None:
        side = "truth" if truth is None else "tracks"
        raise ValueError(f"{side} has no boxes, and similarity='iou' needs them")
    return truth, tracks


def _matrices(frames: TrackFrames, similarity: Sequence[Any]) -> list[Floats]:
    if len(similarity) != len(frames):
        raise errors.length("similarity", len(similarity), "frames", len(frames), "frames")
    sizes = zip(np.diff(frames.truth.starts), np.diff(frames.tracks.starts), strict=True)
    found = []
    for t, (matrix, (n, m)) in enumerate(zip(similarity, sizes, strict=True)):
        array = _check.floats(f"similarity[{t}]", matrix)
        if array.size != n * m or (array.size and array.shape != (n, m)):
            raise errors.shape(f"similarity[{t}]", array.shape, f"({n}, {m})")
        outside = np.argwhere((array < 0) | (array > 1))
        if len(outside):
            index = outside[0].tolist()
            value = float(array[tuple(index)])
            raise errors.element(f"similarity[{t}]", index, "between 0 and 1, or NaN", value)
        found.append(array.reshape(n, m))
    return found
