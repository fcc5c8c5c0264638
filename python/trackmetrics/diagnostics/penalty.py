"""The penalty of a change point, and how many change points a sequence has.

The penalty is the 1 - ``alpha`` quantile of the gain in log-likelihood of the best single change
point of a sequence without any, over simulated sequences with the same pattern of degrees of
freedom: it holds for every length and mix, and does not depend on the scale, so that a constant
misfit gives no change point. Simulations use a fixed seed, once per pattern.
"""

from functools import lru_cache

import numpy as np

from trackmetrics import _backend, _distributions
from trackmetrics.diagnostics.thresholds import (
    MAX_DOF_RATIO,
    MAX_PATTERN_LENGTH,
    NUM_DRAWS,
    SEED,
    UNIFORM_PENALTY_RATIO,
)
from trackmetrics.logs.columns import Floats


def penalty(dof: Floats, least: int, alpha: float) -> float:
    """The gain that a change point must exceed, for this pattern of degrees of freedom."""
    if len(dof) > MAX_PATTERN_LENGTH:
        stride = -(-len(dof) // MAX_PATTERN_LENGTH)
        dof = np.add.reduceat(dof, np.arange(0, len(dof), stride))
    # Two decimals, so that the effective degrees of freedom of NEES share their patterns.
    return _simulated_penalty(tuple(np.maximum(np.round(dof, 2), 0.01).tolist()), least, alpha)


@lru_cache(maxsize=4096)
def _simulated_penalty(pattern: tuple[float, ...], least: int, alpha: float) -> float:
    dof = np.array(pattern)
    generator = np.random.default_rng(SEED)
    draws = generator.standard_gamma(dof / 2.0, size=(NUM_DRAWS, len(dof)))
    gains = _backend.kernels.best_split_gains(np.maximum(draws, 1e-300), dof, least)
    return float(np.quantile(gains, 1.0 - alpha))


def select_num_changes(
    gains: Floats, dof: Floats, least: int, alpha: float, factor: float = 1.0
) -> int:
    """The number of change points, from the gains with 0, 1, 2, ... of them.

    Each costs its penalty times ``factor``. The penalty of the pattern itself is simulated only
    where bounds that are faster to compute cannot decide.
    """
    listed = gains.tolist()
    for bounds in (_bounds(alpha), None):
        low, high = bounds or _bounds_from_uniform_pattern(dof, least, alpha)
        few = _count(listed, high * factor)
        if few == _count(listed, low * factor):
            return few
    return _count(listed, penalty(dof, least, alpha) * factor)


def _count(gains: list[float], cost: float) -> int:
    """The number of change points with the largest gain after their cost; the least of equals."""
    best, most = 0, gains[0]
    for count, gain in enumerate(gains):
        if gain - count * cost > most:
            best, most = count, gain - count * cost
    return best


@lru_cache(maxsize=64)
def _bounds(alpha: float) -> tuple[float, float]:
    """Bounds of every penalty for this alpha.

    The best of many change points gains at least what one does, whose distribution is chi-square
    with one degree of freedom or a little wider; and at most what 5000 independent ones would with
    twice that spread.
    """
    low = float(_distributions.chi2_quantile(1.0 - alpha, 1.0))
    return low, 2.0 * float(_distributions.chi2_quantile(1.0 - alpha / 5000.0, 1.0))


def _bounds_from_uniform_pattern(dof: Floats, least: int, alpha: float) -> tuple[float, float]:
    """Bounds from the penalty of a uniform pattern of about this length and mean."""
    if dof.max() > MAX_DOF_RATIO * dof.min() or dof.min() < 0.5:
        return _bounds(alpha)
    # Steps of a fifth: the penalty grows with the logarithm of the logarithm of the length.
    length = round(1.2 ** round(np.log(len(dof)) / np.log(1.2)))
    mean = float(np.round(dof.mean() * 2) / 2)
    uniform = _uniform_penalty(max(length, 2 * least), max(mean, 0.5), least, alpha)
    return uniform / UNIFORM_PENALTY_RATIO, uniform * UNIFORM_PENALTY_RATIO


@lru_cache(maxsize=4096)
def _uniform_penalty(length: int, mean: float, least: int, alpha: float) -> float:
    return penalty(np.full(length, mean), least, alpha)
