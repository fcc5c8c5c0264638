"""Statistics of NEES that are correlated over time: correlation times, tests, decorrelation."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, _deprecated, _distributions, errors
from trackmetrics._check import Floats
from trackmetrics.consistency._input import degrees, nees_check, statistics
from trackmetrics.consistency.mean_tests import mean_test
from trackmetrics.consistency.results import DecorrelatedNEES, MeanTest


def nees_correlation_time(transitions: Any, covariances: Any) -> Floats:
    """How many NEES values count as one, at each step of a run, from the filter's own matrices.

    With e_k = A_k e_(k-1) + d_k and P = L L',

        tau_k = (1 / d) sum_l |C_kl|_F^2    with    C_kl = L_k^-1 A_k ... A_(l+1) L_l

    since the covariance of two NEES values is 2 |C_kl|_F^2.

    Parameters
    ----------
    transitions : array_like of shape (K, d, d)
        ``A_k = (I - K_k H_k) F_k``: how the error of one updated state becomes that of the next.
        The first is not used.
    covariances : array_like of shape (K, d, d)
        Updated covariances P_k.

    Returns
    -------
    ndarray of shape (K,)
        At least 1. The variance of the summed NEES is 2 d sum_k tau_k.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        Where shapes do not fit or a covariance is not symmetric and positive definite.

    Examples
    --------
    >>> import numpy as np
    >>> nees_correlation_time(np.full((3, 1, 1), 0.5), np.ones((3, 1, 1)))
    array([1.3125, 1.5   , 1.3125])
    """
    a, p = _transitions(transitions, covariances)
    steps, d = p.shape[:2]
    lower = np.linalg.cholesky((p + np.swapaxes(p, -1, -2)) / 2)
    step = np.linalg.solve(lower[1:], a[1:] @ lower[:-1])
    tau, chain = np.ones(steps), step
    for lag in range(1, steps):
        squares = (chain**2).sum((-1, -2)) / d
        tau[lag:] += squares
        tau[:-lag] += squares
        if squares.max() < 1e-14:
            break
        chain = step[lag:] @ chain[:-1]
    return tau


def _transitions(transitions: Any, covariances: Any) -> tuple[Floats, Floats]:
    a, p = _check.floats("transitions", transitions), _check.floats("covariances", covariances)
    if p.ndim != 3 or p.shape[1] != p.shape[2]:
        raise errors.shape("covariances", p.shape, "(K, d, d)")
    if a.shape != p.shape:
        raise errors.shape("transitions", a.shape, str(p.shape))
    unfair = np.argwhere(~np.isfinite(a[1:]))
    if unfair.size:
        k, i, j = (int(x) for x in unfair[0])
        raise errors.not_finite("transitions", [k + 1, i, j], a[k + 1, i, j])
    nees_check(np.zeros(p.shape[:-1]), p, "errors", "covariances")
    return a, p


def correlation_time(values: Any) -> float:
    """How many values of a sequence count as one, from the sequence itself.

    Geyer's initial monotone sequence: autocorrelations are added in neighbouring pairs for as long
    as the sum of a pair is positive, and no pair counts for more than the one before.

    Parameters
    ----------
    values : array_like of shape (K,)
        Any stationary sequence; NEES is best given as normal scores.

    Returns
    -------
    float
        At least 1: what a mean's variance is multiplied by. 1 for independent values.

    Raises
    ------
    ValueError
        Where a value is not finite.

    References
    ----------
    Geyer, "Practical Markov chain Monte Carlo", Statistical Science 7(4), 1992,
    doi:10.1214/ss/1177011137.

    Examples
    --------
    >>> import numpy as np
    >>> correlation_time(np.repeat([1.0, -1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0], 8)) > 5
    True
    """
    x = np.atleast_1d(_check.floats("values", values)).ravel()
    unfair = np.flatnonzero(~np.isfinite(x))
    if unfair.size:
        raise errors.not_finite("values", [int(unfair[0])], x[unfair[0]])
    return float(correlation_times([x])[0])


def correlation_times(sequences: Sequence[Floats]) -> Floats:
    """The :func:`correlation_time` of each of many sequences of finite values."""
    times = np.ones(len(sequences))
    classes: dict[int, list[int]] = {}
    for i, values in enumerate(sequences):
        if len(values) >= 4 and values.min() < values.max():
            # Those of a similar length share one transform, padded to a power of two.
            classes.setdefault((len(values) - 1).bit_length(), []).append(i)
    for power, members in classes.items():
        lengths = np.array([len(sequences[i]) for i in members])
        padded = np.zeros((len(members), 1 << power))
        for row, i in zip(padded, members, strict=True):
            row[: len(sequences[i])] = sequences[i] - sequences[i].mean()
        times[members] = _monotone_times(padded, lengths)
    return times


NEAR = 16
"""Lags after which most sequences have forgotten, summed without a transform."""


def _monotone_times(padded: Floats, lengths: NDArray[np.int64]) -> Floats:
    """Geyer's initial monotone sequence of each row: centred values with zeros behind."""
    size = padded.shape[1]
    near = min(NEAR, size)
    covariance = [np.einsum("kt,kt->k", padded[:, : size - d], padded[:, d:]) for d in range(near)]
    times, ended = _sums_of_pairs(np.stack(covariance, axis=1), lengths)
    if not ended.all():
        spectrum = np.fft.rfft(padded[~ended], 2 * size)
        covariances = np.fft.irfft(spectrum.real**2 + spectrum.imag**2)[:, :size]
        times[~ended], _ = _sums_of_pairs(covariances, lengths[~ended])
    return times


def _sums_of_pairs(
    covariances: Floats, lengths: NDArray[np.int64]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Times from the autocovariances of the first lags, and whether they were enough."""
    pairs = (covariances[:, ::2] + covariances[:, 1::2]) / covariances[:, :1]
    inside = np.arange(1, covariances.shape[1], 2) < lengths[:, None]
    counted = np.logical_and.accumulate((pairs > 0) & inside, axis=1)
    total = np.where(counted, np.minimum.accumulate(pairs, axis=1), 0.0).sum(axis=1)
    times: Floats = np.maximum(1.0, 2 * total - 1)
    return times, ~counted[:, -1] | (lengths <= covariances.shape[1])


@_deprecated.parameters(df="dof")
def nees_over_time(
    nees_values: Any,
    dof: float,
    *,
    transitions: Any = None,
    covariances: Any = None,
    confidence: float = 0.95,
) -> MeanTest:
    """NEES of one run averaged over time, with an interval that knows it is correlated.

    The sum has mean d K and variance 2 d sum_k tau_k, and is taken as g chi2(h).

    Parameters
    ----------
    nees_values : array_like of shape (..., K)
        NEES of consecutive updates of one run; leading axes are tested one by one.
    dof : float
        Number of states d.
    transitions, covariances : array_like of shape (K, d, d), optional
        As in :func:`nees_correlation_time`. Without them tau is estimated from the values
        themselves (:func:`correlation_time` of their normal scores), which is less reliable.
    confidence : float
        Probability that a consistent filter passes.

    Returns
    -------
    MeanTest
        1 is consistent; ``dof`` are the degrees of freedom that are left.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        As :func:`anees` and :func:`nees_correlation_time`; where only one of ``transitions`` and
        ``covariances`` is given.

    Notes
    -----
    Taking the values as independent rejects consistent filters in 14-23 % of runs where 5 % are
    nominal.

    Examples
    --------
    >>> import numpy as np
    >>> a, p = np.full((4, 1, 1), 0.5), np.ones((4, 1, 1))
    >>> test = nees_over_time([1.0, 2.0, 0.5, 0.5], 1, transitions=a, covariances=p)
    >>> test.value, round(test.dof, 3)
    (1.0, 2.768)
    """
    values = statistics("nees_values", nees_values)
    degrees_of_freedom = degrees(dof, values.shape)
    if (transitions is None) != (covariances is None):
        raise ValueError("transitions and covariances must be given together")
    if transitions is None:
        scores = _normal_scores(values, degrees_of_freedom)
        rows = scores.reshape(-1, scores.shape[-1])
        tau = correlation_times(list(rows)).reshape(scores.shape[:-1])[..., None]
    else:
        tau = nees_correlation_time(transitions, covariances)
        if len(tau) != values.shape[-1]:
            count = values.shape[-1]
            raise errors.length("transitions", len(tau), "nees_values", count, "steps")
    variance = 2 * (degrees_of_freedom * tau).sum(-1)
    return mean_test(values.sum(-1), degrees_of_freedom.sum(-1), variance, confidence)


def _normal_scores(values: Floats, dof: Floats) -> Floats:
    """Standard normal values of the same rank in their distribution, after a common scale."""
    scale = values.sum(-1, keepdims=True) / dof.sum(-1, keepdims=True)
    scale = np.maximum(scale, np.finfo(float).tiny)
    return _distributions.chi2_to_z(values / scale, dof)


def decorrelated_nees(errors: Any, covariances: Any, transitions: Any) -> DecorrelatedNEES:
    """NEES of what each update adds to the error: independent along one run.

        d_k = e_k - A_k e_(k-1),    D_k = P_k - A_k P_(k-1) A_k',    d_k' D_k^+ d_k ~ chi2(rank D_k)

    Parameters
    ----------
    errors : array_like of shape (..., K, d)
        Errors of consecutive updated states; leading axes are runs of the same filter.
    covariances : array_like of shape (K, d, d)
        Updated covariances P_k.
    transitions : array_like of shape (K, d, d)
        ``A_k = (I - K_k H_k) F_k``; the first is not used.

    Returns
    -------
    DecorrelatedNEES
        Values of shape (..., K), about ``dof`` each; the first is the NEES of the first error.
        Their sum is an exact test of one run (see :func:`average_nis`).

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        Where shapes do not fit, an error is not finite, or a covariance is not symmetric and
        positive definite.

    Notes
    -----
    Directions in which an update adds nothing are left out of D_k and of its rank. A transition
    that does not belong to the covariances gives a D_k that is no covariance; its negative
    directions are left out too.

    Examples
    --------
    >>> import numpy as np
    >>> result = decorrelated_nees([[1.0], [1.5]], np.ones((2, 1, 1)), np.full((2, 1, 1), 0.6))
    >>> result.values.round(4), result.dof
    (array([1.    , 1.2656]), array([1, 1]))
    """
    a, p = _transitions(transitions, covariances)
    e = _check.floats("errors", errors)
    if e.shape[-2:] != p.shape[:2]:
        raise _misshapen(e.shape, p.shape)
    nees_check(e, np.broadcast_to(p, (*e.shape[:-2], *p.shape)).copy(), "errors", "covariances")
    added, d = np.array(p), np.array(e)
    added[1:] -= a[1:] @ p[:-1] @ np.swapaxes(a[1:], -1, -2)
    d[..., 1:, :] -= np.einsum("kij,...kj->...ki", a[1:], e[..., :-1, :])
    values, ranks = _rank_revealing(d, added, np.sqrt(np.diagonal(p, axis1=-2, axis2=-1)))
    return DecorrelatedNEES(values, ranks)


def _misshapen(found: tuple[int, ...], expected: tuple[int, ...]) -> ValueError:
    return errors.shape("errors", found, f"(..., {expected[0]}, {expected[1]})")


def _rank_revealing(d: Floats, matrices: Floats, units: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Quadratic forms over the directions with a variance above rounding, in units of their own."""
    scaled = matrices / (units[..., :, None] * units[..., None, :])
    variances, directions = np.linalg.eigh((scaled + np.swapaxes(scaled, -1, -2)) / 2)
    live = variances > 1e-9
    components = np.einsum("kij,...ki->...kj", directions, d / units)
    squares = components**2 / np.where(live, variances, np.inf)
    return squares.sum(-1), live.sum(-1)
