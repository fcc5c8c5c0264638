"""Faults that no factor on the noises explains: bias, outliers, changes, correlated noise."""

from collections.abc import Iterator
from dataclasses import replace
from math import comb

import numpy as np
from numpy.typing import NDArray

from trackmetrics.diagnostics._noise_baseline import Baseline, Fault, augmented
from trackmetrics.diagnostics._noise_changes import changes
from trackmetrics.diagnostics._noise_correlation import correlations
from trackmetrics.diagnostics._noise_fit import NEAR, ErrorModel, Fit, Floats, Integers, maximise

OUTLIER_LEVEL = 0.01
"""Probability of an outlier in a log without any."""
MOST_OUTLIERS = 0.15
"""Largest fraction of updates that are outliers; beyond, they are the noise."""
HEAVY_DOF = 4.0
"""Degrees of freedom of Student's t distribution that stands for heavy tails."""
ROBUST_DOF = 5.0
"""Degrees of freedom of Student's t distribution for estimates that outliers hardly move."""


def faults(model: ErrorModel, fit: Fit) -> list[Fault]:
    """The best fault of each kind."""
    base = Baseline(model, model.likelihood(np.ones(model.count)), fit)
    kinds = (_biases(base), _outliers(base), _heavy_tails(base), changes(base), correlations(base))
    return [fault for kind in kinds for fault in kind]


def _biases(base: Baseline) -> Iterator[Fault]:
    """A constant offset of one measurement type."""
    for kind, name in enumerate(base.model.measurement):
        claimed = _offset(base.model, kind, np.ones(base.model.count))
        fitted = _offset(base.model, kind, base.fit.factors)
        if claimed is None or fitted is None:
            continue
        shifted = _shifted(base.model, kind, fitted[0])
        found = maximise(shifted, base.fit.factors, tolerance=NEAR)
        value = max(found.value, base.fit.value + fitted[1] / 2)
        listed = ", ".join(f"{v:.4g}" for v in fitted[0][: fitted[2]])
        detail = f"the innovations of {name} have a mean offset of {listed}"
        yield base.fault(
            "bias", detail, base.claimed + claimed[1] / 2, value,
            claimed[2], len(base.model.measurement),
        )  # fmt: skip


def _shifted(model: ErrorModel, kind: int, offset: Floats) -> ErrorModel:
    rows = (model.types == kind)[:, None]
    return replace(model, innovations=np.where(rows, model.innovations - offset, model.innovations))


def _offset(model: ErrorModel, kind: int, factors: Floats) -> tuple[Floats, float, int] | None:
    """The best constant offset of a measurement type, its likelihood ratio and how many of its
    components can be told from an error of the states; None if none can."""
    rows = model.types == kind
    used = np.flatnonzero((~np.isnan(model.innovations[rows])).any(axis=0))
    n, e = model.H.shape[2], len(used)
    variances = model.R[rows][:, used, used].mean(axis=0)
    H = np.zeros((*model.H.shape[:2], e))
    H[np.ix_(np.flatnonzero(rows), used, np.arange(e))] = np.eye(e)
    prior = np.diag(100.0 * variances / model.initial_factor)
    larger = augmented(model, H, np.eye(e), np.zeros((e, e)), prior)
    means, covariances = larger.evaluate(factors, False)[4:]
    precision, score = np.zeros((e, e)), np.zeros(e)
    scale = np.sqrt(np.outer(variances, variances))
    for mean, covariance in zip(means, covariances, strict=True):
        own = np.linalg.inv(covariance[n:, n:] / scale)
        precision += own - np.eye(e) / 100.0
        score += own @ (mean[n:] / np.sqrt(variances))
    values, vectors = np.linalg.eigh((precision + precision.T) / 2)
    known = values > 1.0
    if not known.any():
        return None
    basis = vectors[:, known]
    best = basis @ ((basis.T @ score) / values[known])
    offset = np.zeros(model.innovations.shape[1])
    offset[used] = best * np.sqrt(variances)
    return offset, float(score @ best), int(known.sum())


def outlying(model: ErrorModel, start: Floats) -> NDArray[np.bool_]:
    """Rows whose innovation is far outside what a fit that outliers hardly move expects, alone
    among their neighbours."""
    from scipy import special

    robust = replace(model, tail_dof=ROBUST_DOF)
    fit = maximise(robust, start, tolerance=NEAR)
    whitened = robust.evaluate(fit.factors, False)[3]
    components = (~np.isnan(model.innovations)).sum(axis=1)
    tails = special.gammaincc(np.maximum(components, 1) / 2, (whitened**2).sum(axis=1) / 2)
    count = max(int((components > 0).sum()), 1)
    hits: NDArray[np.bool_] = (tails < OUTLIER_LEVEL / count) & (components > 0)
    return hits


def _outliers(base: Baseline) -> Iterator[Fault]:
    hits = outlying(base.model, base.fit.factors)
    count = int(hits.sum())
    isolated = hits & ~_beside(hits, base.model.starts)
    if not count or count > MOST_OUTLIERS * len(hits) or isolated.sum() < 0.7 * count:
        return
    rest = base.model.without(hits)
    found = maximise(rest, base.fit.factors, tolerance=NEAR)
    dof = int((~np.isnan(base.model.innovations[hits])).sum())
    choices = float(comb(len(hits), count))
    ones = np.ones(base.model.count)
    detail = f"{count} of {len(hits)} updates are outliers"
    claimed = rest.likelihood(ones) + _without_error(base.model, ones, hits)
    fitted = found.value + _without_error(base.model, found.factors, hits)
    yield base.fault("outliers", detail, claimed, fitted, dof, choices)


def _heavy_tails(base: Baseline) -> Iterator[Fault]:
    """Innovations of Student's t distribution: outliers too small to be seen one by one."""
    heavy = replace(base.model, tail_dof=HEAVY_DOF)
    found = maximise(heavy, base.fit.factors, tolerance=NEAR)
    detail = "the innovations have heavier tails than a normal distribution"
    claimed = heavy.likelihood(np.ones(base.model.count))
    yield base.fault("outliers", detail, claimed, found.value, 1, 1.0)


def _without_error(model: ErrorModel, factors: Floats, hits: NDArray[np.bool_]) -> float:
    """The log-density of these updates, if their innovations were as expected."""
    densities, _, _, whitened, _, _ = model.evaluate(factors, False)
    return float((densities + (whitened**2).sum(axis=1) / 2)[hits].sum())


def _beside(hits: NDArray[np.bool_], starts: Integers) -> NDArray[np.bool_]:
    """Rows with a hit in the row before or after, in one track."""
    first = np.zeros(len(hits), bool)
    first[starts[:-1][starts[:-1] < len(hits)]] = True
    after = np.concatenate([[False], hits[:-1]]) & ~first
    before = np.concatenate([(hits & ~first)[1:], [False]])
    beside: NDArray[np.bool_] = after | before
    return beside
