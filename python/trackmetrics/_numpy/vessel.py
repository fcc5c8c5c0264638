"""The five-state estimator of vessels: reference implementation of the kernels.

The state and its motion: see :mod:`trackmetrics._numpy.vessel_motion`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, plain
from trackmetrics._numpy.vessel_motion import (
    KNOT,
    RADIAN,
    Motion,
    carry,
    degree,
    pieces,
    step,
    wrap_course,
    wrap_difference,
)

SPEED_PRIOR = 15.0


COURSE_PRIOR = 360.0 / 12.0**0.5


LOST_COURSE = 60.0


Rules = tuple[int, float, bool, float]


def variances(z: Floats, sigma: Floats) -> Floats:
    """Variances of the four components of a measurement."""
    m_north, m_east, _, _ = degree(z[0])
    return np.array([sigma[0] / m_north, sigma[0] / m_east, sigma[1], sigma[2]]) ** 2


def cholesky(s: Floats, report: int) -> Floats:
    """L of S = L L'; names the report where S is not positive definite."""
    try:
        lower = np.asarray(np.linalg.cholesky(s), np.float64)
        if np.isfinite(lower).all():
            return lower
    except np.linalg.LinAlgError:
        pass
    minors = range(1, len(s) + 1)
    minor = next(k for k in minors if not np.linalg.det(s[:k, :k]) > 0 or k == len(s))
    raise errors.not_positive_definite("S", [report], minor)


def fuse(
    x: Floats, p: Floats, f: Floats, z: Floats, r: Floats, report: int
) -> tuple[Floats, Floats, Floats, Floats, Floats, float]:
    """Updated state and covariance, (I - K H) F, innovation, S and NIS."""
    m = len(z)
    y = z - x[:m]
    y[1] = wrap_difference(y[1])
    if m == 4:
        y[3] = wrap_difference(y[3])
    s = p[:m, :m] + np.diag(r)
    lower = cholesky(s, report)
    half = np.linalg.solve(lower, p[:m])
    gain = np.linalg.solve(lower.T, half).T
    x = x + gain @ y
    x[1], x[3] = wrap_difference(x[1]), wrap_course(x[3])
    kept = np.eye(5)
    kept[:, :m] -= gain
    updated: Floats = kept @ p @ kept.T + gain * r @ gain.T
    white = np.linalg.solve(lower, y)
    return x, (updated + updated.T) * 0.5, kept @ f, y, s, float(white @ white)


@dataclass
class Track:
    """A track between two reports; see ``lifecycle`` in the core."""

    life: Floats  # reports, starts, time, first time, first latitude, longitude, sigma
    x: Floats
    p: Floats

    def take(
        self, i: int, time: float, z: Floats, sigma: Floats, motion: Motion, rules: Rules
    ) -> tuple[int, Any]:
        """Takes a report in: its outcome, and what the filter says where it ran."""
        tentative, _, placeholders, delete_after = rules
        if self.life[0] > 0 and time < self.life[2]:
            return 0, None
        if self.life[0] == 0 or time - self.life[2] > delete_after:
            self.life[:] = 1, self.life[1] + 1, time, time, z[0], z[1], sigma[0]
            self.x, self.p = first_state(z, sigma, rules)
            return 1, None
        self.life[0] += 1
        if self.life[0] <= tentative:
            self.learn(time, z, sigma, placeholders, rules)
            self.life[2] = time
            return 2, None
        x, p, f = carry(self.x, self.p, time - self.life[2], motion)
        fused = fuse(x, p, f, z, variances(z, sigma)[: len(z)], i)
        self.life[2], self.x, self.p = time, fused[0], fused[1]
        return 3, (x, p, fused)

    def learn(
        self, time: float, z: Floats, sigma: Floats, placeholders: bool, rules: Rules
    ) -> None:
        """What a tentative track knows after one more report."""
        history = self.history(time, z, sigma)
        if placeholders:
            speed, _, course, _ = history or (0.0, 0.0, 0.0, 0.0)
            self.x = np.array([z[0], z[1], speed, course, 0.0])
            return
        x, p = first_state(z, sigma, rules)
        if history and history[1] < SPEED_PRIOR:
            speed, speed_sigma, course, course_sigma = history
            if len(z) < 3:
                x[2], p[2, 2] = speed, speed_sigma**2
            if len(z) < 4:
                x[3], p[3, 3] = course, course_sigma**2
        self.x, self.p = x, p

    def history(
        self, time: float, z: Floats, sigma: Floats
    ) -> tuple[float, float, float, float] | None:
        """Speed, course and their deviations, from the first position to this one."""
        _, _, _, first_time, latitude, longitude, first_sigma = self.life
        if time <= first_time:
            return None
        m_north, m_east, _, _ = degree(0.5 * (latitude + z[0]))
        north = (z[0] - latitude) * m_north
        east = wrap_difference(z[1] - longitude) * m_east
        speed = np.hypot(north, east) / (time - first_time)
        deviation = np.hypot(first_sigma, sigma[0]) / (time - first_time)
        course = wrap_course(np.arctan2(east, north) / RADIAN)
        of_course = min(deviation / max(speed, 1e-6) / RADIAN, COURSE_PRIOR)
        return speed / KNOT, deviation / KNOT, course, of_course


def first_state(z: Floats, sigma: Floats, rules: Rules) -> tuple[Floats, Floats]:
    """What one report says of a vessel by itself."""
    _, rate, placeholders, _ = rules
    deviations = [SPEED_PRIOR, COURSE_PRIOR, rate]
    if placeholders:
        deviations = [0.0, 0.0, 1.0] if len(z) == 4 else [3.0, 10.0, 0.5]
    x = np.array([0.0, 0.0, 0.0, 360.0 if placeholders else 0.0, 0.0])
    p = np.diag([0.0, 0.0, *deviations]) ** 2
    x[: len(z)] = z
    p[range(len(z)), range(len(z))] = variances(z, sigma)[: len(z)]
    return x, p


def check_motion(motion: Motion) -> None:
    """Refuse densities below zero and a time constant that is not positive."""
    for argument, value in zip(("acceleration", "turn", "course"), motion[:3], strict=True):
        if not 0 <= value < np.inf:
            raise errors.parameter(argument, "at least 0 and finite", value)
    if not motion[3] > 0:
        raise errors.parameter("decay", "positive", motion[3])


def check_states(x: Floats, times: Floats, motion: Motion) -> None:
    """Refuse states and times that cannot be carried forward."""
    check_motion(motion)
    if x.size != 5 * len(times):
        raise errors.length("x", x.size // 5, "times", len(times), "states")
    if not np.isfinite(x).all():
        i, k = np.argwhere(~np.isfinite(x.reshape(-1, 5)))[0]
        raise errors.not_finite("x", [i, k], x.reshape(-1, 5)[i, k])
    bad = np.flatnonzero(~((times >= 0) & np.isfinite(times)))
    if len(bad):
        raise errors.element("times", [bad[0]], "at least 0 and finite", times[bad[0]])


def check_covariances(p: Floats, times: Floats) -> None:
    """Refuse covariances that are not finite or too few."""
    if p.size != 25 * len(times):
        raise errors.length("P", p.size // 25, "times", len(times), "states")
    bad = np.flatnonzero(~np.isfinite(p))
    if len(bad):
        raise errors.not_finite("P", [bad[0] // 25], p.flat[bad[0]])


def vessel_advance(x: Floats, times: Floats, motion: Motion) -> Floats:
    """States after their times, without noise."""
    plain(x, times)
    check_states(x, times, motion)
    ends = np.empty((len(times), 5))
    for i, (state, time) in enumerate(zip(x, times, strict=True)):
        count = pieces(time, motion[3])
        for _ in range(count):
            state, _ = step(state, time / count, motion[3])
        ends[i] = state
    return ends


def vessel_predict(
    x: Floats, P: Floats, times: Floats, motion: Motion
) -> tuple[Floats, Floats, Floats]:
    """States, covariances and Jacobians after their times: (x, P, F)."""
    plain(x, P, times)
    check_states(x, times, motion)
    check_covariances(P, times)
    n = len(times)
    ends, covariances, jacobians = np.empty((n, 5)), np.empty((n, 5, 5)), np.empty((n, 5, 5))
    for i in range(n):
        ends[i], covariances[i], jacobians[i] = carry(x[i], P[i], times[i], motion)
    return ends, covariances, jacobians


def vessel_filter(
    life: Floats,
    x: Floats,
    P: Floats,
    starts: Any,
    times: Floats,
    z: Floats,
    observed: Any,
    sigmas: Floats,
    motion: Motion,
    rules: Rules,
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Reports through the filters of their tracks: the tracks afterwards, and a row for each."""
    plain(life, x, P, times, z, sigmas)
    check_motion(motion)
    for argument, value in (
        ("tentative", rules[0]),
        ("turn_rate", rules[1]),
        ("delete_after", rules[3]),
    ):
        if not value > 0:
            raise errors.parameter(argument, "positive", value)
    _check_reports(len(life), starts, times, z, observed, sigmas)
    life, x, P, n = life.copy(), x.copy(), P.copy(), len(times)
    outcome, start = np.zeros(n, np.int64), np.zeros(n, np.int64)
    floats = [np.full((n, *shape), np.nan) for shape in _SHAPES]
    x_pred, p_pred, innovation, s, r, nis, x_row, p_row, a = floats
    for t in range(len(life)):
        track = Track(life[t], x[t], P[t])
        for i in range(starts[t], starts[t + 1]):
            m = int(observed[i])
            outcome[i], fused = track.take(i, times[i], z[i, :m], sigmas[i], motion, rules)
            start[i] = int(life[t, 1])
            if outcome[i] == 0:
                continue
            x_row[i], p_row[i] = track.x, track.p
            r[i, :m, :m] = np.diag(variances(z[i], sigmas[i])[:m])
            if fused is not None:
                x_pred[i], p_pred[i], (_, _, a[i], innovation[i, :m], s[i, :m, :m], nis[i]) = fused
        x[t], P[t] = track.x, track.p
    return (life, x, P), (outcome, start, *floats)


_SHAPES: list[tuple[int, ...]] = [(5,), (5, 5), (4,), (4, 4), (4, 4), (), (5,), (5, 5), (5, 5)]


def _check_reports(
    tracks: int, starts: Any, times: Floats, z: Floats, observed: Any, sigmas: Floats
) -> None:
    n = len(times)
    rises = len(starts) == tracks + 1 and starts[0] == 0 and starts[-1] == n
    if not rises or (np.diff(starts) < 0).any():
        raise errors.offsets("starts", n)
    for argument, found in (
        ("z", z.size // 4),
        ("observed", len(observed)),
        ("sigmas", sigmas.size // 3),
    ):
        if found != n:
            raise errors.length(argument, found, "times", n, "reports")
    for i in range(n):
        _check_report(i, times[i], z[i], int(observed[i]), sigmas[i])


def _check_report(i: int, time: float, z: Floats, m: int, sigma: Floats) -> None:
    if not np.isfinite(time):
        raise errors.not_finite("times", [i], time)
    if not 2 <= m <= 4:
        raise errors.element("observed", [i], "2, 3 or 4", m)
    for k in range(m):
        if not np.isfinite(z[k]):
            raise errors.not_finite("z", [i, k], z[k])
    if abs(z[0]) > 90:
        raise errors.element("z", [i, 0], "a latitude within 90 degrees", z[0])
    for k in range(m - 1):
        if not 0 < sigma[k] < np.inf:
            raise errors.element("sigmas", [i, k], "positive and finite", sigma[k])


def vessel_gate(
    x: Floats, P: Floats, times: Floats, z: Floats, sigmas: Floats, gate: float, motion: Motion
) -> tuple[Any, Any, Floats, Floats]:
    """Positions and tracks within each other's gate: (position, track, distance^2, ln det S).

    By all pairs: the definition, which the core reaches through bands of latitude.
    """
    plain(x, P, times, z, sigmas)
    check_states(x, times, motion)
    check_covariances(P, times)
    _check_positions(z, sigmas, gate)
    found = []
    for track, (state, covariance, time) in enumerate(zip(x, P, times, strict=True)):
        at, around = _place(*carry(state, covariance, time, motion)[:2], time)
        for position in range(len(sigmas)):
            s = around + np.diag(_position_variances(z[position, 0], sigmas[position]))
            y = z[position] - at
            y[1] = wrap_difference(y[1])
            slope = s[0, 1] / s[0, 0]
            rest = s[1, 1] - slope * s[0, 1]
            distance = y[0] ** 2 / s[0, 0] + (y[1] - slope * y[0]) ** 2 / rest
            if distance <= gate:
                found.append((position, track, distance, np.log(s[0, 0] * rest)))
    found.sort(key=lambda pair: pair[:2])
    positions, tracks, distances, log_dets = zip(*found, strict=True) if found else ((),) * 4
    return (
        np.array(positions, np.int64),
        np.array(tracks, np.int64),
        np.array(distances, np.float64),
        np.array(log_dets, np.float64),
    )


def _check_positions(z: Floats, sigmas: Floats, gate: float) -> None:
    if z.size != 2 * len(sigmas):
        raise errors.length("z", z.size // 2, "sigmas", len(sigmas), "positions")
    if not np.isfinite(z).all():
        i, k = np.argwhere(~np.isfinite(z))[0]
        raise errors.not_finite("z", [i, k], z[i, k])
    bad = np.flatnonzero(~((sigmas > 0) & np.isfinite(sigmas)))
    if len(bad):
        raise errors.element("sigmas", [bad[0]], "positive and finite", sigmas[bad[0]])
    if not 0 < gate < np.inf:
        raise errors.parameter("gate", "positive and finite", gate)


def _place(x: Floats, p: Floats, time: float) -> tuple[Floats, Floats]:
    """Where a track is and its covariance there, wider where its course is lost."""
    around = p[:2, :2].copy()
    if p[3, 3] > LOST_COURSE**2:
        anywhere = (abs(x[2]) + np.sqrt(p[2, 2])) * KNOT * time
        around += np.diag(_position_variances(x[0], anywhere))
    return x[:2], around


def _position_variances(latitude: float, sigma: float) -> Floats:
    m_north, m_east, _, _ = degree(latitude)
    return np.array([sigma / m_north, sigma / m_east]) ** 2
