"""Is the beginning of a sequence, or its end, too large?

A change point needs two values and a strong gain; a fault at an end may show in fewer. The first
(last) 1 to 8 values are compared with the rest (F test) and with chi-square itself; the larger of
the two p-values counts, and the smallest over the lengths is corrected for the number of lengths.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics.thresholds import EFFECTIVE_END_TESTS, MAX_END_UPDATES
from trackmetrics.diagnostics.trace import Pair
from trackmetrics.logs.columns import Floats, Integers


@dataclass(frozen=True)
class EndTests:
    """P-values of "the first (last) values are not too large", and how many values they take."""

    start_p: float = 1.0
    start_length: int = 0
    end_p: float = 1.0
    end_length: int = 0


def end_tests(pairs: Sequence[Pair], alpha: float) -> list[EndTests]:
    """The tests of both ends of every sequence; p-values are exact only below ``alpha``."""
    if not pairs:
        return []
    columns = (*_tests(pairs, alpha, reverse=False), *_tests(pairs, alpha, reverse=True))
    return [EndTests(*row) for row in zip(*(c.tolist() for c in columns), strict=True)]


def _tests(pairs: Sequence[Pair], alpha: float, reverse: bool) -> tuple[Floats, Integers]:
    """P-values of one end of every sequence, and how many values they take."""
    lengths = np.array([len(values) for values, _ in pairs])
    starts = np.cumsum(lengths) - lengths
    most = np.minimum(MAX_END_UPDATES, np.maximum(1, lengths // 3))
    steps = np.minimum(np.arange(MAX_END_UPDATES), most[:, None] - 1)
    rows = starts[:, None] + (lengths[:, None] - 1 - steps if reverse else steps)
    values, dofs = (np.concatenate(column) for column in zip(*pairs, strict=True))
    n, m = np.cumsum(values[rows], axis=1), np.cumsum(dofs[rows], axis=1)
    total, dof = (np.add.reduceat(column, starts)[:, None] for column in (values, dofs))
    used = np.arange(MAX_END_UPDATES) < most[:, None]
    n, m = np.where(used, n, n[:, :1]), np.where(used, m, m[:, :1])
    rest = np.maximum(total - n, 1e-300) / (dof - m)
    p = np.where(used, _distributions.chi2_sf(n, m), 2.0)
    # The F test can only raise a p-value, so that it is needed only where this one is small.
    small = p < alpha
    tails = _distributions.f_sf((n / m / rest)[small], m[small], (dof - m)[small])
    p[small] = np.maximum(p[small], tails)
    best = np.argmin(p, axis=1)
    corrected = p[np.arange(len(pairs)), best] * np.minimum(most, EFFECTIVE_END_TESTS)
    return np.minimum(1.0, corrected), best + 1
