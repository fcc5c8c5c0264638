"""Which states are to blame, and does a logged update add up?"""

from typing import Any

import numpy as np

from trackmetrics import _check, errors
from trackmetrics._check import Floats
from trackmetrics.consistency._input import nees_check
from trackmetrics.consistency.nees_nis import nees
from trackmetrics.consistency.results import UpdateIdentity


def marginal_nees(true_state: Any, estimated_state: Any, covariance: Any) -> Floats:
    """NEES of each state by itself, whatever the others do.

        e_j^2 / P_jj  ~  chi2(1)

    Parameters
    ----------
    true_state, estimated_state : array_like of shape (..., d)
        Truth and estimate.
    covariance : array_like of shape (..., d, d), or (d, d) for all
        The covariance of the estimate's error.

    Returns
    -------
    ndarray of shape (..., d)
        1 on average for each state of a consistent filter; they do not add up to the NEES.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`.

    Examples
    --------
    >>> marginal_nees([1.0, 2.0], [0.0, 0.0], [[1.0, 0.5], [0.5, 2.0]])
    array([1., 2.])
    """
    truth, estimate, p, _ = _states(true_state, estimated_state, covariance)
    forms: Floats = (truth - estimate) ** 2 / np.diagonal(p, axis1=-2, axis2=-1)
    return forms


def subspace_nees(true_state: Any, estimated_state: Any, covariance: Any, indices: Any) -> Any:
    """NEES of some of the states, whatever the others do.

        e_I' P_II^-1 e_I  ~  chi2(|I|)

    Parameters
    ----------
    true_state, estimated_state : array_like of shape (..., d)
        Truth and estimate.
    covariance : array_like of shape (..., d, d), or (d, d) for all
        The covariance of the estimate's error.
    indices : sequence of int
        Which states, each once.

    Returns
    -------
    float or ndarray of shape (...)
        About the number of indices where the filter is consistent.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`, and for an index outside the state or named twice.

    Examples
    --------
    >>> subspace_nees([1.0, 9.0, 2.0], [0.0, 0.0, 0.0], [[1, 0, 0], [0, 1, 0], [0, 0, 2]], [0, 2])
    3.0
    """
    truth, estimate, p, _ = _states(true_state, estimated_state, covariance)
    d = truth.shape[-1]
    chosen = [_index(i, place, d) for place, i in enumerate(_check.indices("indices", indices, d))]
    if len(set(chosen)) < len(chosen):
        raise ValueError(f"indices names a state twice: {chosen}")
    block = p[..., chosen, :][..., :, chosen]
    return nees(truth[..., chosen], estimate[..., chosen], block)


def _index(index: int, place: int, length: int) -> int:
    if not -length <= index < length:
        raise errors.index_out_of_range("indices", place, index, length)
    return index % length


def _states(truth: Any, estimate: Any, covariance: Any) -> Any:
    checked = _check.states(
        ("covariance", covariance), ("true_state", truth), ("estimated_state", estimate)
    )
    nees(*checked[:3])
    return checked


def update_identity(
    nis_values: Any,
    predicted_nees: Any,
    updated_nees: Any,
    measurement_errors: Any,
    measurement_covariances: Any,
    *,
    tolerance: float = 1e-6,
) -> UpdateIdentity:
    """Integrity check of a log: does each update add up?

    For a linear update, with v = z - H x the error of the measurement against the truth,

        NEES- + v' R^-1 v = NIS + NEES+

    Parameters
    ----------
    nis_values : array_like of shape (...)
        NIS of the update.
    predicted_nees, updated_nees : array_like of shape (...)
        NEES before and after it, NEES- and NEES+.
    measurement_errors : array_like of shape (..., m)
        Measurement less what it should have been.
    measurement_covariances : array_like of shape (..., m, m), or (m, m) for all
        The covariance R that the filter assumes.
    tolerance : float
        Largest difference, relative to the larger side, that counts as rounding.

    Returns
    -------
    UpdateIdentity
        The residual of each update and whether it is within rounding.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`nees`.

    Notes
    -----
    It fails where log and filter disagree: an innovation taken after the update, a covariance of
    another time, an unwrapped angle, a gain that is not optimal. For a nonlinear measurement it
    holds only as far as the linearisation does.

    Examples
    --------
    >>> # one state, P- = 1, R = 1: truth 0, prediction 2, measurement 1, so the update is 1.5
    >>> update_identity(1 / 2, 4.0, 1.5**2 / 0.5, [1.0], [[1.0]]).holds
    True
    """
    v, r, _ = _check.states(
        ("measurement_covariances", measurement_covariances),
        ("measurement_errors", measurement_errors),
    )
    share = _check.number("tolerance", tolerance)
    noise = nees_check(v, r, "measurement_errors", "measurement_covariances")
    before, nis_values, after = (
        _as_updates(argument, values, noise.shape)
        for argument, values in (
            ("predicted_nees", predicted_nees),
            ("nis_values", nis_values),
            ("updated_nees", updated_nees),
        )
    )
    before, after = before + noise, nis_values + after
    residual = before - after
    scale = np.maximum(np.abs(before), np.abs(after))
    return UpdateIdentity(residual, np.abs(residual) <= share * scale)


def _as_updates(argument: str, values: Any, shape: tuple[int, ...]) -> Floats:
    """A value for each update."""
    array = _check.floats(argument, values)
    if array.shape != shape:
        raise errors.shape(argument, array.shape, f"{shape}")
    return array
