"""From a sequence of chi-square values to stretches of one scale, each high, low or consistent.

One likelihood serves everything: c_k = s chi2(m_k), s > 1 optimistic and s < 1 pessimistic. All
sequences of a log are judged together, stage by stage, so that special functions meet whole arrays.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from trackmetrics import _backend, _distributions
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.diagnostics.live import first_alarms
from trackmetrics.diagnostics.outliers import set_aside
from trackmetrics.diagnostics.penalty import deserved
from trackmetrics.diagnostics.trace import (
    LEAST_SEGMENT,
    MATERIAL,
    MOST_SEGMENTS,
    Candidates,
    Stretch,
    Trace,
)
from trackmetrics.logs.columns import Floats, Integers

Pair = tuple[Floats, Floats]
"""Values and their degrees of freedom."""
CORRELATED = 1.3
"""Correlation time above which cuts cost more."""
LEAST_CORRELATED = 20
"""Updates from which on a correlation time can be told."""


def cut(traces: Sequence[Trace], level: float) -> None:
    """Sets outliers aside, cuts every one where its scale changes, and tests the pieces."""
    enough = [s for s in traces if s.sufficient]
    for trace in enough:
        trace.kept = np.arange(len(trace.values))
    set_aside([s for s in enough if s.spikes], level)
    pairs = [s.kept_values() for s in enough]
    edges = _all_edges(enough, pairs, level)
    for trace, stretches in zip(enough, _tested(pairs, edges, level), strict=True):
        trace.stretches = stretches
    _drop_spikes([s for s in enough if s.spikes])
    _test_ends(enough, pairs, level)
    for trace, alarm in zip(enough, first_alarms([(t.values, t.dof) for t in enough]), strict=True):
        trace.alarm = alarm


def _all_edges(traces: Sequence[Trace], pairs: Sequence[Pair], level: float) -> list[list[int]]:
    """Where each trace is cut; those that come with candidates are not searched again.

    The penalty of NIS is raised by the correlation time of the normal scores within the longest
    stretch found first, where that is material.
    """
    new = iter(candidates([p for t, p in zip(traces, pairs, strict=True) if t.found is None]))
    found = [trace.found or next(new) for trace in traces]
    cuts = edges(pairs, found, level)
    doubtful = [i for i, t in enumerate(traces) if t.spikes and _is_doubtful(cuts[i])]
    # Of the longest stretch: what a fault does to later values is no property of the data.
    longest = [_longest(pairs[i], cuts[i]) for i in doubtful]
    times = correlation_times(scores_within(longest, [[0, len(v)] for v, _ in longest]))
    for i, time in zip(doubtful, times, strict=True):
        if time > CORRELATED:
            cuts[i] = _edges(pairs[i], found[i], level, float(time))
    return cuts


def _is_doubtful(edges: Sequence[int]) -> bool:
    return len(edges) > 2 and edges[-1] >= LEAST_CORRELATED


def _longest(pair: Pair, edges: Sequence[int]) -> Pair:
    a, b = max(pairwise(edges), key=lambda edge: edge[1] - edge[0])
    return pair[0][a:b], pair[1][a:b]


def candidates(pairs: Sequence[Pair]) -> list[Candidates]:
    """The best partitions of every sequence, in one go."""
    if not pairs:
        return []
    starts = np.concatenate([[0], np.cumsum([len(values) for values, _ in pairs])])
    values, dof = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    gains, cuts = _backend.kernels.scale_partitions(
        values, dof, starts.astype(np.int64), LEAST_SEGMENT, MOST_SEGMENTS
    )
    return [Candidates(g, c) for g, c in zip(gains, cuts, strict=True)]


def edges(pairs: Sequence[Pair], found: Sequence[Candidates], level: float) -> list[list[int]]:
    """Where each sequence is cut: the edges of its stretches."""
    return [_edges(pair, best, level) for pair, best in zip(pairs, found, strict=True)]


def _edges(pair: Pair, found: Candidates, level: float, factor: float = 1.0) -> list[int]:
    """Those of one sequence, each cut of which costs its penalty times ``factor``."""
    n = len(pair[0])
    count = 0
    if n >= 2 * LEAST_SEGMENT:
        count = deserved(found.gains, pair[1], LEAST_SEGMENT, level, factor)
    return found.edges(count, n)


def scores_within(pairs: Sequence[Pair], edges: Sequence[Sequence[int]]) -> list[Floats]:
    """Nearly normal scores of the values of each sequence under the scales of their stretches."""
    return [_scores(v, d, places) for (v, d), places in zip(pairs, edges, strict=True)]


def _scores(values: Floats, dof: Floats, edges: Sequence[int]) -> Floats:
    sums, dofs = (np.add.reduceat(column, edges[:-1]) for column in (values, dof))
    scales = np.maximum(sums / dofs, 1e-300)
    spread = scales[0] if len(scales) == 1 else np.repeat(scales, np.diff(edges))
    return _distributions.wilson_hilferty_z(values / (dof * spread), dof)


def _tested(
    pairs: Sequence[Pair], edges: Sequence[Sequence[int]], level: float
) -> list[tuple[Stretch, ...]]:
    """The stretches with their scales, intervals and corrected p-values."""
    sums, dofs = [], []
    for (values, dof), places in zip(pairs, edges, strict=True):
        sums += np.add.reduceat(values, places[:-1]).tolist()
        dofs += np.add.reduceat(dof, places[:-1]).tolist()
    n, m = np.array(sums), np.array(dofs)
    p = _distributions.chi2_p_value(n, m)
    low, high = (
        n / _distributions.chi2_quantile(0.975, m),
        n / _distributions.chi2_quantile(0.025, m),
    )
    found, at = [], 0
    for places in edges:
        count = len(places) - 1
        corrected = p[at : at + 1] if count == 1 else _distributions.holm(p[at : at + count])
        found.append(
            tuple(
                _stretch(
                    places[i],
                    places[i + 1],
                    sums[at + i],
                    dofs[at + i],
                    (float(low[at + i]), float(high[at + i])),
                    float(corrected[i]),
                    level,
                )
                for i in range(count)
            )
        )
        at += count
    return found


def _stretch(
    start: int,
    stop: int,
    total: float,
    dof: float,
    interval: tuple[float, float],
    p_value: float,
    level: float,
) -> Stretch:
    scale, label = total / dof, "consistent"
    if p_value < level and scale > MATERIAL:
        label = "high"
    elif p_value < level and scale < 1 / MATERIAL:
        label = "low"
    return Stretch(start, stop, total, dof, scale, interval, p_value, label)


def _drop_spikes(traces: Sequence[Trace]) -> None:
    """A stretch that is high by its largest value alone is not high."""
    for trace in traces:
        if any(s.label == "high" for s in trace.stretches):
            values, dof = trace.kept_values()
            trace.stretches = tuple(_without_spike(s, values, dof) for s in trace.stretches)


def _without_spike(stretch: Stretch, values: Floats, dof: Floats) -> Stretch:
    if stretch.label != "high" or len(stretch) < 2:
        return stretch
    c, m = values[stretch.start : stretch.stop], dof[stretch.start : stretch.stop]
    largest = int(np.argmax(c / m))
    rest = _distributions.chi2_sf(stretch.sum - c[largest], stretch.dof - m[largest])
    if rest <= 0.05:
        return stretch
    return Stretch(
        stretch.start,
        stretch.stop,
        stretch.sum,
        stretch.dof,
        stretch.scale,
        stretch.interval,
        stretch.p_value,
        "consistent",
        spike=True,
    )


LONGEST_END = 8
# The tests of 1 to 8 values share values: at a level of 0.005 they are worth no more than 3.3
# independent ones for 10 to 300 updates of 1 to 4 degrees of freedom (simulated), say 4.
TESTS = 4.0


def _test_ends(traces: Sequence[Trace], pairs: Sequence[Pair], level: float) -> None:
    """Is the beginning, or the end, too large against the rest and against chi-square itself?

    Both an F test and a chi-square test of the first (last) 1 to 8 values, corrected for their
    effective number: a cut needs two values and a strong gain, an end may show in fewer.
    """
    if not traces:
        return
    for reverse in (False, True):
        p_values, lengths = _end_tests(pairs, level, reverse)
        for trace, p, length in zip(traces, p_values, lengths, strict=True):
            if reverse:
                trace.end_p, trace.end_length = float(p), int(length)
            else:
                trace.start_p, trace.start_length = float(p), int(length)


def _end_tests(pairs: Sequence[Pair], level: float, reverse: bool) -> tuple[Floats, Integers]:
    """P-values of the ends of all traces, and the lengths that they are of."""
    lengths = np.array([len(values) for values, _ in pairs])
    starts = np.cumsum(lengths) - lengths
    most = np.minimum(LONGEST_END, np.maximum(1, lengths // 3))
    steps = np.minimum(np.arange(LONGEST_END), most[:, None] - 1)
    rows = starts[:, None] + (lengths[:, None] - 1 - steps if reverse else steps)
    values, dofs = (np.concatenate(column) for column in zip(*pairs, strict=True))
    n, m = np.cumsum(values[rows], axis=1), np.cumsum(dofs[rows], axis=1)
    total, dof = (np.add.reduceat(column, starts)[:, None] for column in (values, dofs))
    used = np.arange(LONGEST_END) < most[:, None]
    n, m = np.where(used, n, n[:, :1]), np.where(used, m, m[:, :1])
    rest = np.maximum(total - n, 1e-300) / (dof - m)
    p = np.where(used, _distributions.chi2_sf(n, m), 2.0)
    # The F test can only raise what is small enough to matter.
    small = p < level
    tails = _distributions.f_sf((n / m / rest)[small], m[small], (dof - m)[small])
    p[small] = np.maximum(p[small], tails)
    best = np.argmin(p, axis=1)
    corrected = p[np.arange(len(pairs)), best] * np.minimum(most, TESTS)
    return np.minimum(1.0, corrected), best + 1
