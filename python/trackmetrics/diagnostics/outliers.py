"""Isolated values that are far too large: bad measurements, to be reported before anything else."""

from collections.abc import Sequence

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics.trace import Trace
from trackmetrics.logs.columns import Floats, Integers

LEAST_UPDATES = 10
MOST = 0.12
"""Above this share of the updates they are no outliers but a fault."""
ISOLATED = 0.7
"""Share of the large values that must stand alone."""
DRAGGED = 2
"""Most large values that one bad measurement makes."""
NEAR = 3
"""Large values that are no further apart belong together."""


def set_aside(traces: Sequence[Trace], level: float) -> None:
    """Takes outliers out of ``kept``: extreme under the robust scale of the rest, and alone."""
    for trace in _suspicious(traces, level):
        outliers: Integers = np.empty(0, np.int64)
        while True:
            scale = robust_scale(*trace.kept_values())
            found = _isolated(trace.values, trace.dof, scale, level)
            if len(found) <= len(outliers):
                break
            outliers = found
            trace.kept = np.setdiff1d(np.arange(len(trace.values)), outliers)
        trace.outliers = tuple(outliers.tolist())


def _suspicious(traces: Sequence[Trace], level: float) -> list[Trace]:
    """Those with any value that may be extreme."""
    if not traces:
        return []
    values = np.concatenate([t.values for t in traces])
    dof = np.concatenate([t.dof for t in traces])
    starts = np.cumsum([0, *(len(t.values) for t in traces)])
    # Below this no value is extreme, whatever its degrees of freedom: few are left to look at.
    large = np.flatnonzero(values > _distributions.chi2_isf(level / LEAST_UPDATES, dof.min()))
    of_trace = np.searchsorted(starts, large, side="right") - 1
    tails = _distributions.chi2_sf(values[large], dof[large])
    for i, tail in zip(of_trace.tolist(), tails.tolist(), strict=True):
        traces[i].least_tail = min(traces[i].least_tail, tail)
    return [t for t in traces if len(t.values) >= LEAST_UPDATES and is_suspicious(t, level)]


def is_suspicious(trace: Trace, level: float) -> bool:
    """Whether any value is extreme under a scale of 1: the robust scale is never less."""
    return trace.least_tail < level / len(trace.values)


def robust_scale(values: Floats, dof: Floats) -> float:
    """The median of the values over the median that chi-square promises, at least 1."""
    kinds, which = np.unique(dof, return_inverse=True)
    return max(1.0, float(np.median(values / _distributions.chi2_quantile(0.5, kinds)[which])))


def _isolated(values: Floats, dof: Floats, scale: float, level: float) -> Integers:
    """Extreme values that stand alone, and what they drag along.

    A bad measurement pulls the estimate away, so that one or two innovations after it may be large
    as well, but smaller; a fault grows.
    """
    n = len(values)
    tails = _distributions.chi2_sf(values / scale, dof)
    hits = np.flatnonzero(tails < level / n)
    if not 0 < len(hits) <= max(1.0, MOST * n):
        return hits[:0]
    runs = np.split(hits, np.flatnonzero(np.diff(hits) > NEAR) + 1)
    alone = [
        run
        for run in runs
        if len(run) <= DRAGGED and values[run].argmax() == 0 and run[0] >= 2 and run[-1] < n - 2
    ]
    count = sum(map(len, alone))
    return np.concatenate(alone) if alone and count >= ISOLATED * len(hits) else hits[:0]
