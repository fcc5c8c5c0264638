"""Isolated values of the NIS that are far too large: bad measurements, reported before all else.

All rules about outliers are here, and :class:`OutlierResult` is what everything else reads:

1. *removed*: extreme under the robust scale of the rest, and alone, or followed by at most one
   smaller large value. Removed before the track is cut into segments.
2. *heavy-tailed*: values were removed, or some that remain are extreme; a cause is then not named.
3. *spike segments*: optimistic by their largest value alone; they count as consistent.
4. *reported*: the removed values and the spikes; without a change point, also all others that are
   extreme.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics.results import Outlier, Segment
from trackmetrics.diagnostics.thresholds import (
    MAX_OUTLIER_SHARE,
    MAX_RUN,
    MIN_ISOLATED_SHARE,
    MIN_P_WITHOUT_SPIKE,
    MIN_UPDATES_FOR_OUTLIERS,
    MIN_UPDATES_TO_JUDGE,
    RUN_GAP,
)
from trackmetrics.diagnostics.trace import Pair, Trace
from trackmetrics.logs.columns import Floats, Integers


@dataclass(frozen=True)
class OutlierResult:
    """The outliers of one trace; values are counted by their position in the trace."""

    removed: tuple[int, ...] = ()
    """The values that are left out of all other tests."""
    reported: tuple[Outlier, ...] = ()
    """The removed values; without a change point, also all others that are extreme."""
    is_heavy_tailed: bool = False
    """Whether values are extreme for the robust scale of the track."""
    spike_segments: tuple[int, ...] = ()
    """Segments that are too large by their largest value alone."""
    spikes: tuple[Outlier, ...] = ()
    """These values."""

    def all_reported(self) -> tuple[Outlier, ...]:
        """What is reported, spikes included, in the order of time."""
        if not self.spikes:
            return self.reported
        found = {outlier.index: outlier for outlier in (*self.reported, *self.spikes)}
        return tuple(found[index] for index in sorted(found))

    def without_spikes_in(self, segment: Segment) -> "OutlierResult":
        """The same without the spikes in this segment: it is too large, not they."""
        kept = (s for s in self.spikes if not segment.start <= s.index < segment.stop)
        return replace(self, spikes=tuple(kept))


NO_OUTLIERS = OutlierResult()


def find_outliers(traces: Sequence[Trace], alpha: float) -> list[OutlierResult]:
    """The values of each trace to remove, and whether its tails are heavy."""
    suspicious = _have_extreme_values(traces, alpha)
    return [
        _outliers_of(trace, alpha) if extreme else NO_OUTLIERS
        for trace, extreme in zip(traces, suspicious, strict=True)
    ]


def inliers(trace: Trace, outliers: OutlierResult) -> Integers:
    """The positions of the values that are not removed."""
    every = np.arange(len(trace.values))
    return np.setdiff1d(every, outliers.removed) if outliers.removed else every


def _have_extreme_values(traces: Sequence[Trace], alpha: float) -> list[bool]:
    """Whether any value is extreme under a scale of 1; the robust scale is never less."""
    if not traces:
        return []
    values = np.concatenate([t.values for t in traces])
    dof = np.concatenate([t.dof for t in traces])
    starts = np.cumsum([0, *(len(t.values) for t in traces)])
    # No smaller value is extreme, whatever its degrees of freedom: few remain to be tested.
    bound = _distributions.chi2_isf(alpha / MIN_UPDATES_TO_JUDGE, dof.min())
    large = np.flatnonzero(values > bound)
    of_trace = np.searchsorted(starts, large, side="right") - 1
    tails = _distributions.chi2_sf(values[large], dof[large])
    found = np.zeros(len(traces), bool)
    found[of_trace[tails < alpha / np.diff(starts)[of_trace]]] = True
    return [bool(f) for f in found]


def _outliers_of(trace: Trace, alpha: float) -> OutlierResult:
    """Removes outliers until the robust scale of the rest finds no more."""
    removed: Integers = np.empty(0, np.int64)
    rest: Integers = np.arange(len(trace.values))
    if len(rest) >= MIN_UPDATES_FOR_OUTLIERS:
        while True:
            scale = robust_scale(trace.values[rest], trace.dof[rest])
            found = _isolated(trace.values, trace.dof, scale, alpha)
            if len(found) <= len(removed):
                break
            removed, rest = found, np.setdiff1d(np.arange(len(trace.values)), found)
    tails = _p_values(trace, rest)[rest]
    is_heavy_tailed = len(removed) > 0 or bool(tails.min() < alpha / len(rest))
    return OutlierResult(tuple(removed.tolist()), is_heavy_tailed=is_heavy_tailed)


def _p_values(trace: Trace, rest: Integers) -> Floats:
    """The upper tail probability of every value under the robust scale of the inliers."""
    scale = robust_scale(trace.values[rest], trace.dof[rest])
    return np.asarray(_distributions.chi2_sf(trace.values / scale, trace.dof))


def robust_scale(values: Floats, dof: Floats) -> float:
    """The median of the values over the median of chi-square, at least 1."""
    kinds, which = np.unique(dof, return_inverse=True)
    return max(1.0, float(np.median(values / _distributions.chi2_quantile(0.5, kinds)[which])))


def _isolated(values: Floats, dof: Floats, scale: float, alpha: float) -> Integers:
    """Extreme values that stand alone, and a smaller one that follows.

    A bad measurement pulls the estimate away, so that one or two innovations after it may be large
    as well, but smaller; a fault grows.
    """
    n = len(values)
    tails = _distributions.chi2_sf(values / scale, dof)
    hits = np.flatnonzero(tails < alpha / n)
    if not 0 < len(hits) <= max(1.0, MAX_OUTLIER_SHARE * n):
        return hits[:0]
    runs = np.split(hits, np.flatnonzero(np.diff(hits) > RUN_GAP) + 1)
    alone = [
        run
        for run in runs
        if len(run) <= MAX_RUN and values[run].argmax() == 0 and run[0] >= 2 and run[-1] < n - 2
    ]
    count = sum(map(len, alone))
    is_isolated = alone and count >= MIN_ISOLATED_SHARE * len(hits)
    return np.concatenate(alone) if is_isolated else hits[:0]


def with_segments(
    found: OutlierResult,
    trace: Trace,
    edges: Sequence[int],
    segments: Sequence[Segment],
    alpha: float,
) -> OutlierResult:
    """The same once the segments of the inliers are known: spikes, and what is reported."""
    optimistic = [i for i, segment in enumerate(segments) if segment.label == "optimistic"]
    if not optimistic and not found.is_heavy_tailed:
        return found
    rest = inliers(trace, found)
    pair = trace.values[rest], trace.dof[rest]
    spikes = {i: k for i in optimistic if (k := _spike(pair, edges[i : i + 2])) >= 0}
    if not spikes and not found.is_heavy_tailed:
        return found
    positions = set(found.removed)
    p_values = _p_values(trace, rest)
    if found.is_heavy_tailed and len(segments) == 1 and len(rest) >= MIN_UPDATES_FOR_OUTLIERS:
        positions |= set(np.flatnonzero(p_values < alpha / len(rest)).tolist())
    at_spikes = [int(rest[k]) for k in spikes.values()]
    return replace(
        found,
        reported=tuple(_outlier(trace, k, float(p_values[k])) for k in sorted(positions)),
        spike_segments=tuple(spikes),
        spikes=tuple(_outlier(trace, k, float(p_values[k])) for k in at_spikes),
    )


def _spike(pair: Pair, edges: Sequence[int]) -> int:
    """The position of the value without which a segment is not too large; -1 if there is none."""
    start, stop = edges
    if stop - start < 2:
        return -1
    values, dof = pair[0][start:stop], pair[1][start:stop]
    largest = int(np.argmax(values / dof))
    total, m = np.add.reduceat(values, [0])[0], np.add.reduceat(dof, [0])[0]
    rest = _distributions.chi2_sf(total - values[largest], m - dof[largest])
    return start + largest if rest > MIN_P_WITHOUT_SPIKE else -1


def _outlier(trace: Trace, position: int, p_value: float) -> Outlier:
    return Outlier(
        index=int(trace.rows[position]),
        time=float(trace.times[position]),
        nis=float(trace.values[position]),
        dof=float(trace.dof[position]),
        p_value=p_value,
    )
