"""A constant error of the state, from errors that remember each other.

With e_k = A_k e_(k-1) + d_k, a constant bias b enters the increments as d_k = (I - A_k) b + noise
of covariance D_k = P_k - A_k P_(k-1) A_k', independent in time; e_0 = b + noise of covariance P_0.
So b is found by generalised least squares, and its variance is the larger of the model's and of
the sandwich of the scores (Newey and West 1987, doi:10.2307/1913610). Without A, or where some
components of the errors are missing, each state is tested by the mean of the errors that it has.
"""

from dataclasses import dataclass

import numpy as np

from trackmetrics import _distributions
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.logs.columns import Floats

LEAST_UPDATES = 8


@dataclass(frozen=True)
class StateOffset:
    """The constant error of one state."""

    state: int
    value: float
    z: float
    p_value: float


def state_offsets(errors: Floats, covariances: Floats, steps: Floats | None) -> list[StateOffset]:
    """The constant error of every state that has 8, Holm-corrected; ``steps`` are the A_k, if all
    of them are known and no error misses a component."""
    tested = np.flatnonzero((~np.isnan(errors)).sum(axis=0) >= LEAST_UPDATES)
    if not len(tested):
        return []
    if steps is None:
        std = np.sqrt(covariances.diagonal(axis1=1, axis2=2))
        values, z, dof = _means(errors[:, tested], std[:, tested])
    else:
        values, z, dof = _least_squares(errors, covariances, steps)
    p = _distributions.holm(_distributions.t_p_value(z, dof))
    columns = zip(tested.tolist(), values.tolist(), z.tolist(), p.tolist(), strict=True)
    return [StateOffset(*column) for column in columns]


def _means(errors: Floats, std: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean errors, the same in standard deviations, and the degrees of freedom of these."""
    known = [~np.isnan(column) for column in errors.T]
    ratios = [(e / s)[k] for e, s, k in zip(errors.T, std.T, known, strict=True)]
    # As many independent ones as there are over their correlation time.
    counts = np.array([len(r) for r in ratios])
    worth = np.maximum(3.0, counts / correlation_times(ratios))
    spread = np.array([max(1.0, float(r.std(ddof=1))) for r in ratios])
    means = np.array([float(r.mean()) for r in ratios])
    return np.nanmean(errors, axis=0), means / (spread / np.sqrt(worth)), worth - 1


def _least_squares(
    errors: Floats, covariances: Floats, steps: Floats
) -> tuple[Floats, Floats, Floats]:
    n, d = errors.shape
    # Units of the first claim: latitudes next to speeds make information matrices singular.
    unit = np.sqrt(covariances[0].diagonal())
    e, p = errors / unit, covariances / np.outer(unit, unit)
    a = steps[1:] * unit / unit[:, None]
    entering = np.concatenate([np.eye(d)[None], np.eye(d) - a])
    increments = np.concatenate([e[:1], e[1:] - np.einsum("kij,kj->ki", a, e[:-1])])
    noise = np.concatenate([p[:1], p[1:] - a @ p[:-1] @ a.swapaxes(1, 2)])
    weights = entering.swapaxes(1, 2) @ pseudo_inverses(noise)
    information = (weights @ entering).sum(axis=0)
    variance = _inverse(information)
    bias = variance @ np.einsum("kij,kj->i", weights, increments)
    residuals = increments - entering @ bias
    scores = np.einsum("kij,kj->ki", weights, residuals)
    sandwich = variance @ _long_run(scores) @ variance
    spread = np.sqrt(np.maximum(variance.diagonal(), sandwich.diagonal()))
    lag = max(1, round(n ** (1 / 3)))
    return bias * unit, bias / spread, np.full(d, max(3.0, n / lag - 1))


def _inverse(information: Floats) -> Floats:
    scale = np.sqrt(np.maximum(information.diagonal(), 1e-300))
    ridge = information / np.outer(scale, scale) + 1e-12 * np.eye(len(scale))
    inverse: Floats = np.linalg.inv(ridge) / np.outer(scale, scale)
    return inverse


def _long_run(scores: Floats) -> Floats:
    """Covariance of the sum of scores, with Bartlett weights up to the cube root of n."""
    n = len(scores)
    longest = max(1, round(n ** (1 / 3)))
    total: Floats = scores.T @ scores
    for lag in range(1, min(longest, n - 1) + 1):
        shared = scores[:-lag].T @ scores[lag:]
        total = total + (1 - lag / (longest + 1)) * (shared + shared.T)
    return total


def pseudo_inverses(covariances: Floats) -> Floats:
    """Inverses of many covariances on the directions in which they are not zero."""
    d = np.sqrt(np.maximum(covariances.diagonal(axis1=1, axis2=2), 1e-300))
    scaled = covariances / d[:, :, None] / d[:, None, :]
    values, vectors = np.linalg.eigh((scaled + scaled.swapaxes(1, 2)) / 2)
    # Relative to the unit diagonal: an update in one direction leaves the others exactly alone.
    inverted = np.where(values > 1e-8, 1 / np.where(values > 1e-8, values, 1.0), 0.0)
    inverse: Floats = (vectors * inverted[:, None, :]) @ vectors.swapaxes(1, 2)
    return inverse / d[:, :, None] / d[:, None, :]
