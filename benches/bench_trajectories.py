"""Distances between sets of trajectories.

    python benches/bench_trajectories.py [--save]

No peer in Python has OSPA(2) or trajectory GOSPA in this form: OSPA(2) is held against its NumPy
reference, trajectory GOSPA against the sparse linear programme of its definition, for all at once.
"""

import itertools

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, hstack, identity, kron, vstack

import trackmetrics
from harness import Bench
from trackmetrics import ospa2, trajectory_gospa


def lanes(count, length, rng):
    """One truth in each lane, followed by one track or by two in turn."""
    times = np.arange(length)
    truth, tracks = [], []
    for lane in range(count):
        states = np.column_stack([times, np.full(length, 100.0 * lane)])
        truth.append((times, states))
        cuts = [0, length] if lane % 2 else [0, length // 2, length]
        for a, b in itertools.pairwise(cuts):
            tracks.append((times[a:b], states[a:b] + rng.normal(0, 2, (b - a, 2))))
    return truth, tracks


def whole_programme(truth, tracks, c, p, gamma):
    """The programme of the definition: weights with dummies, and a bound on every change."""
    length = 1 + max(times[-1] for times, _ in truth)
    n, m = len(truth), len(tracks)
    x, y = (dense(side, length) for side in (truth, tracks))
    costs = np.zeros((n + 1, m + 1, length))
    distances = np.linalg.norm(x[:, None] - y[None], axis=-1)
    there = [~np.isnan(side[..., 0]) for side in (x, y)]
    both = there[0][:, None] & there[1][None]
    one = there[0][:, None] ^ there[1][None]
    costs[:n, :m] = np.where(both, np.minimum(np.nan_to_num(distances), c) ** p, one * c**p / 2)
    costs[:n, m], costs[n, :m] = there[0] * c**p / 2, there[1] * c**p / 2
    cells = costs.size
    place = np.arange(cells).reshape(costs.shape)
    real = place[:n, :m].reshape(n * m, length)
    step = identity(length, format="csr")[1:] - identity(length, format="csr")[:-1]
    changes = n * m * (length - 1)
    change = kron(identity(n * m), step) @ selection(real.ravel(), cells)
    rows = [place[i].reshape(-1, length) for i in range(n)] + [
        place[:, j].reshape(-1, length) for j in range(m)
    ]
    sums = [sum(selection(block, cells) for block in row) for row in rows]
    up = hstack([change, -identity(changes)])
    down = hstack([-change, -identity(changes)])
    equal = vstack([hstack([s, coo_array((length, changes))]) for s in sums])
    solved = linprog(
        np.concatenate([costs.ravel(), np.full(changes, gamma**p / 2)]),
        A_ub=vstack([up, down]).tocsr(),
        b_ub=np.zeros(2 * changes),
        A_eq=equal.tocsr(),
        b_eq=np.ones(equal.shape[0]),
        method="highs",
    )
    return solved.fun ** (1 / p)


def dense(side, length):
    states = np.full((len(side), length, side[0][1].shape[1]), np.nan)
    for row, (times, values) in zip(states, side, strict=True):
        row[times] = values
    return states


def selection(places, cells):
    return coo_array(
        (np.ones(len(places)), (np.arange(len(places)), places)), shape=(len(places), cells)
    ).tocsr()


def bench_trajectory_gospa(bench: Bench) -> None:
    rng = np.random.default_rng(1)
    for count in (5, 20):
        truth, tracks = lanes(count, 100, rng)
        expected = whole_programme(truth, tracks, 10.0, 1, 5.0)
        found = trajectory_gospa(truth, tracks, 10.0, 1, 5.0).distance
        assert abs(found - expected) < 1e-6 * expected
        bench.compare(
            f"trajectory_gospa, {count} lanes, 100 steps",
            lambda x=truth, y=tracks: trajectory_gospa(x, y, 10.0, 1, 5.0),
            {"one programme": lambda x=truth, y=tracks: whole_programme(x, y, 10.0, 1, 5.0)},
            target=20 if count == 20 else None,
            rounds=3,
        )


def reference(*arguments, **options):
    with trackmetrics.use_backend("numpy"):
        return ospa2(*arguments, **options)


def bench_ospa2(bench: Bench) -> None:
    rng = np.random.default_rng(2)
    truth, tracks = lanes(10, 100, rng)
    for window in (5, 50):
        ours = ospa2(truth, tracks, 10, 2, window=window)
        theirs = reference(truth, tracks, 10, 2, window=window)
        assert np.allclose(ours.distance, theirs.distance, rtol=1e-12)
        bench.compare(
            f"ospa2, 10 truths, 15 tracks, 100 steps, window {window}",
            lambda w=window: ospa2(truth, tracks, 10, 2, window=w),
            {"NumPy reference": lambda w=window: reference(truth, tracks, 10, 2, window=w)},
            rounds=5,
        )


if __name__ == "__main__":
    bench = Bench("trajectories")
    bench_ospa2(bench)
    bench_trajectory_gospa(bench)
    bench.finish()
