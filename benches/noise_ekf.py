"""An extended Kalman filter that sees range and bearing, with known factors on its noises."""

from typing import Any

import numpy as np

from noise_plants import chain
from trackmetrics.logs import EstimatorLog

F2, Q2 = chain(2, 2.0, 0.05)
F, Q = np.kron(np.eye(2), F2), np.kron(np.eye(2), Q2)
R = np.diag([100.0, 0.005**2])
P0 = np.kron(np.eye(2), np.diag([400.0, 25.0]))
ORIGIN = np.array([2000.0, -5.0, 1500.0, 8.0])


def polar(x: Any) -> tuple[Any, Any]:
    """Range and bearing, and their Jacobian."""
    range_ = np.hypot(x[0], x[2])
    h = np.array([range_, np.arctan2(x[2], x[0])])
    H = np.zeros((2, 4))
    H[0, [0, 2]] = x[0] / range_, x[2] / range_
    H[1, [0, 2]] = -x[2] / range_**2, x[0] / range_**2
    return h, H


def simulate(q: float, r: float, updates: int, seed: int) -> EstimatorLog:
    """The log of one run; the truth has ``q`` and ``r`` times the noises that the filter claims."""
    rng = np.random.default_rng([seed, updates])
    truth = rng.multivariate_normal(ORIGIN, P0)
    x, P, rows = ORIGIN, P0, []
    for _ in range(updates):
        truth = rng.multivariate_normal(F @ truth, q * Q)
        z = polar(truth)[0] + rng.normal(size=2) * np.sqrt(r * R.diagonal())
        x_pred, P_pred = F @ x, F @ P @ F.T + Q
        h, H = polar(x_pred)
        nu = z - h
        nu[1] = (nu[1] + np.pi) % (2 * np.pi) - np.pi
        S = H @ P_pred @ H.T + R
        K = np.linalg.solve(S, H @ P_pred).T
        keep = np.eye(4) - K @ H
        x, P = x_pred + K @ nu, keep @ P_pred @ keep.T + K @ R @ K.T
        rows.append((nu, S, R, H, x_pred, P_pred, x, P, keep @ F, truth))
    names = ("innovation", "S", "R", "H", "x_pred", "P_pred", "x", "P", "A", "truth")
    columns = {
        name: list(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)
    }
    return EstimatorLog.from_columns(
        states=["x", "vx", "y", "vy"],
        measurement_type=["radar"] * updates,
        measurement_angles={"radar": {1: 2 * np.pi}},
        **columns,
    )
