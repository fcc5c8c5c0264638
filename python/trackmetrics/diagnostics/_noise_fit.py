"""Maximum-likelihood factors on claimed noises, likelihood ratios and profile intervals.

The factors are found by Fisher scoring, with the factors that reach zero held there while the
likelihood would rise only below it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, inf, log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NEAR = 1e-3
"""Rise of the log-likelihood that may be left where it is only compared."""
SMALLEST, LARGEST = 1e-5, 1e6
"""Range in which factors are sought; a process factor may also be 0."""


@dataclass(frozen=True)
class ErrorModel:
    """Innovations, and the linear model of the prediction errors behind them, track by track."""

    innovations: Floats
    """``(rows, m)``, NaN where a component is missing or not used."""
    H: Floats
    """``(rows, m, n)``."""
    R: Floats
    """``(rows, m, m)``, claimed."""
    types: Integers
    """``(rows,)``: index into ``measurement``."""
    F: Floats
    """``(rows, n, n)``; that of the first row of a track is not used."""
    Q: Floats
    """``(rows, groups, n, n)``, claimed; that of the first row of a track is not used."""
    corrections: Floats
    """``(rows, n)``: updated minus predicted state."""
    periods: Floats
    """``(rows, m)``: period of a component that is an angle, else NaN."""
    initial: Floats
    """``(tracks, n, n)``: claimed covariance of the first prediction."""
    starts: Integers
    """``(tracks + 1,)``: first row of each track, and the number of rows."""
    process: tuple[str, ...]
    """Names of the groups of process noise."""
    measurement: tuple[str, ...]
    """Names of the measurement types."""
    tail_dof: float = inf
    """Degrees of freedom of Student's t distribution of the innovations."""
    initial_factor: float = 1e4
    """Factor on ``initial``: large, since a wrong start is no fault of the noises."""

    @property
    def count(self) -> int:
        """How many factors there are."""
        return len(self.process) + len(self.measurement)

    @property
    def lowest(self) -> Floats:
        """The smallest value of each factor."""
        return np.repeat([0.0, SMALLEST], [len(self.process), len(self.measurement)])

    @cached_property
    def tail(self) -> tuple[Floats, float]:
        """Scales of Student's t distribution by number of components, and the ratio by which its
        likelihood ratios exceed a chi-square."""
        return tail_scales(self.innovations.shape[1], self.tail_dof)

    def evaluate(
        self, factors: Floats, derivatives: bool = True, initial: float | None = None
    ) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """What the kernel gives at these factors."""
        split = len(self.process)
        found: tuple[Floats, Floats, Floats, Floats, Floats, Floats]
        found = _backend.kernels.noise_likelihood(
            self.innovations, self.H, self.R, self.types, self.F, self.Q, self.corrections,
            self.periods, self.initial, self.starts,
            np.ascontiguousarray(factors[:split]), np.ascontiguousarray(factors[split:]),
            float(self.initial_factor if initial is None else initial),
            float(self.tail_dof), self.tail[0], derivatives,
        )  # fmt: skip
        return found

    def likelihood(self, factors: Floats) -> float:
        """Log-likelihood of all tracks."""
        return float(self.evaluate(factors, False)[0].sum())

    def without(self, mask: NDArray[np.bool_]) -> "ErrorModel":
        """The same with these rows (or components) of the innovations not used."""
        innovations = self.innovations.copy()
        innovations[mask] = np.nan
        return replace(self, innovations=innovations)

    def tracks(self, first: int, stop: int) -> "ErrorModel":
        """Some consecutive tracks alone."""
        rows = slice(int(self.starts[first]), int(self.starts[stop]))
        cut: dict[str, Any] = {
            name: np.ascontiguousarray(getattr(self, name)[rows])
            for name in ("innovations", "H", "R", "types", "F", "Q", "corrections", "periods")
        }
        initial = np.ascontiguousarray(self.initial[first:stop])
        starts = self.starts[first : stop + 1] - rows.start
        return replace(self, **cut, initial=initial, starts=starts)


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood."""

    factors: Floats
    value: float
    information: Floats


def tail_scales(most: int, dof: float) -> tuple[Floats, float]:
    """For each number of components p the scale s at which a normal innovation has the mean
    weighted square p, that is E[s (v + p) x / (v + s x)] = p for a chi-square x of p degrees of
    freedom; and by how much likelihood ratios of a scale then exceed a chi-square."""
    scales = np.ones(most + 1)
    if np.isinf(dof):
        return scales, 1.0
    ratio = 0.0
    for p in range(1, most + 1):
        x, weights = _chi_square_nodes(p)
        low, high = 0.5, 4.0
        for _ in range(60):
            middle = (low + high) / 2
            if weights @ (middle * (dof + p) * x / (dof + middle * x)) < p:
                low = middle
            else:
                high = middle
        scales[p] = s = (low + high) / 2
        weighted = s * (dof + p) * x / (dof + s * x)
        slope = weights @ (weighted * dof / (dof + s * x))
        ratio = max(ratio, float(weights @ (weighted - p) ** 2 / 2 / slope))
    return scales, ratio


def _chi_square_nodes(p: int) -> tuple[Floats, Floats]:
    """Nodes and weights that integrate over a chi-square distribution."""
    from scipy import special

    probabilities = (np.arange(4000) + 0.5) / 4000
    return 2 * special.gammaincinv(p / 2, probabilities), np.full(4000, 1 / 4000)


def maximise(
    model: ErrorModel,
    start: Floats | None = None,
    fixed: Sequence[int] = (),
    tolerance: float = 1e-5,
) -> Fit:
    """The factors of the largest likelihood; those of the indices ``fixed`` stay at ``start``."""
    factors = np.ones(model.count) if start is None else np.array(start, float)
    lowest, free = model.lowest, np.ones(model.count, bool)
    free[list(fixed)] = False
    value, gradient, information = _summed(model, factors)
    for _ in range(60):
        step = _step(factors, gradient, information, free, lowest)
        gain = float(gradient @ step)
        if gain < tolerance:
            break
        for halving in range(12):
            trial = np.clip(factors + step / 2**halving, lowest, LARGEST)
            trial[~free] = factors[~free]
            found = _summed(model, trial)
            if found[0] >= value:
                break
        else:
            break
        rise = found[0] - value
        factors, (value, gradient, information) = trial, found
        if rise < tolerance / 10 and halving == 0:
            break
    return Fit(factors, value, information)


def _summed(model: ErrorModel, factors: Floats) -> tuple[float, Floats, Floats]:
    try:
        densities, gradients, informations = model.evaluate(factors)[:3]
    except np.linalg.LinAlgError:
        return -inf, np.zeros(model.count), np.eye(model.count)
    k = model.count
    return float(densities.sum()), gradients.sum(0)[:k], informations.sum(0)[:k, :k]


def _step(
    factors: Floats, gradient: Floats, information: Floats, free: NDArray[np.bool_], lowest: Floats
) -> Floats:
    """A step of Fisher scoring among the factors that may move; factors that it would take below
    their lowest value go there and are left out of the next solution."""
    step = np.zeros_like(factors)
    moving = free & ~((factors <= lowest) & (gradient <= 0))
    for _ in range(len(factors)):
        index = np.flatnonzero(moving)
        if not len(index):
            break
        right = (
            gradient[index] - information[np.ix_(index, np.flatnonzero(~moving))] @ step[~moving]
        )
        step[index] = _solved(information[np.ix_(index, index)], right)
        below = moving & (factors + step < lowest)
        if not below.any():
            break
        step[below] = (lowest - factors)[below]
        moving &= ~below
    return step


def _solved(matrix: Floats, right: Floats) -> Floats:
    """The solution of scaled normal equations, with a little damping."""
    d = np.sqrt(np.maximum(matrix.diagonal(), 1e-300))
    scaled = matrix / np.outer(d, d) + 1e-9 * np.eye(len(d))
    solution: Floats = np.linalg.solve(scaled, right / d) / d
    return solution


class Profile:
    """The likelihood of one factor, with the others at their best."""

    def __init__(self, model: ErrorModel, fit: Fit, index: int) -> None:
        self.model, self.fit, self.index = model, fit, index
        self.ratio = model.tail[1]
        self._known = [fit]

    def statistic(self, value: float) -> float:
        """Twice the log-likelihood ratio of the best factor to this one."""
        near = min(self._known, key=lambda f: abs(_log(f.factors[self.index]) - _log(value)))
        start = near.factors.copy()
        start[self.index] = value
        if self.model.count == 1:
            found = Fit(start, self.model.likelihood(start), near.information)
        else:
            found = maximise(self.model, start, [self.index], NEAR)
        self._known.append(found)
        return max(0.0, 2 * (self.fit.value - found.value) / self.ratio)

    def p_value(self, value: float) -> float:
        """Probability of so large a statistic if this value is true.

        At 0, below which no estimate can be, the statistic is 0 in half of all logs and a
        chi-square in the others: Self and Liang (1987), doi:10.1080/01621459.1987.10478472.
        """
        share = 0.5 if value <= 0 else 1.0
        return share * chi_square_tail(self.statistic(value), 1)

    def interval(self, confidence: float) -> tuple[float, float]:
        """All values whose p-value is at least ``1 - confidence``; an end is infinite or 0 where
        there is no bound within :data:`SMALLEST` to :data:`LARGEST`."""
        return self._end(confidence, -1), self._end(confidence, 1)

    def _end(self, confidence: float, side: int) -> float:
        """Where the root of the statistic, nearly a line in the logarithm of the factor, is that of
        the confidence: by secants, and by halving where a secant would leave the bracket."""
        wanted = normal_quantile((1 + confidence) / 2)
        inside, root = _log(float(self.fit.factors[self.index])), 0.0
        limit = log(LARGEST if side > 0 else SMALLEST)
        step = self._first_step(wanted)
        while True:
            if inside == limit:
                return self._limit(1 - confidence, side)
            beyond = side * min(side * (inside + side * step), side * limit)
            reached = self.statistic(exp(beyond)) ** 0.5
            if reached >= wanted:
                return exp(self._between((inside, root), (beyond, reached), wanted))
            rise = max((reached - root) / abs(beyond - inside), 1e-3)
            step = min(max(1.2 * (wanted - reached) / rise, 0.1), 2 * step + 1)
            inside, root = beyond, reached

    def _first_step(self, wanted: float) -> float:
        """The distance of the end in the logarithm, from the information at the maximum."""
        variance = partial_variance(self.fit.information, self.index)
        deviation = float(variance) ** 0.5 / max(float(self.fit.factors[self.index]), SMALLEST)
        return float(min(max(wanted * deviation, 0.01), 2.0))

    def _limit(self, alpha: float, side: int) -> float:
        """The end where no factor within the range is refused."""
        if side > 0:
            return inf
        process = self.index < len(self.model.process)
        return SMALLEST if process and self.p_value(0.0) < alpha else 0.0

    def _between(
        self, inside: tuple[float, float], beyond: tuple[float, float], wanted: float
    ) -> float:
        """Where the root of the statistic is as wanted, within 0.002 of a standard deviation."""
        for attempt in range(40):
            (a, low), (b, high) = inside, beyond
            share = (wanted - low) / (high - low) if high > low and attempt % 4 < 3 else 0.5
            middle = a + min(max(share, 0.02), 0.98) * (b - a)
            reached = self.statistic(exp(middle)) ** 0.5
            if abs(reached - wanted) < 0.002 or abs(b - a) < 1e-4:
                return middle
            if reached < wanted:
                inside = middle, reached
            else:
                beyond = middle, reached
        return middle


def _log(value: float) -> float:
    return log(max(value, SMALLEST))


def partial_variance(information: Floats, index: int) -> float:
    """Variance of one factor's estimate, the others being estimated as well."""
    if information[index, index] < 1e-200:
        return inf
    d = np.sqrt(np.maximum(information.diagonal(), 1e-300))
    scaled = information / np.outer(d, d) + 1e-10 * np.eye(len(d))
    return float(np.linalg.inv(scaled)[index, index] / d[index] ** 2)


def normal_quantile(probability: float) -> float:
    """Quantile of the standard normal distribution."""
    from scipy import special

    return float(special.ndtri(probability))


def chi_square_tail(statistic: float, dof: int) -> float:
    """Upper tail probability of the chi-square distribution."""
    from scipy import special

    return float(special.gammaincc(dof / 2, max(statistic, 0.0) / 2))
