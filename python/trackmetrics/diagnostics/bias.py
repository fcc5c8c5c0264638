"""Biases: the mean innovation of a component, and the constant error of a state.

*Innovations* are white, so that a mean is found by generalised least squares with the innovation
covariances; its variance is widened where the residuals are wider than these, or correlated.

*Errors* (estimate minus truth) are correlated in time. With e_k = A_k e_(k-1) + d_k, a constant
bias b enters the increments as d_k = (I - A_k) b + noise of covariance
D_k = P_k - A_k P_(k-1) A_k', independent in time; e_0 = b + noise of covariance P_0. So b is found
by generalised least squares, and its variance is the larger of the model's and of the sandwich of
the scores (Newey and West 1987, doi:10.2307/1913610). Without A, or where some components of the
errors are missing, each state is tested by the mean of the errors that it has.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackmetrics import _distributions
from trackmetrics._covariances import fill_missing_with_identity, quadratic_forms, valid_components
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.diagnostics.autocorrelation import transitions
from trackmetrics.diagnostics.innovations import Innovations
from trackmetrics.diagnostics.results import Bias
from trackmetrics.diagnostics.thresholds import (
    MAX_P_WIDE_RESIDUALS,
    MIN_EXPLAINED_SHARE,
    MIN_SCALE_RATIO,
    MIN_UPDATES_FOR_BIAS,
)
from trackmetrics.logs.columns import Columns, Floats, Integers
from trackmetrics.logs.header import State

Biases = tuple[Bias, ...]


# -- innovations


def innovation_biases(innovations: Innovations, alpha: float, inflation: float = 1.0) -> Biases:
    """The significant mean innovations of each component of each measurement type.

    Of all components with at least 8 values, Holm-corrected. The variance of a mean is widened
    where the residuals are wider than their covariances or correlated in time (Newey and West 1987,
    doi:10.2307/1913610), and by at least the factor ``inflation``.
    """
    return tuple(b for b in mean_innovations(innovations, inflation) if b.p_value < alpha)


def mean_innovations(innovations: Innovations, inflation: float = 1.0) -> list[Bias]:
    """The same, significant or not."""
    found = []
    for name in sorted(set(innovations.types)):
        rows = innovations.types == name
        parts = innovations.values[rows], innovations.covariances[rows]
        found += _mean_innovations_of(str(name), *parts, inflation)
    return _corrected(found)


def _corrected(biases: list[Bias]) -> list[Bias]:
    """The biases with p-values corrected for their number."""
    if not biases:
        return []
    p_values = _distributions.holm(np.array([b.p_value for b in biases]))
    return [replace(b, p_value=float(p)) for b, p in zip(biases, p_values, strict=True)]


def _mean_innovations_of(
    name: str, values: Floats, covariances: Floats, inflation: float
) -> list[Bias]:
    """Those of one measurement type, uncorrected."""
    tested = np.flatnonzero((~np.isnan(values)).sum(axis=0) >= MIN_UPDATES_FOR_BIAS)
    if not len(tested):
        return []
    values, covariances = values[:, tested], covariances[:, tested[:, None], tested]
    means, variances = _weighted_means(values, covariances)
    residuals = (values - means) / np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    known = [r[~np.isnan(r)] for r in residuals.T]
    spread = _excess_spread(known)
    inflations = np.array([max(inflation, _variance_inflation(r)) for r in known])
    z = means / np.sqrt(variances * spread * inflations)
    # The t distribution only where the variance is estimated.
    p = np.where(
        spread > 1,
        _distributions.t_p_value(z, np.array([len(r) - 1.0 for r in known])),
        _distributions.normal_p_value(z),
    )
    columns = zip(tested.tolist(), means.tolist(), z.tolist(), p.tolist(), strict=True)
    return [_innovation_bias(name, *column) for column in columns]


def _innovation_bias(name: str, index: int, value: float, z: float, p_value: float) -> Bias:
    return Bias("innovation", name or None, f"z[{index}]", value, "", z, p_value, index)


def _weighted_means(values: Floats, covariances: Floats) -> tuple[Floats, Floats]:
    """Means and their variances, by generalised least squares over the valid components."""
    valid = ~np.isnan(values)
    weights = np.linalg.inv(fill_missing_with_identity(covariances, valid))
    weights = np.where(valid[:, :, None] & valid[:, None, :], weights, 0.0)
    variance = np.linalg.inv(weights.sum(axis=0))
    means = variance @ np.einsum("kij,kj->i", weights, np.where(valid, values, 0.0))
    return means, variance.diagonal()


def _excess_spread(residuals: list[Floats]) -> Floats:
    """The variance of unit residuals where it is significantly above 1, else 1."""
    squares = np.array([float(r @ r) for r in residuals])
    counts = np.array([float(len(r)) for r in residuals])
    wide = _distributions.chi2_sf(squares, counts - 1) < MAX_P_WIDE_RESIDUALS
    return np.where(wide, np.maximum(1.0, squares / counts), 1.0)


def _variance_inflation(residuals: Floats) -> float:
    """The factor by which correlation in time widens the variance of a mean; at least 1.

    With Bartlett weights, over the lags whose correlation exceeds two standard deviations.
    """
    n = len(residuals)
    power = max(float(residuals @ residuals), 1e-300)
    inflation = 1.0
    for lag, weight in _bartlett_weights(n):
        shared = float(residuals[:-lag] @ residuals[lag:]) / power
        if abs(shared) > 2 / n**0.5:
            inflation += 2 * weight * shared
    return max(1.0, inflation)


def _bartlett_weights(n: int) -> list[tuple[int, float]]:
    """The lags up to the cube root of ``n``, and their weights."""
    longest = max(1, round(n ** (1 / 3)))
    return [(lag, 1 - lag / (longest + 1)) for lag in range(1, min(longest, n - 1) + 1)]


def named_by_states(biases: Biases, columns: Columns, states: Sequence[State]) -> Biases:
    """Innovation biases with the names and units of the states that the components observe."""
    return tuple(_named(bias, columns, states) for bias in biases)


def _named(bias: Bias, columns: Columns, states: Sequence[State]) -> Bias:
    observed, types = columns.observed, columns.measurement_type
    if observed is None:
        return bias
    of_type = types == (bias.measurement_type or "") if types is not None else slice(None)
    seen = set(observed[of_type, bias.index].tolist()) - {-1}
    if len(seen) != 1:
        return bias
    state = states[seen.pop()]
    return replace(bias, component=state.name, unit=state.unit)


# -- errors of states


def state_biases(
    columns: Columns, rows: Integers, states: Sequence[State], alpha: float
) -> tuple[Biases, bool]:
    """The significant biases of the states over these updates, and whether they explain the NEES.

    They do if they take away more than half of the excess; without an excess their significance
    must be higher.
    """
    if columns.error is None or columns.P is None:
        return (), False
    valid = valid_components(columns.error[rows], columns.P[rows])
    rows, valid = rows[valid.any(axis=1)], valid[valid.any(axis=1)]
    errors, covariances = np.where(valid, columns.error[rows], np.nan), columns.P[rows]
    has_steps = columns.A is not None and valid.all()
    steps = transitions(columns, rows) if has_steps else None
    found = [b for b in mean_errors(errors, covariances, steps) if b.p_value < alpha]
    named = (replace(b, component=states[b.index].name, unit=states[b.index].unit) for b in found)
    return tuple(named), bool(found) and _explain(errors, covariances, found, alpha)


def _explain(errors: Floats, covariances: Floats, biases: Sequence[Bias], alpha: float) -> bool:
    bias = np.zeros(errors.shape[1])
    for found in biases:
        bias[found.index] = found.value
    dof = float((~np.isnan(errors)).sum())
    before, after = (
        float(quadratic_forms(e, covariances).sum()) / dof for e in (errors, errors - bias)
    )
    if before < MIN_SCALE_RATIO:
        return min(b.p_value for b in biases) < alpha / 4
    return explains_most(before, after)


def explains_most(before: float, after: float) -> bool:
    """Whether most of the excess of a scale over 1 is gone without the bias."""
    return bool(before - after > MIN_EXPLAINED_SHARE * (before - 1.0))


def mean_errors(errors: Floats, covariances: Floats, steps: Floats | None) -> list[Bias]:
    """The constant error of every state that has at least 8 errors, Holm-corrected.

    ``steps`` are the A_k, if all of them are known and no error misses a component.
    """
    tested = np.flatnonzero((~np.isnan(errors)).sum(axis=0) >= MIN_UPDATES_FOR_BIAS)
    if not len(tested):
        return []
    if steps is None:
        std = np.sqrt(covariances.diagonal(axis1=1, axis2=2))
        values, z, dof = _means(errors[:, tested], std[:, tested])
    else:
        values, z, dof = _least_squares(errors, covariances, steps)
    p = _distributions.holm(_distributions.t_p_value(z, dof))
    columns = zip(tested.tolist(), values.tolist(), z.tolist(), p.tolist(), strict=True)
    return [_state_bias(*column) for column in columns]


def _state_bias(index: int, value: float, z: float, p_value: float) -> Bias:
    return Bias("state", None, f"x[{index}]", value, "", z, p_value, index)


def _means(errors: Floats, std: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean errors, the same in standard deviations, and the degrees of freedom of these."""
    known = [~np.isnan(column) for column in errors.T]
    ratios = [(e / s)[k] for e, s, k in zip(errors.T, std.T, known, strict=True)]
    # The number of independent errors: their number over their correlation time.
    counts = np.array([len(r) for r in ratios])
    worth = np.maximum(3.0, counts / correlation_times(ratios))
    spread = np.array([max(1.0, float(r.std(ddof=1))) for r in ratios])
    means = np.array([float(r.mean()) for r in ratios])
    return np.nanmean(errors, axis=0), means / (spread / np.sqrt(worth)), worth - 1


def _least_squares(
    errors: Floats, covariances: Floats, steps: Floats
) -> tuple[Floats, Floats, Floats]:
    n, d = errors.shape
    # In units of the first standard deviations: with latitudes next to speeds the information
    # matrix is nearly singular.
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
    sandwich = variance @ _newey_west(scores) @ variance
    spread = np.sqrt(np.maximum(variance.diagonal(), sandwich.diagonal()))
    lag = max(1, round(n ** (1 / 3)))
    return bias * unit, bias / spread, np.full(d, max(3.0, n / lag - 1))


def _inverse(information: Floats) -> Floats:
    scale = np.sqrt(np.maximum(information.diagonal(), 1e-300))
    ridge = information / np.outer(scale, scale) + 1e-12 * np.eye(len(scale))
    inverse: Floats = np.linalg.inv(ridge) / np.outer(scale, scale)
    return inverse


def _newey_west(scores: Floats) -> Floats:
    """Covariance of the sum of scores, with Bartlett weights."""
    total: Floats = scores.T @ scores
    for lag, weight in _bartlett_weights(len(scores)):
        shared = scores[:-lag].T @ scores[lag:]
        total = total + weight * (shared + shared.T)
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
