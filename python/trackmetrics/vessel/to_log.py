"""The log of an estimator from the output of the filter."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import OBSERVED, REPORT_TYPES, STATES, Floats

Integers = NDArray[np.int64]

_COLUMNS = ("x_pred", "P_pred", "innovation", "S", "R", "nis", "x", "P", "A")


class Outcome(IntEnum):
    """What became of a report; the numbers are those of the kernel."""

    LATE = 0
    """Not used: earlier than the last report of its track."""
    STARTED = 1
    """Started a track."""
    TENTATIVE = 2
    """Used by a track that is tentative: no NIS."""
    FUSED = 3
    """Used by a track, with its NIS."""


@dataclass(frozen=True)
class FilterBatch:
    """Reports that went through the filters in one call, and what became of them."""

    tracks: Integers
    """The track of each."""
    sources: Integers
    """Which report it was, counted from the first ever added."""
    reports: Reports
    """The reports."""
    truths: Floats
    """The true states, NaN where unknown."""
    rows: Any
    """Outcome, start and the columns of the log, as the kernel gave them; None for late ones."""

    @classmethod
    def late(cls, reports: Reports, sources: Integers) -> "FilterBatch":
        """Reports that came too late to be used."""
        return cls(np.full(len(reports), -1, np.int64), sources, reports, np.empty((0, 5)), None)

    @property
    def outcome(self) -> Integers:
        """What became of each report, as :class:`Outcome`."""
        if self.rows is None:
            return np.zeros(len(self.reports), np.int64)
        return np.asarray(self.rows[0], np.int64)

    def births(self) -> Iterator[tuple[int, int]]:
        """(track, start) of every track that started here, in the order of time."""
        started = np.flatnonzero(self.outcome == Outcome.STARTED)
        for i in started[np.argsort(self.reports.time[started], kind="stable")]:
            yield int(self.tracks[i]), int(self.rows[1][i])


Names = dict[tuple[int, int], str]


def write_log(parts: Sequence[tuple[Sequence[FilterBatch], Names]]) -> EstimatorLog:
    """One log of the blocks of one or more trackers, each with the names of its tracks."""
    used: list[tuple[FilterBatch, Integers]] = []
    names: Names = {}
    for blocks, own in parts:
        first = 1 + max((track for track, _ in names), default=-1)
        names |= {(track + first, start): name for (track, start), name in own.items()}
        used += [(b, b.tracks + first) for b in blocks if (b.outcome != Outcome.LATE).any()]
    if not used:
        raise ValueError("the log is empty: no report was used")
    return _columns([block for block, _ in used], _join([tracks for _, tracks in used]), names)


def _columns(used: Sequence[FilterBatch], tracks: Integers, names: Names) -> EstimatorLog:
    outcome = _join([block.outcome for block in used])
    reports = Reports.concatenate([block.reports for block in used])
    starts = _join([block.rows[1] for block in used])
    keep = np.flatnonzero(outcome != Outcome.LATE)
    order = keep[np.lexsort((reports.time[keep], starts[keep], tracks[keep]))]
    key = np.stack([tracks[order], starts[order]], axis=1)
    columns = {
        name: _join([block.rows[2 + k] for block in used])[order] for k, name in enumerate(_COLUMNS)
    }
    truth = _join([block.truths for block in used])[order]
    reports, fused = reports.take(order), outcome[order] == Outcome.FUSED
    return EstimatorLog.from_columns(
        states=STATES,
        track=[names[a, b] for a, b in key.tolist()],
        time=_separate_equal_times(reports.time, key),
        status=np.where(fused, "active", "tentative"),
        measurement_type=np.array(REPORT_TYPES, object)[reports.kind],
        observed=np.where(np.arange(4) < OBSERVED[reports.kind][:, None], np.arange(4), -1),
        z=reports.z,
        nis_dof=np.where(fused, OBSERVED[reports.kind], np.nan),
        truth=truth if np.isfinite(truth).any() else None,
        **columns,
    )


def _join(parts: Sequence[Any]) -> Any:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _separate_equal_times(times: Floats, key: Integers) -> Floats:
    """Times that rise strictly within a track: equal ones one unit in the last place apart."""
    times = times.copy()
    same = (np.diff(times) == 0) & (np.diff(key, axis=0) == 0).all(1)
    for k in np.flatnonzero(same) + 1:
        times[k] = np.nextafter(max(times[k], times[k - 1]), np.inf)
    return times
