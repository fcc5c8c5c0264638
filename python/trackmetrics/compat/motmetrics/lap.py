"""py-motmetrics' assignment: as many pairs as possible, and of these the least total cost.

py-motmetrics chooses among installed solvers. Here every one of its solvers' names is our own
solver, which gives SciPy's pairs; a callable of one's own is used as it is.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import assignment

Pairs = tuple[NDArray[np.int64], NDArray[np.int64]]
Solver = Callable[[Any], Any]


def linear_sum_assignment(costs: Any, solver: str | Solver | None = None) -> Pairs:
    """The largest matching of least total cost.

    Parameters
    ----------
    costs : array_like of shape (n, m)
        NaN or infinite where a pair may not be.
    solver : str or callable, optional
        A name of py-motmetrics' (``"scipy"``, ``"lap"``, ...: the same solver here) or a function
        of the costs that returns rows and columns; ``default_solver`` where it is None.

    Returns
    -------
    rids, cids : ndarray of int64
        Rows and columns of the pairs.

    Raises
    ------
    AssertionError
        Where ``solver`` is no known name (py-motmetrics' type of error).
    """
    costs = np.asarray(costs)
    if not costs.size:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    chosen = solver or default_solver
    function = solver_map.get(chosen) if isinstance(chosen, str) else chosen
    if not callable(function):
        raise AssertionError(f"solver must be callable or one of {list(solver_map)}, got {chosen}")
    rows, columns = function(costs)
    return np.asarray(rows).astype(np.int64), np.asarray(columns).astype(np.int64)


def add_expensive_edges(costs: NDArray[Any]) -> NDArray[Any]:
    """A copy with a cost in place of NaN and infinity that no assignment of least cost takes where
    it can have one more pair instead; all zeros where no pair is allowed."""
    valid = np.isfinite(costs)
    if valid.all():
        return costs.copy()
    if not valid.any():
        return np.zeros_like(costs)
    largest = np.abs(costs[valid]).max() + 1
    return np.where(valid, costs, 2 * min(costs.shape) * largest + 1)


def _solve(costs: Any) -> Pairs:
    costs = np.asarray(costs)
    rows, columns = assignment.linear_sum_assignment(add_expensive_edges(costs))
    kept = np.isfinite(costs[rows, columns])
    return rows[kept], columns[kept]


lsa_solve_scipy = lsa_solve_lapjv = lsa_solve_lapsolver = _solve
lsa_solve_munkres = lsa_solve_ortools = _solve

solver_map: dict[str, Solver] = {
    "trackmetrics": _solve,
    "lapsolver": lsa_solve_lapsolver,
    "lap": lsa_solve_lapjv,
    "scipy": lsa_solve_scipy,
    "munkres": lsa_solve_munkres,
    "ortools": lsa_solve_ortools,
}
available_solvers = ["trackmetrics"]
default_solver: str | Solver = "trackmetrics"


@contextmanager
def set_default_solver(newsolver: str | Solver) -> Iterator[None]:
    """Use another solver within a ``with`` block."""
    global default_solver
    before = default_solver
    try:
        default_solver = newsolver
        yield
    finally:
        default_solver = before
