"""Isolated values that are far too large: bad measurements, to be reported before anything else."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from trackmetrics.diagnostics import chisquare
from trackmetrics.diagnostics.columns import Floats, Integers

if TYPE_CHECKING:
    from trackmetrics.diagnostics.series import Trace

LEAST_UPDATES = 10
MOST = 0.12
"""Above this share of the updates they are no outliers but a fault."""
ISOLATED = 0.7
"""Share of the large values that must stand alone."""


def set_aside(traces: Sequence["Trace"], level: float) -> None:
    """Takes outliers out of ``kept``: extreme under the robust scale, and alone."""
    for trace in _suspicious(traces, level):
        values, dof = trace.kept_values()
        while len(found := _isolated(values, dof, level)):
            trace.kept = np.delete(trace.kept, found)
            values, dof = trace.kept_values()
        kept = set(trace.kept.tolist())
        trace.outliers = tuple(k for k in range(len(trace.values)) if k not in kept)


def _suspicious(traces: Sequence["Trace"], level: float) -> list["Trace"]:
    """Those with any value that is extreme under a scale of 1: the robust scale is never less."""
    if not traces:
        return []
    tails = chisquare.upper_tail(
        np.concatenate([s.values for s in traces]), np.concatenate([s.dof for s in traces])
    )
    starts = np.concatenate([[0], np.cumsum([len(s.values) for s in traces])[:-1]])
    least = np.minimum.reduceat(tails, starts)
    return [
        s
        for s, p in zip(traces, least, strict=True)
        if len(s.values) >= LEAST_UPDATES and p < level / len(s.values)
    ]


def robust_scale(values: Floats, dof: Floats) -> float:
    """The median of the values over the median that chi-square promises, at least 1."""
    return max(1.0, float(np.median(values / chisquare.quantile(0.5, dof))))


def _isolated(values: Floats, dof: Floats, level: float) -> Integers:
    n = len(values)
    tails = chisquare.upper_tail(values / robust_scale(values, dof), dof)
    hits = np.flatnonzero(tails < level / n)
    if not 0 < len(hits) <= max(1.0, MOST * n):
        return hits[:0]
    near = np.isin(hits - 1, hits) | np.isin(hits + 1, hits)
    alone = hits[~near & (hits >= 2) & (hits < n - 2)]
    return alone if len(alone) >= ISOLATED * len(hits) else hits[:0]
