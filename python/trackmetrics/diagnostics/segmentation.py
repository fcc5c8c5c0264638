"""From a sequence of chi-square values to segments of one scale, each tested against scale 1.

One likelihood serves everything: c_k = s chi2(m_k), s > 1 optimistic and s < 1 pessimistic. All
sequences of a log go through each step together, so that special functions meet whole arrays:

1. outliers are removed (NIS only);
2. dynamic programming finds the best partitions, a simulated penalty selects the number of cuts;
3. every segment is tested (exact chi-square, Holm over the segments of a sequence);
4. the first and the last few values have tests of their own, and a CUSUM runs over all values.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from trackmetrics import _backend, _distributions
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.diagnostics.cusum import Alarm, first_alarms
from trackmetrics.diagnostics.end_tests import EndTests, end_tests
from trackmetrics.diagnostics.outliers import (
    NO_OUTLIERS,
    OutlierResult,
    find_outliers,
    inliers,
    with_segments,
)
from trackmetrics.diagnostics.penalty import select_num_changes
from trackmetrics.diagnostics.results import Segment
from trackmetrics.diagnostics.thresholds import (
    MAX_SEGMENTS,
    MIN_CORRELATION_TIME,
    MIN_SCALE_RATIO,
    MIN_SEGMENT_UPDATES,
    MIN_UPDATES_FOR_CORRELATION_TIME,
)
from trackmetrics.diagnostics.trace import Pair, Partitions, Trace
from trackmetrics.logs.columns import Floats, Integers


@dataclass(frozen=True, eq=False)
class SegmentedTrace:
    """A trace with its outliers, its segments and the tests of its ends."""

    trace: Trace
    inliers: Integers
    """Positions in the trace of the values that are not removed."""
    outliers: OutlierResult = NO_OUTLIERS
    edges: tuple[int, ...] = ()
    """Edges of the segments, counted in inliers."""
    segments: tuple[Segment, ...] = ()
    ends: EndTests = field(default_factory=EndTests)
    alarm: Alarm | None = None
    """The first alarm of a CUSUM, counted in all values of the trace."""

    @property
    def pair(self) -> Pair:
        """Values and degrees of freedom of the inliers."""
        if not self.outliers.removed:
            return self.trace.pair
        return self.trace.values[self.inliers], self.trace.dof[self.inliers]

    @property
    def lengths(self) -> list[int]:
        """How many inliers each segment has."""
        return [stop - start for start, stop in pairwise(self.edges)]

    @property
    def rows(self) -> Integers:
        """The updates of the inliers."""
        return self.trace.rows[self.inliers] if self.outliers.removed else self.trace.rows

    def settled(self) -> int | None:
        """The longest segment that is not optimistic, else the longest; the first of equals."""
        if len(self.segments) < 2:
            return 0 if self.segments else None
        every, lengths = range(len(self.segments)), self.lengths
        calm = [i for i in every if self.segments[i].label != "optimistic"] or every
        return max(calm, key=lengths.__getitem__)

    def settled_rows(self) -> Integers:
        """The updates of that segment without outliers; all without segments."""
        settled = self.settled()
        if settled is None:
            return self.rows
        return self.rows[self.edges[settled] : self.edges[settled + 1]]

    def sums(self) -> tuple[float, float]:
        """The sum of the inliers and of their degrees of freedom."""
        values, dof = self.pair
        return float(values.sum()), float(dof.sum())


def segment_traces(traces: Sequence[Trace], alpha: float) -> list[SegmentedTrace]:
    """Every trace with its segments; one that is insufficient has none."""
    enough = [t.is_sufficient for t in traces]
    found = iter(_segmented([t for t, e in zip(traces, enough, strict=True) if e], alpha))
    return [
        next(found) if e else SegmentedTrace(t, np.arange(len(t.values)))
        for t, e in zip(traces, enough, strict=True)
    ]


def _segmented(traces: Sequence[Trace], alpha: float) -> list[SegmentedTrace]:
    outliers = _outliers(traces, alpha)
    bare = [
        SegmentedTrace(t, inliers(t, o), outliers=o) for t, o in zip(traces, outliers, strict=True)
    ]
    pairs = [s.pair for s in bare]
    edges = _all_edges(traces, pairs, alpha)
    columns = zip(
        bare,
        edges,
        _tested(bare, edges, alpha),
        end_tests(pairs, alpha),
        first_alarms([t.pair for t in traces]),
        strict=True,
    )
    return [_complete(*column, alpha) for column in columns]


def _outliers(traces: Sequence[Trace], alpha: float) -> list[OutlierResult]:
    found = iter(find_outliers([t for t in traces if t.is_nis], alpha))
    return [next(found) if t.is_nis else NO_OUTLIERS for t in traces]


def _complete(
    bare: SegmentedTrace,
    edges: list[int],
    segments: tuple[Segment, ...],
    ends: EndTests,
    alarm: Alarm | None,
    alpha: float,
) -> SegmentedTrace:
    trace, outliers = bare.trace, bare.outliers
    if trace.is_nis:
        outliers = with_segments(outliers, trace, edges, segments, alpha)
        for i in outliers.spike_segments:
            calm = _with_spike(segments[i])
            segments = (*segments[:i], calm, *segments[i + 1 :])
    return SegmentedTrace(trace, bare.inliers, outliers, tuple(edges), segments, ends, alarm)


def _all_edges(traces: Sequence[Trace], pairs: Sequence[Pair], alpha: float) -> list[list[int]]:
    """The edges of the segments of each trace; known partitions are not searched again.

    The penalty of NIS is raised by the correlation time of the normal scores within the longest
    segment found first, where that is material.
    """
    unknown = [p for t, p in zip(traces, pairs, strict=True) if t.partitions is None]
    new = iter(best_partitions(unknown))
    best = [trace.partitions or next(new) for trace in traces]
    edges = select_edges(pairs, best, alpha)
    cut = [i for i, t in enumerate(traces) if t.is_nis and _may_be_correlated(edges[i])]
    # Of the longest segment: how a fault correlates later values is no property of the data.
    longest = [_longest(pairs[i], edges[i]) for i in cut]
    times = correlation_times(z_scores_within_segments(longest, [[0, len(v)] for v, _ in longest]))
    for i, time in zip(cut, times, strict=True):
        if time > MIN_CORRELATION_TIME:
            edges[i] = _selected(pairs[i], best[i], alpha, float(time))
    return edges


def _may_be_correlated(edges: Sequence[int]) -> bool:
    return len(edges) > 2 and edges[-1] >= MIN_UPDATES_FOR_CORRELATION_TIME


def _longest(pair: Pair, edges: Sequence[int]) -> Pair:
    a, b = max(pairwise(edges), key=lambda edge: edge[1] - edge[0])
    return pair[0][a:b], pair[1][a:b]


def best_partitions(pairs: Sequence[Pair]) -> list[Partitions]:
    """The best partitions of every sequence into 1 to 4 segments, all in one call."""
    if not pairs:
        return []
    starts = np.concatenate([[0], np.cumsum([len(values) for values, _ in pairs])])
    values, dof = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    gains, cuts = _backend.kernels.scale_partitions(
        values, dof, starts.astype(np.int64), MIN_SEGMENT_UPDATES, MAX_SEGMENTS
    )
    return [Partitions(g, c) for g, c in zip(gains, cuts, strict=True)]


def select_edges(
    pairs: Sequence[Pair], best: Sequence[Partitions], alpha: float
) -> list[list[int]]:
    """The edges of the segments of each sequence, their number selected by the penalty."""
    return [_selected(pair, found, alpha) for pair, found in zip(pairs, best, strict=True)]


def _selected(pair: Pair, best: Partitions, alpha: float, factor: float = 1.0) -> list[int]:
    """Those of one sequence, each change point of which costs its penalty times ``factor``."""
    n = len(pair[0])
    count = 0
    if n >= 2 * MIN_SEGMENT_UPDATES:
        count = select_num_changes(best.gains, pair[1], MIN_SEGMENT_UPDATES, alpha, factor)
    return best.edges(count, n)


def z_scores_within_segments(pairs: Sequence[Pair], edges: Sequence[Sequence[int]]) -> list[Floats]:
    """Nearly normal scores of the values of each sequence under the scales of their segments."""
    return [_z_scores(v, d, places) for (v, d), places in zip(pairs, edges, strict=True)]


def _z_scores(values: Floats, dof: Floats, edges: Sequence[int]) -> Floats:
    sums, dofs = (np.add.reduceat(column, edges[:-1]) for column in (values, dof))
    scales = np.maximum(sums / dofs, 1e-300)
    spread = scales[0] if len(scales) == 1 else np.repeat(scales, np.diff(edges))
    return _distributions.wilson_hilferty_z(values / (dof * spread), dof)


def _tested(
    traces: Sequence[SegmentedTrace], edges: Sequence[Sequence[int]], alpha: float
) -> list[tuple[Segment, ...]]:
    """The segments with their scales, intervals and corrected p-values."""
    sums, dofs = [], []
    for trace, places in zip(traces, edges, strict=True):
        values, dof = trace.pair
        sums += np.add.reduceat(values, places[:-1]).tolist()
        dofs += np.add.reduceat(dof, places[:-1]).tolist()
    p, low, high = _scale_tests(np.array(sums), np.array(dofs))
    found, at = [], 0
    for trace, places in zip(traces, edges, strict=True):
        part = slice(at, at := at + len(places) - 1)
        corrected = p[part] if len(places) == 2 else _distributions.holm(p[part])
        intervals = zip(low[part].tolist(), high[part].tolist(), strict=True)
        rows = zip(
            pairwise(places), sums[part], dofs[part], intervals, corrected.tolist(), strict=True
        )
        found.append(tuple(_segment(trace, *row, alpha) for row in rows))
    return found


def _scale_tests(sums: Floats, dofs: Floats) -> tuple[Floats, Floats, Floats]:
    """Two-sided p-values of "the scale is 1", and the 95 % intervals of the scales."""
    p: Floats = _distributions.chi2_p_value(sums, dofs)
    low: Floats = sums / _distributions.chi2_quantile(0.975, dofs)
    high: Floats = sums / _distributions.chi2_quantile(0.025, dofs)
    return p, low, high


def _segment(
    trace: SegmentedTrace,
    edge: tuple[int, int],
    total: float,
    dof: float,
    interval: tuple[float, float],
    p_value: float,
    alpha: float,
) -> Segment:
    first, last = int(trace.inliers[edge[0]]), int(trace.inliers[edge[1] - 1])
    rows, times, scale = trace.trace.rows, trace.trace.times, total / dof
    return Segment(
        int(rows[first]),
        int(rows[last]) + 1,
        float(times[first]),
        float(times[last]),
        dof,
        scale,
        interval,
        p_value,
        _label(scale, p_value, alpha),
    )


def _label(scale: float, p_value: float, alpha: float) -> str:
    if p_value < alpha and scale > MIN_SCALE_RATIO:
        return "optimistic"
    if p_value < alpha and scale < 1 / MIN_SCALE_RATIO:
        return "pessimistic"
    return "consistent"


def _with_spike(segment: Segment) -> Segment:
    return replace(segment, label="consistent", has_spike=True)


def cut_end(segmented: SegmentedTrace, at_start: bool, alpha: float) -> SegmentedTrace:
    """The same with the beginning, or the end, that its own test found as a segment.

    Segments that it covers are gone; one that it covers in part is tested again without it, with a
    p-value corrected (Bonferroni) for the number of segments.
    """
    ends, n = segmented.ends, segmented.edges[-1]
    cut = ends.start_length if at_start else n - ends.end_length
    p_end = ends.start_p if at_start else ends.end_p
    outside = [e for e in segmented.edges if (e > cut if at_start else e < cut)]
    edges = [0, cut, *outside] if at_start else [*outside, cut, n]
    index = 0 if at_start else len(edges) - 2
    known = dict(zip(pairwise(segmented.edges), segmented.segments, strict=True))
    segments = []
    for i, edge in enumerate(pairwise(edges)):
        kept = None if i == index else known.get(edge)
        segments.append(kept or _segment_of(segmented, edge, len(edges) - 1, alpha))
        # The rest of a segment was not too large with the end: it can only be so by a spike.
        if i != index and segments[-1].label == "optimistic" and segmented.outliers.spike_segments:
            segments[-1] = _with_spike(segments[-1])
    segments[index] = replace(segments[index], p_value=p_end, label="optimistic", has_spike=False)
    outliers = segmented.outliers.without_spikes_in(segments[index])
    return replace(segmented, edges=tuple(edges), segments=tuple(segments), outliers=outliers)


def _segment_of(
    segmented: SegmentedTrace, edge: tuple[int, int], count: int, alpha: float
) -> Segment:
    values, dof = (column[edge[0] : edge[1]].sum(keepdims=True) for column in segmented.pair)
    p, low, high = _scale_tests(values, dof)
    interval = float(low[0]), float(high[0])
    corrected = min(1.0, count * float(p[0]))
    return _segment(segmented, edge, float(values[0]), float(dof[0]), interval, corrected, alpha)
