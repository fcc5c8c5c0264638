"""How fast is the assignment, against SciPy and lapx?

The costs a tracker meets: uniform, distances between points, distances cut off where a point has
three neighbours, and whole numbers 0 to 100; square, and with 0.8 as many rows as columns. Where
lapx is installed its two fastest solvers are measured too (their ties are not SciPy's).

    python benches/bench_assignment.py --only geometric
"""

import math
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment as scipy_assignment

import trackmetrics
from harness import Bench
from trackmetrics import (
    auction,
    bottleneck_assignment,
    linear_sum_assignment,
    linear_sum_assignment_batch,
)

SIZES = (10, 20, 50, 100, 200, 500, 1000, 2000)
KINDS = ("uniform", "geometric", "truncated", "integers")
TIED = ("truncated", "integers")


def matrix(kind: str, n: int, m: int, rng: np.random.Generator) -> np.ndarray:
    """Costs of n rows and m columns."""
    if kind == "uniform":
        return rng.random((n, m))
    if kind == "integers":
        return rng.integers(0, 101, (n, m)).astype(float)
    x, y = rng.random((n, 1, 2)), rng.random((1, m, 2))
    distances = np.sqrt(((x - y) ** 2).sum(axis=-1))
    return distances if kind == "geometric" else np.minimum(distances, math.sqrt(3 / math.pi / m))


def lapx_solvers() -> dict[str, Callable[[np.ndarray], Any]]:
    """The two solvers of lapx that are fastest, where it is installed."""
    solvers: dict[str, Callable[[np.ndarray], Any]] = {}
    try:
        lapjvr = import_module("lap").lapjvr
        solvers["lapx.lapjvr"] = lambda costs: lapjvr(costs, extend_cost=True, return_cost=True)
    except (ImportError, AttributeError):
        pass
    try:
        laprust = import_module("laprust").lapjv
        solvers["laprust"] = lambda costs: laprust(costs)
    except (ImportError, AttributeError):
        pass
    return solvers


def wanted(kind: str, n: int, peers: list[str]) -> dict[str, float]:
    """The least ratios: SciPy everywhere, lapx where ties do not decide."""
    scipy = 1.0 if n < 50 else 2.5 if n <= 500 else 2.0
    lapx = {} if kind in TIED else {peer: 1.0 for peer in peers if peer != "scipy"}
    return {"scipy": scipy, **lapx}


def single(bench: Bench) -> None:
    """One matrix a call."""
    lapx = lapx_solvers()
    for kind in KINDS:
        for n in SIZES:
            for m in (n, n * 5 // 4):
                rng = np.random.default_rng([KINDS.index(kind), n, m])
                costs = [matrix(kind, n, m, rng) for _ in range(8 if n <= 200 else 2)]
                for one in costs:
                    np.testing.assert_array_equal(linear_sum_assignment(one), scipy_assignment(one))
                peers = {"scipy": scipy_assignment, **(lapx if n == m else {})}
                bench.compare(
                    f"{kind} {n} x {m}, {len(costs)} matrices",
                    lambda costs=costs: [linear_sum_assignment(one) for one in costs],
                    {
                        name: lambda costs=costs, solve=solve: [solve(one) for one in costs]
                        for name, solve in peers.items()
                    },
                    wanted(kind, n, list(peers)),
                    seconds=2.0 if n <= 500 else 6.0,
                    rounds=15 if n <= 500 else 7,
                )


def batch(bench: Bench) -> None:
    """Many matrices a call."""
    costs = np.random.default_rng(1).random((10_000, 20, 20))
    rows, columns = linear_sum_assignment_batch(costs)
    for b in range(0, len(costs), 101):
        np.testing.assert_array_equal([rows[b], columns[b]], scipy_assignment(costs[b]))
    bench.compare(
        "batch of 10 000 matrices 20 x 20",
        lambda: linear_sum_assignment_batch(costs),
        {"scipy loop": lambda: [scipy_assignment(one) for one in costs]},
        3.0,
        seconds=4.0,
    )
    if bench.options.threads > 1:
        bench.compare(
            f"the same with {bench.options.threads} threads",
            lambda: linear_sum_assignment_batch(costs),
            {"one thread": lambda: _on_one_thread(bench, costs)},
            1.6,
            seconds=4.0,
        )


def _on_one_thread(bench: Bench, costs: np.ndarray) -> Any:
    trackmetrics.set_threads(1)
    try:
        return linear_sum_assignment_batch(costs)
    finally:
        trackmetrics.set_threads(bench.options.threads)


def others(bench: Bench) -> None:
    """The auction and the bottleneck, against our own solver of the least sum."""
    for kind in ("geometric", "integers"):
        for n in (100, 500):
            costs = matrix(kind, n, n, np.random.default_rng(n))
            pairs, result = linear_sum_assignment(costs), auction(costs)
            difference = costs[result.row_ind, result.col_ind].sum() - costs[pairs].sum()
            assert -1e-9 <= difference <= result.bound + 1e-9
            bottleneck = bottleneck_assignment(costs)
            assert bottleneck.cost <= costs[pairs].max()
            ours = {"linear_sum_assignment": lambda costs=costs: linear_sum_assignment(costs)}
            bench.compare(f"auction, {kind} {n} x {n}", lambda costs=costs: auction(costs), ours)
            bench.compare(
                f"bottleneck, {kind} {n} x {n}",
                lambda costs=costs: bottleneck_assignment(costs),
                ours,
            )


if __name__ == "__main__":
    bench = Bench("assignment")
    single(bench)
    batch(bench)
    others(bench)
    bench.finish()
