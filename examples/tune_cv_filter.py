"""Find the process noise of a constant-velocity filter by a Monte Carlo sweep.

A target moves with nearly constant velocity: its acceleration is white noise of a power that the
filter does not know. The filter is run with several guesses ``q``; where the guess is right, its
errors are as large as its covariances say (ANEES 1) and its position error is least.

    python examples/tune_cv_filter.py [runs]
"""

import sys

import numpy as np

from trackmetrics.monte_carlo import sweep

STEP = 1.0  # s
STEPS = 60
TRUE_Q = 0.1  # m^2/s^3, power spectral density of the acceleration
SENSOR = 5.0  # m, standard deviation of a measured position

F = np.kron(np.eye(2), [[1.0, STEP], [0.0, 1.0]])
G = np.kron(np.eye(2), [[STEP**3 / 3, STEP**2 / 2], [STEP**2 / 2, STEP]])
H = np.kron(np.eye(2), [[1.0, 0.0]])
R = SENSOR**2 * np.eye(2)
P0 = np.diag([SENSOR**2, 10.0**2] * 2)


def simulate(rng, q):
    """One run: a path, its measurements, and what the filter makes of them."""
    root = np.linalg.cholesky(TRUE_Q * G)
    x = np.array([0.0, 10.0, 0.0, -5.0])
    estimate, p = x + np.linalg.cholesky(P0) @ rng.normal(size=4), P0
    found = {"truth": [], "estimates": [], "covariances": []}
    found |= {"innovations": [], "innovation_covariances": []}
    for _ in range(STEPS):
        x = F @ x + root @ rng.normal(size=4)
        estimate, p = F @ estimate, F @ p @ F.T + q * G
        s = H @ p @ H.T + R
        innovation = H @ x + SENSOR * rng.normal(size=2) - H @ estimate
        gain = np.linalg.solve(s, H @ p).T
        keep = np.eye(4) - gain @ H
        estimate, p = estimate + gain @ innovation, keep @ p @ keep.T + gain @ R @ gain.T
        values = (x, estimate, p, innovation, s)
        for column, value in zip(found.values(), values, strict=True):
            column.append(value)
    return {name: np.array(column) for name, column in found.items()}


def main(runs=400, executor=None):
    """Sweeps over guesses and says which is the consistent one."""
    grid = {"q": [0.001, 0.01, 0.03, 0.1, 0.3, 1.0]}
    result = sweep(simulate, runs, seed=1, grid=grid, executor=executor)
    low, high = result.anees_interval
    print(f"q, m^2/s^3   mean ANEES   steps in [{low:.2f}, {high:.2f}]   position RMSE, m")
    for settings, anees, rmse in zip(result.grid, result.anees, result.rmse, strict=True):
        inside = np.mean((low < anees) & (anees < high))
        position = np.sqrt((rmse[:, [0, 2]] ** 2).sum(1).mean())
        print(f"{settings['q']:<10g}   {anees.mean():10.3f}   {inside:22.0%}   {position:16.2f}")
    best = result.best("anees")
    words = "" if best.significant else "not "
    print(f"the consistent filter has q = {best.settings['q']:g} (true: {TRUE_Q:g}),")
    print(f"and is {words}significantly more consistent than the next, q = {best.runner_up['q']:g}")
    return result


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 400, "processes")
