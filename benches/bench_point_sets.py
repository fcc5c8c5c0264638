"""Distances between point sets: how much sooner than pytcl, than SciPy, than lapx?

python benches/bench_point_sets.py [--save] [--simd avx2] [--threads 2]

The scene: n targets in a box, nine in ten found within some metres, the others replaced by clutter.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from pytcl.performance_evaluation import track_metrics as pytcl
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

import trackmetrics
from harness import Bench

C = 100.0


def scene(n: int, rng: np.random.Generator, box: float = 1000.0, noise: float = 5.0) -> Any:
    """Truth and estimates of one frame."""
    truth = rng.uniform(0, box, (n, 2))
    is_found = rng.random(n)[:, None] < 0.9
    clutter = rng.uniform(0, box, (n, 2))
    return truth, np.where(is_found, truth + rng.normal(0, noise, (n, 2)), clutter)


def bench_one_frame(bench: Bench) -> None:
    rng = np.random.default_rng(1)
    for n, target in ((2, 25), (10, 250), (50, 1500)):
        x, y = scene(n, rng)
        lists = [[row.copy() for row in points] for points in (x, y)]
        assert np.allclose(trackmetrics.ospa(*lists), pytcl.ospa(*lists), rtol=1e-12)
        bench.compare(
            f"ospa, lists, n = {n}",
            lambda s=lists: trackmetrics.ospa(*s),
            {"pytcl": lambda s=lists: pytcl.ospa(*s)},
            target=target,
        )
        bench.compare(
            f"ospa, arrays, n = {n}",
            lambda s=(x, y): trackmetrics.ospa(*s),
            {"NumPy + SciPy": lambda s=(x, y): ospa_by_scipy(*s)},
        )


def bench_over_time(bench: Bench) -> None:
    rng = np.random.default_rng(2)
    frames = [scene(10, rng) for _ in range(1000)]
    lists = [[[row.copy() for row in frame[k]] for frame in frames] for k in (0, 1)]
    packed = [pack([frame[k] for frame in frames]) for k in (0, 1)]
    expected = pytcl.ospa_over_time(*lists)
    for form in (lists, packed):
        assert np.allclose(trackmetrics.ospa_over_time(*form), expected, rtol=1e-12)
    for what, form, target in (("lists", lists, 450), ("packed", packed, 1000)):
        bench.compare(
            f"ospa_over_time, {what}, 1000 frames x 10",
            lambda s=form: trackmetrics.ospa_over_time(*s),
            {"pytcl": lambda: pytcl.ospa_over_time(*lists)},
            target=target,
            seconds=8,
            rounds=5,
        )


def bench_packed(bench: Bench) -> None:
    """OSPA and GOSPA per frame, against a loop over SciPy and against lapx in one batch."""
    rng = np.random.default_rng(3)
    for n, target in ((10, 40), (50, 16)):
        frames = [scene(n, rng) for _ in range(1000)]
        stacks = [np.stack([frame[k] for frame in frames]) for k in (0, 1)]
        packed = [pack(list(stack)) for stack in stacks]
        for name, ours in (("ospa", ospa_packed), ("gospa", gospa_packed)):
            loop = {"ospa": ospa_by_scipy, "gospa": gospa_by_scipy}[name]
            peers = {"NumPy + SciPy": lambda f=frames, g=loop: [g(x, y) for x, y in f]}
            targets = {"NumPy + SciPy": target, "lapx batch": 6}
            peers |= lapx_batch(*stacks, name)
            for peer in peers.values():
                assert np.allclose(ours(*packed), peer(), rtol=1e-9)
            bench.compare(
                f"{name}_over_time, packed, 1000 frames x {n}",
                lambda s=packed, f=ours: f(*s),
                peers,
                target=targets,
                seconds=4,
                rounds=9,
            )


def bench_large(bench: Bench) -> None:
    rng = np.random.default_rng(4)
    medians = {}
    for n in (1000, 10_000, 100_000):
        box = np.sqrt(n * np.pi * C**2 / 3)  # three neighbours within the cutoff
        x, y = scene(n, rng, box, C / 4)
        for name in ("ospa", "gospa"):
            ours = {"ospa": ospa_of, "gospa": gospa_of}[name]
            what = f"{name}, n = {n}, 3 neighbours within c"
            if n == 10_000:
                bipartite = {"ospa": ospa_by_bipartite, "gospa": gospa_by_bipartite}[name]
                assert np.isclose(ours(x, y), bipartite(x, y), rtol=1e-12)
                bench.compare(
                    what,
                    lambda f=ours, s=(x, y): f(*s),
                    {"min_weight_full_bipartite_matching": lambda f=bipartite, s=(x, y): f(*s)},
                    target=60,
                    seconds=3,
                    rounds=3,
                )
            bench.compare(
                what,
                lambda f=ours, s=(x, y): f(*s),
                {"k-d tree, edges only": lambda s=(x, y): edges(*s)},
                target=2 if n == 100_000 else None,
                seconds=4,
                rounds=7,
            )
            row = bench.rows[-1] if bench.rows else None
            if row is not None and row.what == what:
                medians[name, n] = row.ours
    for name in ("ospa", "gospa"):
        if (name, 100_000) in medians and (name, 1000) in medians:
            growth = medians[name, 100_000] / medians[name, 1000] / 100
            bench.report(f"{name}: growth from 1 000 to 100 000 beyond linear", growth, "times")


def pack(frames: list[Any]) -> Any:
    return np.concatenate(frames), np.cumsum([0, *map(len, frames)])


def ospa_of(x: Any, y: Any) -> float:
    return trackmetrics.ospa(x, y, C).ospa


def gospa_of(x: Any, y: Any) -> float:
    return trackmetrics.gospa(x, y, C).distance


def ospa_packed(x: Any, y: Any) -> Any:
    return trackmetrics.ospa_over_time(x, y, C)


def gospa_packed(x: Any, y: Any) -> Any:
    return trackmetrics.gospa_over_time(x, y, C).distance


def total_by_scipy(x: Any, y: Any) -> float:
    costs = np.minimum(cdist(x, y, "sqeuclidean"), C * C)
    return costs[linear_sum_assignment(costs)].sum()


def ospa_by_scipy(x: Any, y: Any) -> float:
    """What a skilled user writes for sets of equal size."""
    return (total_by_scipy(x, y) / len(x)) ** 0.5


def gospa_by_scipy(x: Any, y: Any) -> float:
    return total_by_scipy(x, y) ** 0.5


def lapx_batch(x: Any, y: Any, name: str) -> dict[str, Callable[[], Any]]:
    """lapx with its limit, which leaves two points alone for c^2, where it is installed."""
    try:
        from lap import lapjvr_batch
    except ImportError:
        return {}

    def run() -> Any:
        costs = ((x[:, :, None] - y[:, None]) ** 2).sum(-1)
        totals, rows, _ = lapjvr_batch(costs, cost_limit=C * C, n_threads=1)
        n = x.shape[1]
        alone = np.array([n - len(matched) for matched in rows])
        return np.sqrt((np.asarray(totals) + alone * C * C) / (n if name == "ospa" else 1))

    return {"lapx batch": run}


def edges(x: Any, y: Any) -> Any:
    return cKDTree(x).sparse_distance_matrix(cKDTree(y), C, output_type="coo_matrix")


def total_by_bipartite(x: Any, y: Any) -> float:
    """Edges by a k-d tree, and for each point a column of its own in which it stays alone."""
    near, n = edges(x, y), len(x)
    rows = np.concatenate([near.row, np.arange(n)])
    columns = np.concatenate([near.col, len(y) + np.arange(n)])
    costs = np.concatenate([near.data**2, np.full(n, C * C)])
    # An explicit zero would be no edge; one more for every row changes no assignment.
    graph = csr_matrix((costs + 1, (rows, columns)), shape=(n, len(y) + n))
    pairs = min_weight_full_bipartite_matching(graph)
    return float(np.asarray(graph[pairs]).sum()) - n


def ospa_by_bipartite(x: Any, y: Any) -> float:
    return (total_by_bipartite(x, y) / len(x)) ** 0.5


def gospa_by_bipartite(x: Any, y: Any) -> float:
    return total_by_bipartite(x, y) ** 0.5


if __name__ == "__main__":
    bench = Bench("point_sets")
    bench_one_frame(bench)
    bench_over_time(bench)
    bench_packed(bench)
    bench_large(bench)
    bench.finish()
