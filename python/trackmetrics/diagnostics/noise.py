"""What the process noise and the measurement noise of a filter should be, from its log alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, log, nan

import numpy as np

from trackmetrics.diagnostics._noise_baseline import Fault
from trackmetrics.diagnostics._noise_direction import direction
from trackmetrics.diagnostics._noise_faults import ROBUST_DOF, faults, outlying
from trackmetrics.diagnostics._noise_fit import (
    ErrorModel,
    Fit,
    Floats,
    Profile,
    chi_square_tail,
    maximise,
)
from trackmetrics.diagnostics._noise_model import (
    LinearModel,
    LogModel,
    NotEnoughError,
    log_model,
)
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.results import Result

ALARM = 0.01
"""Probability that a change is advised for a consistent filter."""
UNEXPLAINED = 0.001
"""Probability, under the best factors, of a fault as significant as one that is reported."""


_NOTABLE = {
    "bias": 0.5,
    "outliers": 0.5,
    "correlated noise": 0.5,
    "manoeuvre": 0.01,
    "changing noise": 0.01,
}
"""p-value, under the best factors, above which a fault is no better explanation than they are. A
change in time can imitate a wrong factor, and must be seen beside it."""


@dataclass(frozen=True)
class Factor(Result):
    """By what a claimed noise covariance must be multiplied."""

    factor: float
    """Best factor: 1 where the claim is right, 4 where the true standard deviation is twice the
    claimed; NaN where the log does not tell."""
    interval: tuple[float, float]
    """Profile-likelihood confidence interval; 0 or infinity where there is no bound."""
    p_value: float
    """p-value of "the factor is 1"; NaN where the log does not tell."""

    @property
    def identifiable(self) -> bool:
        """Whether the log tells the factor."""
        return isfinite(self.factor)


@dataclass(frozen=True)
class NoiseEstimate(Result):
    """What the noises should be, how sure that is, and whether any noises explain the log."""

    process: Mapping[str, Factor]
    """Factor of each group of process noise; ``"all"`` where there is one."""
    measurement: Mapping[str, Factor]
    """Factor of each measurement type."""
    statistic: float
    """Twice the log-likelihood ratio of the best factors to the claimed noises."""
    dof: int
    """Degrees of freedom of its chi-square distribution if no change is needed."""
    p_value: float
    """p-value of "no change is needed"."""
    log_likelihood_gain: float
    """Log-likelihood of the best factors minus that of the claimed noises."""
    explained: bool
    """Whether the best factors make the log consistent."""
    reason: str | None
    """What no factors explain: ``"bias"``, ``"outliers"``, ``"angle"``, ``"correlated noise"``,
    ``"manoeuvre"`` or ``"changing noise"``; None if ``explained``."""
    detail: str | None
    """The same in a sentence."""
    identifiable: Mapping[str, bool]
    """Of each factor (``"process all"``, ``"measurement radar"``) whether the log tells it."""
    grade: str
    """``"exact"``, or ``"direction"`` where the log holds too little for a number."""
    direction: str | None
    """For grade ``"direction"``: which noise is too small or too large, if that is significant."""
    disagreeing: Mapping[str, float]
    """Tracks whose own factors differ from these, and the p-values (Holm)."""
    updates: int
    """How many updates went in."""
    confidence: float
    """Confidence of the intervals."""

    @property
    def causes(self) -> tuple[str, ...]:
        """The factors to change, the most significant first; empty where none is or where no
        factors explain the log."""
        if not self.explained or not self.p_value < ALARM:
            return ()
        known = {n: f.p_value for n, f in self._named().items() if f.identifiable}
        ranked = sorted(known, key=known.__getitem__)
        return tuple(n for i, n in enumerate(ranked) if i == 0 or known[n] < UNEXPLAINED)

    def _named(self) -> dict[str, Factor]:
        return {
            **{f"process {name}": factor for name, factor in self.process.items()},
            **{f"measurement {name}": factor for name, factor in self.measurement.items()},
        }

    def __repr__(self) -> str:
        """The estimate in sentences."""
        return "\n".join(_sentences(self))


def estimate_noise(
    log: EstimatorLog,
    *,
    process: str | Mapping[str, Sequence[str | int]] = "all",
    measurement: str = "by_type",
    confidence: float = 0.95,
    robust: bool = False,
    model: LinearModel | None = None,
) -> NoiseEstimate:
    """Estimate by which factors the claimed process and measurement noises must be multiplied.

    The innovations of a linear filter follow from the initial error, the process noise and the
    measurement noise with the filter's own gains. Their exact likelihood under other noises is
    therefore known from the log, without running the filter again; the factors maximise it.

    Parameters
    ----------
    log
        With innovations, ``S``, ``A``, ``P_pred`` (or ``P`` and ``R``), and ``H`` or ``observed``.
        With ``x`` and ``x_pred`` the filter may have any gain; otherwise it is taken to be
        ``P_pred H' S^-1``. With innovations and ``S`` alone the answer is a direction.
    process
        ``"all"`` for one factor on all process noise; ``"by_block"`` for a factor for each set of
        states that share process noise; or a dictionary of the states in each group.
    measurement
        ``"by_type"`` for a factor for each measurement type, ``"all"`` for one factor.
    confidence
        Confidence of the intervals.
    robust
        Whether clear outliers are set aside, and the other innovations given Student's t
        distribution with 5 degrees of freedom, so that they do not count as measurement noise.
    model
        ``F`` and ``H`` where the log lacks ``A`` or ``H``, as arrays or functions.

    Returns
    -------
    NoiseEstimate
        Factors with intervals and p-values; 1 is right, above 1 the noise is larger than claimed.

    Raises
    ------
    ValueError
        If the log holds no innovations; ``P_pred`` is smaller than what ``A`` and ``P`` give; a
        state of ``process`` is unknown, in two groups, or shares noise with another group.

    Notes
    -----
    The initial error of each track is taken to be unknown (a hundred times the claimed standard
    deviations), so that a wrong initial covariance does not count as noise. Rows that are
    tentative, and rows without ``A`` or ``P_pred``, are left out and the track starts anew behind
    them. A factor of process noise may be 0, where its likelihood ratio follows half a chi-square.

    Intervals hold where a linear model describes the errors; for an extended Kalman filter as far
    as its Jacobians do.

    References
    ----------
    R. Mehra (1970), On the identification of variances and adaptive Kalman filtering,
    doi:10.1109/TAC.1970.1099422. J. Dunik et al. (2017), Noise covariance matrices in state-space
    models: a survey and comparison of estimation methods, doi:10.1002/acs.2783.

    Examples
    --------
    A random walk with steps of variance 1, measured with variance 4; the filter claims 1 and 1.

    >>> import numpy as np
    >>> from trackmetrics.logs import EstimatorLog
    >>> rng = np.random.default_rng(0)
    >>> truth = np.cumsum(rng.normal(size=100))
    >>> x, P, rows = 0.0, 10.0, []
    >>> for z in truth + 2 * rng.normal(size=100):
    ...     P_pred = P + 1
    ...     S = P_pred + 1
    ...     K, nu = P_pred / S, z - x
    ...     x, P = x + K * nu, (1 - K) * P_pred
    ...     rows.append(([nu], [[S]], [[P_pred]], [[P]], [[1 - K]]))
    >>> innovation, S, P_pred, P, A = zip(*rows)
    >>> log = EstimatorLog.from_columns(
    ...     states=["s"], innovation=innovation, S=S, P_pred=P_pred, P=P, A=A,
    ...     H=[[[1.0]]] * 100, measurement_type=["radar"] * 100)
    >>> found = estimate_noise(log)
    >>> found.causes
    ('measurement radar',)
    >>> low, high = found.measurement["radar"].interval
    >>> low < 4 < high
    True
    """
    if not 0 < confidence < 1:
        raise ValueError(f"confidence must be between 0 and 1, got {confidence!r}")
    try:
        found = log_model(log, process, measurement, model)
    except NotEnoughError as lack:
        return _direction_only(log, confidence, str(lack))
    errors = _robust(found.errors) if robust else found.errors
    fit = maximise(errors)
    claimed = errors.likelihood(np.ones(errors.count))
    factors = _factors(errors, fit, confidence)
    ratio = errors.tail[1]
    statistic = max(0.0, 2 * (fit.value - claimed) / ratio)
    reported = [f for f in factors if f.identifiable]
    p_value = chi_square_tail(statistic, len(reported)) if reported else nan
    fault = _fault(found, robust, statistic, p_value)
    split = len(errors.process)
    names = [f"process {n}" for n in errors.process] + [
        f"measurement {n}" for n in errors.measurement
    ]
    return NoiseEstimate(
        process=dict(zip(errors.process, factors[:split], strict=True)),
        measurement=dict(zip(errors.measurement, factors[split:], strict=True)),
        statistic=statistic,
        dof=len(reported),
        p_value=p_value,
        log_likelihood_gain=fit.value - claimed,
        explained=fault is None,
        reason=None if fault is None else fault[0],
        detail=None if fault is None else fault[1],
        identifiable={n: f.identifiable for n, f in zip(names, factors, strict=True)},
        grade="exact",
        direction=None,
        disagreeing=_disagreeing(found, errors, fit),
        updates=int((~np.isnan(errors.innovations)).any(axis=1).sum()),
        confidence=confidence,
    )


def _robust(errors: ErrorModel) -> ErrorModel:
    """The model without clear outliers, and with Student's t distribution for the others."""
    rest = errors.without(outlying(errors, np.ones(errors.count)))
    return replace(rest, tail_dof=ROBUST_DOF)


def _factors(errors: ErrorModel, fit: Fit, confidence: float) -> list[Factor]:
    factors = []
    for i in range(errors.count):
        profile = Profile(errors, fit, i)
        interval = profile.interval(confidence)
        known = interval[0] > 0 or isfinite(interval[1])
        value = float(fit.factors[i]) if known else nan
        factors.append(Factor(value, interval, profile.p_value(1.0) if known else nan))
    return factors


def _fault(
    found: LogModel, robust: bool, statistic: float, p_value: float
) -> tuple[str, str] | None:
    """The fault that the best factors leave unexplained, or that explains the log better."""
    if found.unwrapped.any():
        count = int(found.unwrapped.sum())
        return "angle", f"the filter used {count} residuals of an angle beyond half its period"
    errors = found.errors
    if robust:
        errors = errors.without(outlying(errors, np.ones(errors.count)))
    fit = maximise(errors)
    listed = faults(errors, fit)
    if not listed:
        return None
    size = float((~np.isnan(errors.innovations)).sum())
    return _verdict(listed, statistic - errors.count * log(size), p_value)


def _verdict(listed: Sequence[Fault], gain: float, p_value: float) -> tuple[str, str] | None:
    """A fault that is significant beside the best factors, or, where a change seems needed, one
    that explains the log better than factors do."""
    significant = [f for f in listed if f.p_value < UNEXPLAINED]
    if significant:
        best = max(significant, key=lambda f: f.gain)
        return best.reason, best.detail
    better = [f for f in listed if f.gain > max(gain, 0.0) and f.p_value < _NOTABLE[f.reason]]
    if p_value < ALARM and better:
        best = max(better, key=lambda f: f.gain)
        return best.reason, best.detail
    return None


def _disagreeing(found: LogModel, errors: ErrorModel, fit: Fit) -> dict[str, float]:
    """Tracks whose scores at the common factors are significant, with p-values after Holm."""
    if len(set(found.tracks.tolist())) < 2:
        return {}
    _, gradients, informations = errors.evaluate(fit.factors)[:3]
    k, names, p_values = errors.count, [], []
    for t in sorted(set(found.tracks.tolist())):
        own = found.tracks == t
        score, information = gradients[own, :k].sum(0), informations[own, :k, :k].sum(0)
        statistic, dof = _score_statistic(score, information)
        names.append(found.names[t])
        p_values.append(chi_square_tail(statistic, dof) if dof else 1.0)
    order = np.argsort(p_values)
    held, kept = 0.0, {}
    for place, i in enumerate(order):
        held = max(held, min(1.0, p_values[i] * (len(names) - place)))
        if held < ALARM:
            kept[names[i]] = held
    return kept


def _score_statistic(score: Floats, information: Floats) -> tuple[float, int]:
    d = np.sqrt(np.maximum(information.diagonal(), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(d, d))
    known = (values > 1e-8) & (information.diagonal().max() > 0)
    parts = (vectors.T @ (score / d))[known] ** 2 / values[known]
    return float(parts.sum()), int(known.sum())


def _direction_only(log: EstimatorLog, confidence: float, lack: str) -> NoiseEstimate:
    """The estimate of a log that is too poor for a number."""
    if log.columns.innovation is None or log.columns.S is None:
        raise ValueError(f"{lack}; for a direction the log needs innovation and S")
    found = direction(log)
    return NoiseEstimate(
        process={}, measurement={}, statistic=nan, dof=0, p_value=found.p_value,
        log_likelihood_gain=nan, explained=found.cause is not None or found.p_value >= ALARM,
        reason=None, detail=lack, identifiable={}, grade="direction", direction=found.cause,
        disagreeing={}, updates=found.updates, confidence=confidence,
    )  # fmt: skip


def _sentences(estimate: NoiseEstimate) -> list[str]:
    if estimate.grade == "direction":
        said = estimate.direction or "no direction is significant"
        return [f"No number: {estimate.detail}.", f"Direction: {said}."]
    lines = [_sentence(f"process noise of {n}", f, estimate) for n, f in estimate.process.items()]
    lines += [
        _sentence(f"measurement noise of {n}", f, estimate) for n, f in estimate.measurement.items()
    ]
    lines.append(
        f"likelihood ratio {estimate.statistic:.1f} with {estimate.dof} degrees of freedom, "
        f"p = {estimate.p_value:.2g}, over {estimate.updates} updates"
    )
    if not estimate.explained:
        lines.append(f"no noise explains this log: {estimate.detail} ({estimate.reason})")
    elif estimate.causes:
        lines.append("change: " + ", ".join(estimate.causes))
    else:
        lines.append("no change is significant")
    if estimate.disagreeing:
        lines.append("tracks that disagree: " + ", ".join(estimate.disagreeing))
    return lines


def _sentence(noise: str, factor: Factor, estimate: NoiseEstimate) -> str:
    if not factor.identifiable:
        return f"{noise}: the log does not tell"
    low, high = factor.interval
    return (
        f"{noise}: {factor.factor:.3g} times the variance claimed "
        f"({100 * estimate.confidence:g} %: {low:.3g} to {high:.3g})"
    )
