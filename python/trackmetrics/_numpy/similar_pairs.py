"""Similar rows of truth and tracks: reference implementation of ``similar_pairs`` in the core."""

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, plain, plain_ids, plain_numbers
from trackmetrics._similarity import box_iou, euclidean_distances

Codes = NDArray[np.int64]
SideColumns = tuple[Codes, Codes, int]
"""Codes, offsets of frames and the number of ids."""
PairColumns = tuple[Codes, Codes, Floats, Floats]
"""Offsets of truth rows, track rows, similarities and distances."""


def box_pairs(
    truth: Floats, tracks: Floats, truth_starts: Codes, track_starts: Codes, keep_all: bool
) -> PairColumns:
    """Pairs of boxes that share an area."""
    plain(truth, tracks)
    plain_ids(truth_starts, track_starts)
    for argument, boxes in (("truth", truth), ("tracks", tracks)):
        if boxes.shape[1] != 4:
            raise errors.shape(argument, boxes.shape, f"({len(boxes)}, 4)")
    check_frames(truth_starts, track_starts, len(truth), len(tracks))

    def frame(t: int, rows: slice, columns: slice) -> tuple[Floats, Floats]:
        similarity = box_iou(truth[rows], tracks[columns])
        return similarity, 1 - similarity

    return _collect(truth_starts, track_starts, frame, keep_all)


def position_pairs(
    truth: Floats, tracks: Floats, truth_starts: Codes, track_starts: Codes, threshold: float
) -> PairColumns:
    """Pairs of positions nearer than twice the threshold."""
    plain(truth, tracks)
    plain_ids(truth_starts, track_starts)
    plain_numbers(threshold)
    if len(truth) and len(tracks) and truth.shape[1] != tracks.shape[1]:
        raise errors.dimension("tracks", [0], tracks.shape[1], truth.shape[1])
    check_frames(truth_starts, track_starts, len(truth), len(tracks))

    def frame(t: int, rows: slice, columns: slice) -> tuple[Floats, Floats]:
        distances = euclidean_distances(truth[rows], tracks[columns])
        return np.maximum(0, 1 - distances / (2 * threshold)), distances

    return _collect(truth_starts, track_starts, frame, keep_all=False)


def matrix_pairs(
    matrices: Floats, truth_starts: Codes, track_starts: Codes, keep_all: bool
) -> PairColumns:
    """Pairs of the similarity matrices of all frames; NaN excludes a pair."""
    plain(matrices)
    plain_ids(truth_starts, track_starts)
    last = (int(starts[-1]) if len(starts) else 0 for starts in (truth_starts, track_starts))
    check_frames(truth_starts, track_starts, *last)
    ends = np.cumsum(np.diff(truth_starts) * np.diff(track_starts))
    expected = int(ends[-1]) if len(ends) else 0
    if len(matrices) != expected:
        raise errors.length("matrices", len(matrices), "frames", expected, "elements")

    def frame(t: int, rows: slice, columns: slice) -> tuple[Floats, Floats]:
        shape = rows.stop - rows.start, columns.stop - columns.start
        similarity = matrices[ends[t] - shape[0] * shape[1] : ends[t]].reshape(shape)
        excluded = np.isnan(similarity)
        similarity = np.where(excluded, 0, similarity)
        return similarity, np.where(excluded, np.inf, 1 - similarity)

    return _collect(truth_starts, track_starts, frame, keep_all)


def check_frames(truth_starts: Codes, track_starts: Codes, truth: int, tracks: int) -> None:
    """Refuse offsets that do not rise from 0 to the number of rows, or differ in length."""
    for name, starts, rows in (("truth", truth_starts, truth), ("tracks", track_starts, tracks)):
        ends = len(starts) and starts[0] == 0 and starts[-1] == rows
        if not (ends and (np.diff(starts) >= 0).all()):
            raise errors.offsets(name, rows)
    found, expected = len(track_starts) - 1, len(truth_starts) - 1
    if found != expected:
        raise errors.length("tracks", found, "truth", expected, "frames")


def frame_slices(truth_starts: Codes, track_starts: Codes) -> Iterator[tuple[int, slice, slice]]:
    """Index of each frame with a row on both sides, its truth rows and its track rows."""
    truth, tracks = pairwise(truth_starts.tolist()), pairwise(track_starts.tolist())
    for t, (rows, columns) in enumerate(zip(truth, tracks, strict=True)):
        if rows[0] < rows[1] and columns[0] < columns[1]:
            yield t, slice(*rows), slice(*columns)


def _collect(
    truth_starts: Codes,
    track_starts: Codes,
    frame: Callable[[int, slice, slice], tuple[Floats, Floats]],
    keep_all: bool,
) -> PairColumns:
    counts = np.zeros(int(truth_starts[-1]), dtype=np.int64)
    found: list[tuple[Codes, Floats, Floats]] = []
    for t, rows, columns in frame_slices(truth_starts, track_starts):
        similarity, distance = frame(t, rows, columns)
        kept = np.full(similarity.shape, True) if keep_all else similarity > 0
        counts[rows] = kept.sum(axis=1)
        found.append((np.nonzero(kept)[1] + columns.start, similarity[kept], distance[kept]))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    if not found:
        return starts, np.empty(0, dtype=np.int64), np.empty(0), np.empty(0)
    columns_, similarities, distances = (np.concatenate(part) for part in zip(*found, strict=True))
    return starts, columns_, similarities, distances


class PairMatrices:
    """The matrices of the frames, from the listed pairs."""

    def __init__(self, truth: SideColumns, tracks: SideColumns, pairs: PairColumns) -> None:
        plain_ids(*truth[:2], *tracks[:2], *pairs[:2])
        plain(*pairs[2:])
        check_frames(truth[1], tracks[1], len(truth[0]), len(tracks[0]))
        for argument, side in (("truth", truth), ("tracks", tracks)):
            _check_codes(argument, *side)
        self.truth, self.tracks = truth, tracks
        self.starts, self.columns, self.similarities, self.distances = pairs
        self._check_pairs()

    def frames(self) -> Iterator[tuple[int, slice, slice]]:
        """Index, truth rows and track rows of each frame with both."""
        return frame_slices(self.truth[1], self.tracks[1])

    def similarity(self, rows: slice, columns: slice) -> Floats:
        """Similarity of every pair of a frame; 0 for one that is not listed."""
        return self._fill(rows, columns, self.similarities, 0.0)

    def distance(self, rows: slice, columns: slice, largest: float) -> Floats:
        """Distance of every pair of a frame; NaN where it is too large or not listed."""
        distances = self._fill(rows, columns, self.distances, np.inf)
        return np.where(distances > largest, np.nan, distances)

    def _fill(self, rows: slice, columns: slice, values: Floats, empty: float) -> Floats:
        matrix = np.full((rows.stop - rows.start, columns.stop - columns.start), empty)
        starts = self.starts[rows.start : rows.stop + 1]
        i = np.repeat(np.arange(len(matrix)), np.diff(starts))
        places = slice(int(starts[0]), int(starts[-1]))
        matrix[i, self.columns[places] - columns.start] = values[places]
        return matrix

    def _check_pairs(self) -> None:
        count, rows = len(self.columns), len(self.truth[0])
        starts = self.starts
        ends = len(starts) and starts[0] == 0 and starts[-1] == count
        if not (ends and (np.diff(starts) >= 0).all()):
            raise errors.offsets("pairs", count)
        if len(starts) != rows + 1:
            raise errors.length("starts", len(starts) - 1, "truth", rows, "rows")
        for argument, values in (
            ("similarities", self.similarities),
            ("distances", self.distances),
        ):
            if len(values) != count:
                raise errors.length(argument, len(values), "columns", count, "pairs")
        row = np.repeat(np.arange(rows), np.diff(starts))
        frame = np.searchsorted(self.truth[1], row, side="right") - 1
        low, high = self.tracks[1][frame], self.tracks[1][frame + 1]
        wrong = (self.columns < low) | (self.columns >= high)
        wrong[1:] |= (row[1:] == row[:-1]) & (self.columns[1:] <= self.columns[:-1])
        if wrong.any():
            place = int(np.flatnonzero(wrong)[0])
            requirement = "a track row of the frame, in rising order"
            raise errors.element("columns", [place], requirement, float(self.columns[place]))


def _check_codes(argument: str, ids: Codes, starts: Codes, names: int) -> None:
    wrong = np.flatnonzero((ids < 0) | (ids >= names))
    if len(wrong):
        value = float(ids[wrong[0]])
        requirement = "at least 0 and below the number of ids"
        raise errors.element(argument, [int(wrong[0])], requirement, value)
