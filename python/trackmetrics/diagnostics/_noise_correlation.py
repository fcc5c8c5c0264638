"""Measurement noise that is correlated from one measurement of a sensor to the next."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trackmetrics.diagnostics._noise_baseline import Baseline, Fault, augmented
from trackmetrics.diagnostics._noise_fit import NEAR, ErrorModel, Fit, Floats, maximise

CORRELATIONS = (-0.6, -0.3, 0.3, 0.5, 0.7, 0.85, 0.95)
"""Correlations of consecutive measurement noises that are tried."""
MEASURED_AS_STATE = 1e-4
"""Fraction of a measurement noise that stays where the noise is a set of states."""


def correlations(base: Baseline) -> Iterator[Fault]:
    """Measurement noise of one type that follows a first-order autoregression."""
    model = base.model
    for kind, name in enumerate(model.measurement):
        if (model.types == kind).sum() < 8:
            continue
        place = len(model.process)
        start = np.insert(base.fit.factors, place, base.fit.factors[place + kind])
        larger, added = _with_noise_states(model, kind)
        claims, fits = np.empty(len(CORRELATIONS)), np.empty(len(CORRELATIONS))
        for i, rho in enumerate(CORRELATIONS):
            tried = _correlated(larger, kind, added, rho)
            claims[i] = tried.likelihood(np.ones(larger.count))
            fits[i] = tried.likelihood(start)
        best, found = _best_correlation(larger, kind, added, start, claims, fits)
        detail = f"the noise of {name} is correlated from update to update (about {best})"
        yield base.fault(
            "correlated noise", detail, float(claims.max()), found.value, 1,
            3.0 * len(model.measurement),
        )  # fmt: skip


def _best_correlation(
    larger: ErrorModel, kind: int, added: int, start: Floats, claims: Floats, fits: Floats
) -> tuple[float, Fit]:
    """The correlation of the largest likelihood with free factors, among the two most promising."""
    best: tuple[float, Fit] | None = None
    for i in {int(np.argmax(claims)), int(np.argmax(fits))}:
        rho = CORRELATIONS[i]
        found = maximise(_correlated(larger, kind, added, rho), start, tolerance=NEAR)
        if best is None or found.value > best[1].value:
            best = rho, found
    assert best is not None
    return best


def _with_noise_states(model: ErrorModel, kind: int) -> tuple[ErrorModel, int]:
    """The model in which the noise of one type is a set of states, and how many these are; its
    factor is that of the last group of process noise."""
    rows = model.types == kind
    used = np.flatnonzero((~np.isnan(model.innovations[rows])).any(axis=0))
    e = len(used)
    own = model.R[rows][:, used[:, None], used]
    there = own.diagonal(axis1=1, axis2=2) > 0
    roots = np.linalg.cholesky(np.where(there[:, :, None] & there[:, None, :], own, np.eye(e)))
    H = np.zeros((*model.H.shape[:2], e))
    H[np.ix_(np.flatnonzero(rows), used, np.arange(e))] = np.where(there[:, :, None], roots, 0.0)
    R = np.where(rows[:, None, None], MEASURED_AS_STATE * model.R, model.R)
    start = np.eye(e) / model.initial_factor
    return replace(augmented(model, H, np.eye(e), np.eye(e), start), R=R), e


def _correlated(larger: ErrorModel, kind: int, added: int, rho: float) -> ErrorModel:
    """The model whose last ``added`` states, the noise of one type, keep the correlation ``rho``
    from one measurement of this type to the next."""
    n = larger.H.shape[2] - added
    rows = (larger.types == kind)[:, None, None]
    F, Q = larger.F.copy(), larger.Q.copy()
    F[:, n:, n:] = np.where(rows, rho * np.eye(added), np.eye(added))
    Q[:, -1, n:, n:] = np.where(rows, (1 - rho**2) * np.eye(added), 0.0)
    return replace(larger, F=F, Q=Q)
