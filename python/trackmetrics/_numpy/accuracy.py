"""Root mean square errors: reference implementation of ``accuracy`` in the core."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics import errors as messages
from trackmetrics._numpy.arguments import Floats, plain, plain_numbers


def rmse(true_states: Floats, estimated_states: Floats, axes: Sequence[int] | None) -> Any:
    """Root mean square of the errors over ``axes`` (all of them where it is None)."""
    plain(true_states, estimated_states)
    _same_shape(true_states, estimated_states)
    with np.errstate(all="ignore"):
        errors = true_states - estimated_states
    return _root_mean_square("true_states", errors, axes)


def monte_carlo_rmse(errors: Floats, axes: Sequence[int] | None) -> Any:
    """Root mean square of given errors over ``axes`` (all of them where it is None)."""
    plain(errors)
    return _root_mean_square("errors", errors, axes)


def position_rmse(
    true_states: Floats, estimated_states: Floats, position_indices: Sequence[int]
) -> float:
    """Root mean square error of the position components."""
    return _rmse_of(true_states, estimated_states, "position_indices", position_indices)


def velocity_rmse(
    true_states: Floats, estimated_states: Floats, velocity_indices: Sequence[int]
) -> float:
    """Root mean square error of the velocity components."""
    return _rmse_of(true_states, estimated_states, "velocity_indices", velocity_indices)


def estimation_error_bounds(covariances: Floats, sigma: float) -> Floats:
    """``sigma`` standard deviations of every state."""
    plain(covariances)
    plain_numbers(sigma)
    if covariances.ndim < 2 or covariances.shape[-1] != covariances.shape[-2]:
        raise messages.shape("covariances", covariances.shape, "(..., d, d)")
    if not np.isfinite(sigma):
        raise messages.parameter("sigma", "finite", sigma)
    variances = np.diagonal(covariances, axis1=-2, axis2=-1)
    unfair = np.argwhere(~(np.isfinite(variances) & (variances >= 0)))
    if unfair.size:
        *leading, i = unfair[0]
        index = (*leading, i, i)
        requirement = "finite and at least 0"
        raise messages.element("covariances", index, requirement, covariances[index])
    bounds: Floats = sigma * np.sqrt(variances)
    return bounds


def _rmse_of(
    true_states: Floats, estimated_states: Floats, argument: str, indices: Sequence[int]
) -> float:
    plain(true_states, estimated_states)
    if true_states.ndim == 0:
        raise messages.shape("true_states", (), "(..., d)")
    _same_shape(true_states, estimated_states)
    if not len(indices):
        raise messages.empty(argument)
    d = true_states.shape[-1]
    for place, index in enumerate(indices):
        if not -d <= index < d:
            raise messages.index_out_of_range(argument, place, index, d)
    if true_states.size == 0:
        raise messages.empty("true_states")
    with np.errstate(all="ignore"):
        errors = (true_states - estimated_states)[..., list(indices)]
        return float(np.sqrt(np.mean(errors * errors)))


def _root_mean_square(argument: str, errors: Floats, axes: Sequence[int] | None) -> Any:
    averaged = _averaged(errors.ndim, axes)
    if np.prod([errors.shape[axis] for axis in averaged], dtype=int) == 0:
        raise messages.empty(argument)
    with np.errstate(all="ignore"):
        roots = np.sqrt(np.mean(errors * errors, axis=averaged))
    return roots if np.ndim(roots) else float(roots)


def _averaged(count: int, axes: Sequence[int] | None) -> tuple[int, ...]:
    """The axes that are averaged, each counted from 0."""
    averaged: list[int] = []
    for axis in range(count) if axes is None else axes:
        if not -count <= axis < count or axis % count in averaged:
            raise messages.axis_out_of_range(axis, count)
        averaged.append(axis % count)
    return tuple(averaged)


def _same_shape(true_states: Floats, estimated_states: Floats) -> None:
    if estimated_states.shape != true_states.shape:
        raise messages.shape("estimated_states", estimated_states.shape, str(true_states.shape))
