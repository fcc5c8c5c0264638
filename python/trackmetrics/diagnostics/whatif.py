"""What innovations and errors are under other noises, and after the filter is run again."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trackmetrics.diagnostics._noise_fit import ErrorModel, Floats, chi_square_tail
from trackmetrics.diagnostics._noise_model import LinearModel, log_model
from trackmetrics.diagnostics.noise import Factor
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.results import Result

Factors = float | Mapping[str, float | Factor]


@dataclass(frozen=True)
class WhatIf(Result):
    """A filter as it is and with other noises, if the true noises are these others."""

    nis_before: float
    """Mean NIS per degree of freedom of the log; 1 is expected of a consistent filter."""
    nis_expected: float
    """The same as it would be expected of the filter as it is, with its own gains, if the true
    noises are the claimed ones times the factors."""
    nis_after: float
    """Mean NIS per degree of freedom of the filter run again over the logged measurements with the
    noises multiplied."""
    p_value_before: float
    """Two-sided p-value of the NIS of the log."""
    p_value_after: float
    """Two-sided p-value of the NIS after the filter is run again."""
    innovation_std: Mapping[str, tuple[tuple[float, float], ...]]
    """Of each measurement type and component the claimed standard deviation of the innovation and
    the one expected under the factors (root mean squares over the updates)."""
    rmse: Mapping[str, tuple[float, float, float]]
    """Of each state the claimed standard deviation after an update, the RMSE expected of the filter
    as it is, and the RMSE expected of the filter with the noises multiplied."""
    updates: int
    """How many updates went in."""

    def __repr__(self) -> str:
        """The comparison in sentences."""
        lines = [
            f"NIS per degree of freedom: {self.nis_before:.3g} in the log, {self.nis_expected:.3g} "
            f"expected under these factors, {self.nis_after:.3g} after the filter is run again "
            f"(p = {self.p_value_after:.2g})"
        ]
        lines += [
            f"{state}: claimed {claimed:.3g}, RMSE {own:.3g} as it is, {again:.3g} run again"
            for state, (claimed, own, again) in self.rmse.items()
        ]
        return "\n".join(lines)


def whatif(
    log: EstimatorLog,
    *,
    process: Factors = 1.0,
    measurement: Factors = 1.0,
    model: LinearModel | None = None,
) -> WhatIf:
    """Predict what other noises change, before anyone edits a filter.

    Two questions are answered. If the true noises are the claimed ones times these factors, what
    are the NIS, the innovations and the errors of the filter as it is, with its own gains? And if
    the filter is run again over the logged measurements with the noises multiplied, what are they
    then?

    Parameters
    ----------
    log
        As :func:`estimate_noise` needs it for numbers.
    process
        Factor on the process noise: a number, or a dictionary by the names of blocks of states as
        :func:`estimate_noise` gives them.
    measurement
        Factor on the measurement noise: a number, or a dictionary by measurement type, 1 for types
        that are not named.
    model
        ``F`` and ``H`` where the log lacks ``A`` or ``H``.

    Returns
    -------
    WhatIf
        NIS before and after (1 is consistent), standard deviations and RMSE (lower is better).

    Raises
    ------
    ValueError
        If the log does not hold what is needed, a name is unknown or a factor is negative.

    Notes
    -----
    The RMSE of the filter run again assumes that the factors are true. The first prediction of each
    track keeps its claimed covariance. For an extended Kalman filter the second pass uses the
    Jacobians of the first.

    Examples
    --------
    A constant is measured with variance 4; the filter claims 1.

    >>> import numpy as np
    >>> from trackmetrics.logs import EstimatorLog
    >>> z = 2 * np.random.default_rng(0).normal(size=200)
    >>> x, P, rows = 0.0, 10.0, []
    >>> for value in z:
    ...     P_pred = P + 0.01
    ...     S = P_pred + 1
    ...     K, nu = P_pred / S, value - x
    ...     x, P = x + K * nu, (1 - K) * P_pred
    ...     rows.append(([nu], [[S]], [[P_pred]], [[P]], [[1 - K]]))
    >>> innovation, S, P_pred, P, A = zip(*rows)
    >>> log = EstimatorLog.from_columns(
    ...     states=["s"], innovation=innovation, S=S, P_pred=P_pred, P=P, A=A,
    ...     observed=[["s"]] * 200, measurement_type=["radar"] * 200)
    >>> found = whatif(log, measurement={"radar": 4.0})
    >>> found.nis_before > 3 and 0.8 < found.nis_after < 1.2
    True
    """
    blocks = "all" if isinstance(process, float | int) or set(process) == {"all"} else "by_block"
    found = log_model(log, blocks, "by_type", model)
    errors = found.errors
    factors = np.concatenate([
        _listed("process", process, errors.process),
        _listed("measurement", measurement, errors.measurement),
    ])  # fmt: skip
    before = errors.evaluate(np.ones(errors.count), False, 1.0)[3]
    after = errors.evaluate(factors, False, 1.0)[3]
    dof = float((~np.isnan(errors.innovations)).sum())
    moments = _Moments(errors, factors)
    for first, stop in pairwise(errors.starts.tolist()):
        moments.follow(first, stop, len(moments.claimed))
    names = log.state_names or tuple(f"x[{i}]" for i in range(errors.H.shape[2]))
    return WhatIf(
        nis_before=float((before**2).sum() / dof),
        nis_expected=moments.nis / dof,
        nis_after=float((after**2).sum() / dof),
        p_value_before=_two_sided(float((before**2).sum()), dof),
        p_value_after=_two_sided(float((after**2).sum()), dof),
        innovation_std=moments.deviations(),
        rmse=moments.errors_of(names),
        updates=int((~np.isnan(errors.innovations)).any(axis=1).sum()),
    )


def _listed(argument: str, given: Factors, names: tuple[str, ...]) -> Floats:
    """One factor for each name."""
    if isinstance(given, float | int):
        given = dict.fromkeys(names, float(given))
    unknown = [name for name in given if name not in names]
    if unknown:
        raise ValueError(f"{argument}: no {unknown[0]!r}; the log has {', '.join(names)}")
    values = [given.get(name, 1.0) for name in names]
    listed = np.array([v.factor if isinstance(v, Factor) else float(v) for v in values])
    for name, value in zip(names, listed, strict=True):
        if not (value >= 0 and np.isfinite(value)):
            raise ValueError(f"{argument}[{name!r}] must be at least 0, got {float(value)!r}")
    return listed


def _two_sided(squared: float, dof: float) -> float:
    upper = chi_square_tail(squared, int(dof))
    return min(1.0, 2 * min(upper, 1 - upper))


class _Moments:
    """Covariances along the tracks: claimed, true of the filter as it is, and of the filter run
    again."""

    def __init__(self, errors: ErrorModel, factors: Floats) -> None:
        self.errors = errors
        split = len(errors.process)
        self.q, self.r = factors[:split], factors[split:]
        n, kinds = errors.H.shape[2], len(errors.measurement)
        m = errors.H.shape[1]
        self.nis = 0.0
        self.claimed, self.own, self.again = np.zeros(n), np.zeros(n), np.zeros(n)
        self.innovation = np.zeros((kinds, m, 2))
        self.seen = np.zeros((kinds, m))

    def follow(self, first: int, stop: int, n: int) -> None:
        """Adds one track."""
        errors = self.errors
        track = int(np.searchsorted(errors.starts, first, "right")) - 1
        P = errors.initial[track]
        claimed, own, again = P.copy(), P.copy(), P.copy()
        for k in range(first, stop):
            if k > first:
                F, Q = errors.F[k], errors.Q[k]
                true = np.einsum("g,gij->ij", self.q, Q)
                claimed = F @ claimed @ F.T + Q.sum(axis=0)
                own, again = F @ own @ F.T + true, F @ again @ F.T + true
            claimed, own, again = self._update(k, claimed, own, again, np.eye(n))
            self.claimed += claimed.diagonal()
            self.own += own.diagonal()
            self.again += again.diagonal()

    def _update(
        self, k: int, claimed: Floats, own: Floats, again: Floats, eye: Floats
    ) -> tuple[Floats, Floats, Floats]:
        errors = self.errors
        there = ~np.isnan(errors.innovations[k])
        if not there.any():
            return claimed, own, again
        H, R = errors.H[k][there], errors.R[k][np.ix_(there, there)]
        kind = int(errors.types[k])
        true = self.r[kind] * R
        S = H @ claimed @ H.T + R
        expected = H @ own @ H.T + true
        self.nis += float(np.trace(np.linalg.solve(S, expected)))
        self.innovation[kind, there, 0] += S.diagonal()
        self.innovation[kind, there, 1] += expected.diagonal()
        self.seen[kind, there] += 1
        K = np.linalg.solve(S, H @ claimed).T
        keep = eye - K @ H
        new = np.linalg.solve(H @ again @ H.T + true, H @ again).T
        return (
            keep @ claimed @ keep.T + K @ R @ K.T,
            keep @ own @ keep.T + K @ true @ K.T,
            (eye - new @ H) @ again,
        )

    def deviations(self) -> dict[str, tuple[tuple[float, float], ...]]:
        """Standard deviations of innovations, by measurement type and component."""
        found = {}
        for kind, name in enumerate(self.errors.measurement):
            used = self.seen[kind] > 0
            pairs = np.sqrt(self.innovation[kind, used] / self.seen[kind, used, None])
            found[name] = tuple((float(a), float(b)) for a, b in pairs)
        return found

    def errors_of(self, names: tuple[str, ...]) -> dict[str, tuple[float, float, float]]:
        """Root mean squares of each state."""
        rows = len(self.errors.H)
        parts = np.sqrt(np.stack([self.claimed, self.own, self.again], axis=1) / rows)
        return {
            n: (float(a), float(b), float(c)) for n, (a, b, c) in zip(names, parts, strict=True)
        }
