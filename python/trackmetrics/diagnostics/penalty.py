"""How much the best cut of an honest sequence gains by chance, and how many cuts data deserve.

The penalty of one more segment is the 1 - ``level`` quantile of the gain of the best single cut
under one common scale, over ``DRAWS`` drawn sequences of the very pattern of degrees of freedom:
exact for every length and mix, and blind to the scale, so that a constant misfit makes no cut. The
draws come from a generator of fixed seed, once per pattern, so that a diagnosis is deterministic.
"""

from functools import lru_cache

import numpy as np

from trackmetrics import _backend, _distributions
from trackmetrics.logs.columns import Floats

DRAWS = 4000
SEED = 20260224
# Draws of longer patterns are made on blocks of updates: their quantile has long converged.
LONGEST = 1024


def penalty(dof: Floats, least: int, level: float) -> float:
    """The gain that a cut must exceed, for this pattern of degrees of freedom."""
    if len(dof) > LONGEST:
        stride = -(-len(dof) // LONGEST)
        dof = np.add.reduceat(dof, np.arange(0, len(dof), stride))
    # Two decimals: the effective degrees of freedom of NEES differ from track to track for nothing.
    return _drawn(tuple(np.maximum(np.round(dof, 2), 0.01).tolist()), least, level)


@lru_cache(maxsize=4096)
def _drawn(pattern: tuple[float, ...], least: int, level: float) -> float:
    dof = np.array(pattern)
    generator = np.random.default_rng(SEED)
    draws = generator.standard_gamma(dof / 2.0, size=(DRAWS, len(dof)))
    gains = _backend.kernels.best_split_gains(np.maximum(draws, 1e-300), dof, least)
    return float(np.quantile(gains, 1.0 - level))


def deserved(gains: Floats, dof: Floats, least: int, level: float, factor: float = 1.0) -> int:
    """How many cuts pay for their penalty (times ``factor``), from the gains with 0, 1, 2, ...

    The penalty of the very pattern is drawn only where bounds that cost less cannot decide.
    """
    listed = gains.tolist()
    for bounds in (_bounds(level), None):
        low, high = bounds or _near(dof, least, level)
        few = _count(listed, high * factor)
        if few == _count(listed, low * factor):
            return few
    return _count(listed, penalty(dof, least, level) * factor)


def _count(gains: list[float], price: float) -> int:
    """The number of cuts with the largest gain after their price; the least of equals."""
    best, most = 0, gains[0]
    for count, gain in enumerate(gains):
        if gain - count * price > most:
            best, most = count, gain - count * price
    return best


@lru_cache(maxsize=64)
def _bounds(level: float) -> tuple[float, float]:
    """Bounds of every penalty of this level.

    The best of many cuts gains at least what one does, whose law is chi-square with one degree of
    freedom or a little wider; and at most what 5000 independent ones would with twice that spread.
    """
    low = float(_distributions.chi2_quantile(1.0 - level, 1.0))
    return low, 2.0 * float(_distributions.chi2_quantile(1.0 - level / 5000.0, 1.0))


WITHIN = 1.2
"""A mixed pattern's penalty is within this factor of that of an even one of a similar length."""
MILD = 10.0
"""Provided that its degrees of freedom differ by no more than this factor."""


def _near(dof: Floats, least: int, level: float) -> tuple[float, float]:
    """Bounds from an even pattern of about this length and mean, whose penalty others share."""
    if dof.max() > MILD * dof.min() or dof.min() < 0.5:
        return _bounds(level)
    # Steps of a fifth: the penalty grows with the logarithm of the logarithm of the length.
    length = round(1.2 ** round(np.log(len(dof)) / np.log(1.2)))
    mean = float(np.round(dof.mean() * 2) / 2)
    even = _even(max(length, 2 * least), max(mean, 0.5), least, level)
    return even / WITHIN, even * WITHIN


@lru_cache(maxsize=4096)
def _even(length: int, mean: float, least: int, level: float) -> float:
    return penalty(np.full(length, mean), least, level)
