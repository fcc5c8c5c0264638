"""How much each state contributes to the NEES: Shapley, marginal and conditional values."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from trackmetrics import _backend
from trackmetrics._covariances import fill_missing_with_identity, valid_components
from trackmetrics.diagnostics.thresholds import MAX_EXACT_STATES, NUM_SAMPLED_ORDERS, SEED
from trackmetrics.logs.columns import Floats, Integers

NAN = float("nan")


@dataclass(frozen=True, eq=False)
class Attribution:
    """The contribution of each state to the NEES over the updates that have it."""

    nees_share: Floats
    """Its share of the sum of all NEES; all states sum to 1."""
    shapley_nees: Floats
    """Mean Shapley value; all states sum to the mean NEES."""
    marginal_nees: Floats
    """Mean e_i^2 / P_ii."""
    conditional_nees: Floats
    """Mean decrease of the NEES without the state, (P^-1 e)_i^2 / (P^-1)_ii."""


def attribute_nees(errors: Floats, covariances: Floats) -> Attribution:
    """Attributes the NEES of these updates to the states; a missing component takes no part."""
    d, valid = errors.shape[1], valid_components(errors, covariances)
    covariances = fill_missing_with_identity(covariances, valid)
    std = np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    e, p = np.where(valid, errors, 0.0) / std, covariances / std[:, :, None] / std[:, None, :]
    e, p = np.ascontiguousarray(e), np.ascontiguousarray((p + p.swapaxes(1, 2)) / 2)
    if d <= MAX_EXACT_STATES:
        shapley = _backend.kernels.shapley_shares(e, p)
    else:
        shapley = _backend.kernels.sampled_shapley_shares(e, p, _orders(d))
    inverse = np.linalg.inv(p)
    conditional = np.einsum("kij,kj->ki", inverse, e) ** 2 / inverse.diagonal(axis1=1, axis2=2)
    total, count = float(shapley.sum()), valid.sum(axis=0)
    shares = shapley.sum(axis=0) / total if total > 0 else np.full(d, NAN)
    means = (_mean(column.sum(axis=0), count) for column in (shapley, e**2, conditional))
    return Attribution(np.where(count > 0, shares, NAN), *means)


def _mean(sums: Floats, count: Integers) -> Floats:
    return np.where(count > 0, sums / np.maximum(count, 1), NAN)


@lru_cache(maxsize=8)
def _orders(states: int) -> Integers:
    generator = np.random.default_rng(SEED)
    drawn = np.tile(np.arange(states), (NUM_SAMPLED_ORDERS, 1))
    orders: Integers = generator.permuted(drawn, axis=1).astype(np.int64).ravel()
    return orders
