"""Normalised squares of errors (NEES) and of innovations (NIS)."""

from collections.abc import Mapping
from typing import Any

from trackmetrics import _backend, _check, errors
from trackmetrics._check import Floats
from trackmetrics._covariance_rule import SYMMETRY
from trackmetrics.errors import NotPlain


def nees(
    true_state: Any,
    estimated_state: Any,
    covariance: Any,
    *,
    angles: Mapping[int, float] | None = None,
    on_invalid: str = "raise",
) -> Any:
    """Normalised estimation error squared (NEES): the error in units of the claimed uncertainty.

        nees = e' P^-1 e    with    e = true_state - estimated_state

    Parameters
    ----------
    true_state, estimated_state : array_like of shape (..., d)
        Truth and estimate, in the same units. A number is a state of one component, and ``(d, 1)``
        a column vector.
    covariance : array_like of shape (..., d, d), or (d, d) for all
        The covariance P of the estimate's error, in the squares of those units.
    angles : mapping from index to period, optional
        Which components are angles, and their period (360 for degrees): their errors are wrapped
        into (-period / 2, period / 2].
    on_invalid : "raise" or "nan"
        What to do where a state is not finite, or a covariance is not finite, symmetric and
        positive definite.

    Returns
    -------
    float or ndarray of shape (...)
        At least 0; a float where there are no leading axes. A consistent Gaussian filter gives a
        chi-square of d degrees of freedom: d on average. More means optimistic (P too small), less
        pessimistic.

    Raises
    ------
    ValueError
        Where shapes do not fit (nothing is broadcast but one covariance for all), a number is not
        finite, or a covariance is not symmetric: ``|Pij - Pji| > 1e-8 sqrt(Pii Pjj)`` (1e-3 for
        float32). Below that, ``(P + P') / 2`` is used.
    numpy.linalg.LinAlgError
        Where a covariance is not positive definite; it is named by its index.

    Notes
    -----
    Exact to within ``1e-12 + 8 eps cond(D^-1/2 P D^-1/2)`` with ``D = diag(P)``: no matrix is
    inverted, and the units of the states do not matter. Say whether predicted or updated states
    are meant: both give a chi-square, but a fault shows in the updated NEES one update later.
    Values from consecutive times of one run are correlated.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> import numpy as np
    >>> nees([1.0, 2.0], [2.0, 4.0], [[2.0, 0.0], [0.0, 8.0]])
    1.0
    >>> nees([[10.0], [359.0]], [[8.0], [1.0]], [[4.0]], angles={0: 360.0})
    array([1., 1.])
    """
    kernel = _backend.kernels.nees
    nan = _check.nan_where_invalid(on_invalid)
    periods = _check.periods(angles, covariance)
    try:
        return kernel(true_state, estimated_state, covariance, SYMMETRY, periods, nan)
    except NotPlain:
        truth, estimate, p, symmetry = _check.states(
            ("covariance", covariance),
            ("true_state", true_state),
            ("estimated_state", estimated_state),
        )
        return kernel(truth, estimate, p, symmetry, periods, nan)


def nees_sequence(
    true_states: Any,
    estimated_states: Any,
    covariances: Any,
    *,
    angles: Mapping[int, float] | None = None,
    on_invalid: str = "raise",
) -> Floats:
    """NEES of a sequence of states: :func:`nees` of every step.

    Parameters
    ----------
    true_states, estimated_states : array_like of shape (..., N, d)
        Truth and estimates, in the same units.
    covariances : array_like of shape (..., N, d, d), or (d, d) for all
        The covariances of the estimates' errors.
    angles, on_invalid
        As in :func:`nees`.

    Returns
    -------
    ndarray of shape (..., N)
        One NEES for each state, about d where the filter is consistent.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As in :func:`nees`.

    Examples
    --------
    >>> import numpy as np
    >>> nees_sequence([[1.0, 2.0], [1.5, 2.5]], [[1.5, 2.0], [1.5, 2.0]], 0.25 * np.eye(2))
    array([1., 1.])
    """
    kernel = _backend.kernels.nees_sequence
    nan = _check.nan_where_invalid(on_invalid)
    periods = _check.periods(angles, covariances)
    try:
        forms = kernel(true_states, estimated_states, covariances, SYMMETRY, periods, nan)
    except NotPlain:
        truth, estimates, p, symmetry = _check.states(
            ("covariances", covariances),
            ("true_states", true_states),
            ("estimated_states", estimated_states),
        )
        forms = kernel(truth, estimates, p, symmetry, periods, nan)
    result: Floats = forms
    return result


def average_nees(
    true_states: Any,
    estimated_states: Any,
    covariances: Any,
    *,
    angles: Mapping[int, float] | None = None,
) -> float:
    """Mean NEES over all states.

    Parameters
    ----------
    true_states, estimated_states, covariances, angles
        As in :func:`nees_sequence`.

    Returns
    -------
    float
        About d where the filter is consistent; more is optimistic, less pessimistic.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As in :func:`nees`, and where there are no states.

    Notes
    -----
    For its acceptance interval see :func:`consistency_test` for independent runs. Over
    the steps of one run NEES is correlated, and that test rejects consistent filters too often.

    Examples
    --------
    >>> import numpy as np
    >>> average_nees([[1.0, 2.0], [1.5, 2.5]], [[1.5, 2.0], [1.5, 1.5]], 0.25 * np.eye(2))
    2.5
    """
    forms = nees_sequence(true_states, estimated_states, covariances, angles=angles)
    if forms.size == 0:
        raise errors.empty("true_states")
    return float(forms.mean())


def nis(
    innovation: Any,
    innovation_covariance: Any,
    *,
    angles: Mapping[int, float] | None = None,
    on_invalid: str = "raise",
) -> Any:
    """Normalised innovation squared (NIS): a measurement's surprise in units of what was expected.

        nis = v' S^-1 v    with    v = z - h(x-)  and  S = H P- H' + R

    Parameters
    ----------
    innovation : array_like of shape (..., m)
        Measurement less predicted measurement, before the update. A number is an innovation of one
        component, and ``(m, 1)`` a column vector.
    innovation_covariance : array_like of shape (..., m, m), or (m, m) for all
        The covariance S of the innovation, from the predicted covariance of the state.
    angles : mapping from index to period, optional
        Which components are angles, and their period: these are wrapped into
        (-period / 2, period / 2].
    on_invalid : "raise" or "nan"
        What to do where an innovation is not finite, or a covariance is not finite, symmetric and
        positive definite.

    Returns
    -------
    float or ndarray of shape (...)
        At least 0; a float where there are no leading axes. A consistent filter gives a
        chi-square of m degrees of freedom, m on average, independent from one update to the next.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As in :func:`nees`.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> nis([0.5, -1.0], [[0.25, 0.0], [0.0, 0.5]])
    3.0
    """
    kernel = _backend.kernels.nis
    nan = _check.nan_where_invalid(on_invalid)
    periods = _check.periods(angles, innovation_covariance)
    try:
        return kernel(innovation, innovation_covariance, SYMMETRY, periods, nan)
    except NotPlain:
        v, s, symmetry = _check.states(
            ("innovation_covariance", innovation_covariance), ("innovation", innovation)
        )
        return kernel(v, s, symmetry, periods, nan)


def nis_sequence(
    innovations: Any,
    innovation_covariances: Any,
    *,
    angles: Mapping[int, float] | None = None,
    on_invalid: str = "raise",
) -> Floats:
    """NIS of a sequence of innovations: :func:`nis` of every update.

    Parameters
    ----------
    innovations : array_like of shape (..., N, m)
        Measurements less predicted measurements.
    innovation_covariances : array_like of shape (..., N, m, m), or (m, m) for all
        The covariances of the innovations.
    angles, on_invalid
        As in :func:`nis`.

    Returns
    -------
    ndarray of shape (..., N)
        One NIS for each innovation, about m where the filter is consistent.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As in :func:`nees`.

    Examples
    --------
    >>> nis_sequence([[0.5, -1.0], [0.5, 0.0]], [[0.25, 0.0], [0.0, 0.5]])
    array([3., 1.])
    """
    kernel = _backend.kernels.nis_sequence
    nan = _check.nan_where_invalid(on_invalid)
    periods = _check.periods(angles, innovation_covariances)
    try:
        forms = kernel(innovations, innovation_covariances, SYMMETRY, periods, nan)
    except NotPlain:
        v, s, symmetry = _check.states(
            ("innovation_covariances", innovation_covariances), ("innovations", innovations)
        )
        forms = kernel(v, s, symmetry, periods, nan)
    result: Floats = forms
    return result
