"""Faults that no factor on the noises explains: each as a model of its own, with its likelihood.

A fault is judged twice: beside the claimed noises alone, where it competes with the factors for the
better explanation (by the Bayesian information criterion), and beside the best factors, where its
likelihood ratio says whether these leave something unexplained.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import comb, log

import numpy as np
from numpy.typing import NDArray

from trackmetrics.diagnostics._noise_fit import (
    NEAR,
    ErrorModel,
    Fit,
    Floats,
    Integers,
    chi_square_tail,
    maximise,
)

BLOCKS = 10
"""Into so many parts a track is cut when a change in time is sought."""
CHUNK = 20_000
"""How many updates are looked at together for a change in time."""
CORRELATIONS = (-0.6, -0.3, 0.3, 0.5, 0.7, 0.85, 0.95)
"""Correlations of consecutive measurement noises that are tried."""
MEASURED_AS_STATE = 1e-4
"""Fraction of a measurement noise that stays where the noise is a set of states."""
OUTLIER_LEVEL = 0.01
"""Probability of an outlier in a log without any."""
MOST_OUTLIERS = 0.15
"""Largest fraction of updates that are outliers; beyond, they are the noise."""
ROBUST_DOF = 5.0
"""Degrees of freedom of Student's t distribution for estimates that outliers hardly move."""


@dataclass(frozen=True)
class Fault:
    """A fault, and how much better the log is explained with it."""

    reason: str
    """``"bias"``, ``"outliers"``, ``"manoeuvre"``, ``"correlated noise"`` or
    ``"changing noise"``."""
    detail: str
    """What is known of it."""
    gain: float
    """Twice the log-likelihood that it adds to the claimed noises, less what its parameters cost
    by the Bayesian information criterion."""
    p_value: float
    """Probability of so large a gain over the best factors if there is no such fault."""


@dataclass(frozen=True)
class Baseline:
    """The claims and the best factors, that every fault is compared with."""

    model: ErrorModel
    claimed: float
    """Log-likelihood of the claimed noises."""
    fit: Fit

    @property
    def size(self) -> float:
        """How many components of innovations there are."""
        return float((~np.isnan(self.model.innovations)).sum())

    def fault(
        self,
        reason: str,
        detail: str,
        claimed: float,
        fitted: float,
        dof: int,
        choices: float,
    ) -> Fault:
        """A fault of so many parameters, the best of so many that were tried."""
        gain = 2 * (claimed - self.claimed) - dof * log(self.size) - 2 * log(choices)
        statistic = 2 * (fitted - self.fit.value)
        p_value = min(1.0, choices * chi_square_tail(statistic, dof))
        return Fault(reason, detail, gain, p_value)


def faults(model: ErrorModel, fit: Fit) -> list[Fault]:
    """The best fault of each kind."""
    base = Baseline(model, model.likelihood(np.ones(model.count)), fit)
    kinds = (_biases(base), _outliers(base), _changes(base), _correlations(base))
    return [fault for kind in kinds for fault in kind]


# Bias ------------------------------------------------------------------------------------------


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
    larger = _augmented(model, H, np.eye(e), np.zeros((e, e)), prior)
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


def _augmented(model: ErrorModel, H: Floats, F: Floats, Q: Floats, initial: Floats) -> ErrorModel:
    """The model with further states, that move by ``F`` with noise ``Q`` (which the last group of
    process noise holds); ``F`` and ``Q`` of all rows, or one of each row."""
    rows, n, e = len(model.H), model.H.shape[2], H.shape[2]
    larger = np.zeros((rows, n + e, n + e))
    larger[:, :n, :n], larger[:, n:, n:] = model.F, F
    groups = model.Q.shape[1]
    noises = np.zeros((rows, groups, n + e, n + e))
    noises[:, :, :n, :n] = model.Q
    if np.any(Q):
        extra = np.zeros((rows, 1, n + e, n + e))
        extra[:, 0, n:, n:] = Q
        noises = np.concatenate([noises, extra], axis=1)
    start = np.zeros((len(model.initial), n + e, n + e))
    start[:, :n, :n], start[:, n:, n:] = model.initial, initial
    corrections = np.pad(model.corrections, [(0, 0), (0, e)])
    return replace(
        model, H=np.concatenate([model.H, H], axis=2), F=larger, Q=noises, initial=start,
        corrections=corrections,
        process=model.process + (("added",) if np.any(Q) else ()),
    )  # fmt: skip


# Outliers --------------------------------------------------------------------------------------


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


# Changes in time -------------------------------------------------------------------------------


def _changes(base: Baseline) -> Iterator[Fault]:
    """Process noise, or noise of one measurement type, with another factor in a part of the track:
    of the part with the largest score."""
    model = base.model
    blocks = _blocks(model)
    most = int(blocks.max()) + 1
    if most < 3:
        return
    gradient, information = _scores_by_block(model, base.fit, blocks, most)
    groups = len(model.process)
    whole: Floats = np.kron(np.eye(model.count), np.ones((most, 1))).astype(np.float64)
    choices = most * (most + 1) // 2
    kinds = [tuple(range(groups))] + [(groups + t,) for t in range(len(model.measurement))]
    for kind in kinds:
        window = _best_window(gradient, information, whole, kind, most)
        if window is None:
            continue
        rows = (blocks >= window[0]) & (blocks < window[1])
        yield _change(base, rows, kind, window, most, choices * len(kinds) / 3)


def _blocks(model: ErrorModel) -> Integers:
    """The part of its track to which each row belongs."""
    lengths = np.diff(model.starts)
    most = int(np.clip(lengths.max() // 5, 1, BLOCKS))
    parts = [np.arange(length) * most // max(length, 1) for length in lengths]
    return np.concatenate(parts)


def _scores_by_block(
    model: ErrorModel, fit: Fit, blocks: Integers, most: int
) -> tuple[Floats, Floats]:
    """Score and information of each factor in each part, over some tracks at a time: every part
    needs process noises of its own."""
    factors = np.repeat(fit.factors, most)
    gradient, information = np.zeros(len(factors)), np.zeros((len(factors), len(factors)))
    first = 0
    while first < len(model.starts) - 1:
        last = int(np.searchsorted(model.starts, model.starts[first] + CHUNK, "right")) - 1
        last = max(last, first + 1)
        rows = slice(int(model.starts[first]), int(model.starts[last]))
        split = _by_block(model.tracks(first, last), blocks[rows], most)
        _, gradients, informations = split.evaluate(factors)[:3]
        gradient += gradients.sum(0)[:-1]
        information += informations.sum(0)[:-1, :-1]
        first = last
    return gradient, information


def _by_block(model: ErrorModel, blocks: Integers, most: int) -> ErrorModel:
    """The model with each factor once for each part of the tracks."""
    own = (blocks[:, None] == np.arange(most)).astype(float)
    Q = (model.Q[:, :, None] * own[:, None, :, None, None]).reshape(
        len(blocks), -1, *model.Q.shape[2:]
    )
    names = tuple(f"{name} {b}" for name in model.process for b in range(most))
    types = model.types * most + blocks
    kinds = tuple(f"{name} {b}" for name in model.measurement for b in range(most))
    return replace(model, Q=Q, process=names, types=types, measurement=kinds)


def _best_window(
    gradient: Floats, information: Floats, whole: Floats, kind: tuple[int, ...], most: int
) -> tuple[int, int] | None:
    """The part with the largest score of another factor in it, the factors of all being free."""
    best, found = 0.0, None
    base = whole.T @ information @ whole + 1e-12 * np.eye(whole.shape[1])
    for a in range(most):
        for b in range(a + 1, most + 1):
            if b - a == most:
                continue
            w = np.zeros(len(gradient))
            for k in kind:
                w[k * most + a : k * most + b] = 1.0
            shared = whole.T @ information @ w
            own = float(w @ information @ w - shared @ np.linalg.solve(base, shared))
            if own > 1e-9 * (w @ information @ w):
                score = abs(float(w @ gradient)) / own**0.5
                if score > best:
                    best, found = score, (a, b)
    return found


def _change(
    base: Baseline, rows: NDArray[np.bool_], kind: tuple[int, ...], window: tuple[int, int],
    most: int, choices: float,
) -> Fault:  # fmt: skip
    model, groups = base.model, len(base.model.process)
    process = kind[0] < groups
    if process:
        total = model.Q.sum(axis=1, keepdims=True) * rows[:, None, None, None]
        Q = np.concatenate([model.Q * ~rows[:, None, None, None], total], axis=1)
        changed = replace(model, Q=Q, process=(*model.process, "changed"))
        place = groups
    else:
        types = np.where(
            rows & (model.types == kind[0] - groups), model.count - groups, model.types
        )
        changed = replace(model, types=types, measurement=(*model.measurement, "changed"))
        place = model.count
    start = np.insert(base.fit.factors, place, base.fit.factors[kind[0]])
    found = maximise(changed, start, tolerance=NEAR)
    ones = np.ones(changed.count)
    fixed = [i for i in range(changed.count) if i != place]
    alone = maximise(changed, ones, fixed, NEAR)
    part = f"{100 * window[0] // most} to {100 * window[1] // most} % of the track"
    if process:
        ratio = found.factors[place] / max(found.factors[0], 1e-9)
        more = "more" if ratio > 1 else "less"
        detail = f"the target moves {more} than elsewhere at {part}"
        reason = "manoeuvre"
    else:
        name = model.measurement[kind[0] - groups]
        detail = f"the noise of {name} differs at {part}"
        reason = "changing noise"
    return base.fault(reason, detail, alone.value, found.value, 1, choices)


# Correlated measurement noise ------------------------------------------------------------------


def _correlations(base: Baseline) -> Iterator[Fault]:
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
    return replace(_augmented(model, H, np.eye(e), np.eye(e), start), R=R), e


def _correlated(larger: ErrorModel, kind: int, added: int, rho: float) -> ErrorModel:
    """The model whose last ``added`` states, the noise of one type, keep the correlation ``rho``
    from one measurement of this type to the next."""
    n = larger.H.shape[2] - added
    rows = (larger.types == kind)[:, None, None]
    F, Q = larger.F.copy(), larger.Q.copy()
    F[:, n:, n:] = np.where(rows, rho * np.eye(added), np.eye(added))
    Q[:, -1, n:, n:] = np.where(rows, (1 - rho**2) * np.eye(added), 0.0)
    return replace(larger, F=F, Q=Q)
