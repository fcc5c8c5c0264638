"""The likelihood of factors on the noises that a filter claims, from its log alone.

With e the true minus the predicted state, its mean m and covariance C given the innovations so far,
the filter's corrections c, process noises q_g Q_g and measurement noise r_t R:

- prediction: m <- F m, C <- F C F' + sum over g of q_g Q_g;
- innovation: d = nu - H m ~ N(0, S), S = H C H' + r_t R;
- conditioning: m <- m + G d, C <- (I - G H) C, with G = C H' S^-1; then m <- m - c.

The derivatives of m and C by each factor are carried along.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import inf, isinf, lgamma, log, log1p, pi

import numpy as np

from trackmetrics import errors as messages
from trackmetrics._numpy.arguments import Floats, plain, plain_ids, plain_numbers
from trackmetrics._numpy.diagnostics import Integers

LARGEST = 64


def noise_likelihood(
    innovations: Floats,
    observations: Floats,
    measurement_noises: Floats,
    types: Integers,
    transitions: Floats,
    process_noises: Floats,
    corrections: Floats,
    periods: Floats,
    initial: Floats,
    starts: Integers,
    process_factors: Floats,
    measurement_factors: Floats,
    initial_factor: float,
    tail_dof: float,
    tail_scales: Floats,
    derivatives: bool,
) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    """Log-density of each innovation given those before, gradients and informations of each track,
    whitened innovations, mean and covariance of the last prediction error given all innovations."""
    arrays = (innovations, observations, measurement_noises, transitions, process_noises)
    more = (corrections, periods, initial, process_factors, measurement_factors, tail_scales)
    plain(*arrays, *more)
    plain_ids(types, starts)
    plain_numbers(initial_factor, tail_dof)
    by_row = {
        "innovations": innovations,
        "observations": observations,
        "measurement_noises": measurement_noises,
        "transitions": transitions,
        "process_noises": process_noises,
        "corrections": corrections,
        "periods": periods,
    }
    _check_sizes(by_row, types, initial, starts)
    factors = (process_factors, measurement_factors, initial_factor)
    _check_factors(factors, process_noises, innovations, types, tail_dof, tail_scales)
    tracks, n, m = len(starts) - 1, corrections.shape[1], innovations.shape[1]
    count = len(process_factors) + len(measurement_factors) + 1 if derivatives else 0
    densities, gradients = np.zeros(len(innovations)), np.zeros((tracks, count))
    informations = np.zeros((tracks, count, count))
    whitened = np.zeros((len(innovations), m))
    means, covariances = np.zeros((tracks, n)), initial_factor * initial
    filters = _Filter(by_row, types, factors, tail_dof, tail_scales)
    for i, (a, b) in enumerate(pairwise(starts)):
        track = _Track(initial[i], initial_factor, count)
        for k in range(a, b):
            if k > a:
                filters.predict(track, k)
            densities[k] = filters.update(track, k, whitened[k])
            if k + 1 == b:
                means[i], covariances[i] = track.m, track.C
            track.m = track.m - corrections[k]
        gradients[i], informations[i] = track.gradient, track.information
    return densities, gradients, informations, whitened, means, covariances


class _Track:
    """Mean and covariance of a prediction error, their derivatives, and the sums so far."""

    def __init__(self, initial: Floats, factor: float, count: int) -> None:
        n = len(initial)
        self.m, self.C = np.zeros(n), factor * initial
        self.dm, self.dC = np.zeros((count, n)), np.zeros((count, n, n))
        if count:
            self.dC[-1] = initial
        self.gradient, self.information = np.zeros(count), np.zeros((count, count))


@dataclass
class _Filter:
    """The recursion over the updates of a track."""

    rows: dict[str, Floats]
    types: Integers
    factors: tuple[Floats, Floats, float]
    tail_dof: float
    tail_scales: Floats

    def predict(self, track: _Track, k: int) -> None:
        F, Q = self.rows["transitions"][k], self.rows["process_noises"][k]
        q = self.factors[0]
        track.m, track.dm = F @ track.m, track.dm @ F.T
        track.C = F @ track.C @ F.T + np.einsum("g,gij->ij", q, Q)
        track.dC = F @ track.dC @ F.T
        if len(track.dC):
            track.dC[: len(q)] += Q

    def update(self, track: _Track, k: int, whitened: Floats) -> float:
        there = ~np.isnan(self.rows["innovations"][k])
        if not there.any():
            return 0.0
        H = self.rows["observations"][k][there]
        R = self.rows["measurement_noises"][k][np.ix_(there, there)]
        r = self.factors[1][self.types[k]]
        d = _wrapped(
            self.rows["innovations"][k][there] - H @ track.m, self.rows["periods"][k][there]
        )
        S = H @ track.C @ H.T + r * R
        whitened[there] = np.linalg.solve(_factor(S, k), d)
        dd, dS = -track.dm @ H.T, H @ track.dC @ H.T
        own = len(self.factors[0]) + int(self.types[k])
        if len(dS):
            dS[own] += R
        density, weight, falls = self._add(track, d, S, dd, dS)
        if weight < 1:
            # R / W instead of R; dW = -W^2 d(delta) / (v + p).
            S = H @ track.C @ H.T + r / weight * R
            if len(dS):
                dS[own] += (1 / weight - 1) * R
            dS = dS + (r * falls / (self.tail_dof + len(d)))[:, None, None] * R
        _condition(track, H, d, S, dd, dS)
        return density

    def _add(
        self, track: _Track, d: Floats, S: Floats, dd: Floats, dS: Floats
    ) -> tuple[float, float, Floats]:
        """Adds the derivatives of the log-density; gives it, the weight of the innovation, and the
        derivatives of d' S^-1 d."""
        u = np.linalg.solve(S, d)
        density, weight = self._density(float(d @ u), len(d))
        density -= 0.5 * float(np.linalg.slogdet(S)[1])
        ratio = np.linalg.solve(S, dS)
        falls = 2 * dd @ u - dS @ u @ u
        track.gradient -= 0.5 * (weight * falls + np.einsum("kii->k", ratio))
        track.information += 0.5 * np.einsum("aij,bji->ab", ratio, ratio)
        track.information += dd @ np.linalg.solve(S, dd.T)
        return density, weight, falls

    def _density(self, squared: float, p: int) -> tuple[float, float]:
        v, scale = self.tail_dof, float(self.tail_scales[p])
        if isinf(v):
            return -0.5 * (squared + p * log(2 * pi)), 1.0
        constant = lgamma((v + p) / 2) - lgamma(v / 2) - p / 2 * log(v * pi / scale)
        density = constant - (v + p) / 2 * log1p(scale * squared / v)
        return density, scale * (v + p) / (v + scale * squared)


def _condition(track: _Track, H: Floats, d: Floats, S: Floats, dd: Floats, dS: Floats) -> None:
    """Conditions mean and covariance on an innovation, and their derivatives with them."""
    G = np.linalg.solve(S, H @ track.C).T
    dG = np.linalg.solve(S, (track.dC @ H.T - G @ dS).swapaxes(1, 2)).swapaxes(1, 2)
    track.dm = track.dm + dG @ d + dd @ G.T
    half = dG @ S @ G.T + 0.5 * G @ dS @ G.T
    track.dC = track.dC - half - half.swapaxes(1, 2)
    track.m = track.m + G @ d
    track.C = track.C - G @ S @ G.T


def _wrapped(d: Floats, periods: Floats) -> Floats:
    turns = np.nan_to_num(periods * np.ceil(d / periods - 0.5))
    wrapped: Floats = d - turns
    return wrapped


def _factor(S: Floats, k: int) -> Floats:
    try:
        return np.asarray(np.linalg.cholesky(S), np.float64)
    except np.linalg.LinAlgError:
        for minor in range(1, len(S) + 1):
            try:
                np.linalg.cholesky(S[:minor, :minor])
            except np.linalg.LinAlgError:
                raise messages.not_positive_definite("innovation covariances", [k], minor) from None
        raise


def _check_sizes(
    by_row: dict[str, Floats], types: Integers, initial: Floats, starts: Integers
) -> None:
    n, m = by_row["corrections"].shape[1], by_row["innovations"].shape[1]
    groups, updates = by_row["process_noises"].shape[1], len(types)
    for argument, value in (("states", n), ("components", m)):
        if value > LARGEST:
            raise messages.parameter(argument, "at most 64", value)
    if not len(starts) or starts[0] != 0 or starts[-1] != updates or (np.diff(starts) < 0).any():
        raise messages.offsets("innovations", updates)
    sizes = (m, m * n, m * m, n * n, groups * n * n, n, m)
    for (argument, values), size in zip(by_row.items(), sizes, strict=True):
        _check_array(argument, values, size, updates, "types", "updates")
    _check_array("initial", initial, n * n, len(starts) - 1, "starts", "tracks")


def _check_array(
    argument: str, values: Floats, size: int, rows: int, other: str, unit: str
) -> None:
    if values.size != size * rows:
        raise messages.length(argument, values.size // size if size else rows, other, rows, unit)
    optional = argument in ("innovations", "periods")
    bad = np.isinf(values) if optional else ~np.isfinite(values)
    if bad.any():
        i = int(np.argmax(bad.ravel()))
        raise messages.not_finite(argument, [i // size], values.ravel()[i])


def _check_factors(
    factors: tuple[Floats, Floats, float],
    process_noises: Floats,
    innovations: Floats,
    types: Integers,
    tail_dof: float,
    tail_scales: Floats,
) -> None:
    process, measurement, initial = factors
    groups, sizes = process_noises.shape[1], innovations.shape[1] + 1
    if len(process) != groups:
        raise messages.length("process_factors", len(process), "process_noises", groups, "groups")
    if len(tail_scales) != sizes:
        raise messages.length("tail_scales", len(tail_scales), "innovations", sizes, "sizes")
    wrong = (types < 0) | (types >= len(measurement))
    if wrong.any():
        k = int(np.argmax(wrong))
        raise messages.element("types", [k], "an index of measurement_factors", types[k])
    for argument, values in (
        ("process_factors", process),
        ("measurement_factors", measurement),
        ("initial_factor", np.array([initial])),
    ):
        for value in values[~((values >= 0) & (values < inf))]:
            raise messages.parameter(argument, "at least 0", value)
    if not tail_dof > 0:
        raise messages.parameter("tail_dof", "positive", tail_dof)
