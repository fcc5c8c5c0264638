"""Who is matched with whom: twin of ``assignment`` in the core."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, plain

Indices = NDArray[np.int64]


def linear_sum_assignment(cost_matrix: Floats, maximize: object) -> tuple[Indices, Indices]:
    """The pairs of least (or largest) total cost, ties as in SciPy."""
    _matrix(cost_matrix)
    return pairs(solve(-cost_matrix if maximize else cost_matrix))


def bottleneck_assignment(cost_matrix: Floats) -> tuple[float, Indices, Indices]:
    """The pairs whose largest cost is the smallest, and that cost."""
    _matrix(cost_matrix)
    value, columns = solve_bottleneck(cost_matrix)
    return value, *pairs(columns)


def _matrix(costs: Floats) -> None:
    plain(costs)
    if costs.ndim != 2:
        raise errors.NotPlain


def pairs(column_of_row: Indices) -> tuple[Indices, Indices]:
    """The matched rows in rising order, and their columns."""
    rows = np.flatnonzero(column_of_row >= 0)
    return rows, column_of_row[rows]


def check_costs(costs: Floats) -> None:
    """Refuse what no assignment can use."""
    if np.isnan(costs).any() or np.isneginf(costs).any():
        raise errors.invalid_costs()


def solve(costs: Floats) -> Indices:
    """The column of each row at the least total cost, -1 for a row without one.

    Shortest augmenting paths with ties as in SciPy; see the core for the algorithm and its source.
    """
    check_costs(costs)
    rows, columns = costs.shape
    # Costs near the largest float overflow on the way, as they do in SciPy.
    with np.errstate(over="ignore", invalid="ignore"):
        if columns >= rows:
            return _solve_wide(costs)[0]
        return _solve_wide(np.ascontiguousarray(costs.T))[1]


def solve_bottleneck(costs: Floats) -> tuple[float, Indices]:
    """The smallest largest cost of a complete matching, and the column of each row (or -1)."""
    check_costs(costs)
    rows, columns = costs.shape
    if columns >= rows:
        value, column_of_row, _ = _solve_bottleneck_wide(costs)
        return value, column_of_row
    value, _, row_of_column = _solve_bottleneck_wide(np.ascontiguousarray(costs.T))
    return value, row_of_column


def _solve_bottleneck_wide(costs: Floats) -> tuple[float, Indices, Indices]:
    rows, columns = costs.shape
    column_of_row, row_of_column = np.full(rows, -1), np.full(columns, -1)
    if rows == 0:
        return np.nan, column_of_row, row_of_column
    bound = float(costs.min(axis=1).max())

    def through(length: float, i: int, j: Indices) -> Floats:
        highest: Floats = np.maximum(costs[i, j], length)
        return highest

    for row in range(rows):
        sink, bound, _, previous, _ = _shortest_path(row, bound, row_of_column, through)
        augment(row, sink, previous, column_of_row, row_of_column)
    return bound, column_of_row, row_of_column


def augment(
    row: int, sink: int, previous: Indices, column_of_row: Indices, row_of_column: Indices
) -> None:
    """Turn the path from ``row`` to ``sink`` into matched pairs."""
    j = sink
    while True:
        i = previous[j]
        row_of_column[j] = i
        column_of_row[i], j = j, column_of_row[i]
        if i == row:
            return


def _solve_wide(costs: Floats) -> tuple[Indices, Indices]:
    rows, columns = costs.shape
    u, v = np.zeros(rows), np.zeros(columns)
    column_of_row, row_of_column = np.full(rows, -1), np.full(columns, -1)

    def through(length: float, i: int, j: Indices) -> Floats:
        reduced: Floats = length + costs[i, j] - u[i] - v[j]
        return reduced

    for row in range(rows):
        sink, length, distance, previous, reached = _shortest_path(row, 0.0, row_of_column, through)
        u[row] += length
        for j in reached[:-1]:
            u[row_of_column[j]] += length - distance[j]
        for j in reached:
            v[j] -= length - distance[j]
        augment(row, sink, previous, column_of_row, row_of_column)
    return column_of_row, row_of_column


def _shortest_path(
    row: int,
    length: float,
    row_of_column: Indices,
    through: Callable[[float, int, Indices], Floats],
) -> tuple[int, float, Floats, Indices, list[int]]:
    """The nearest free column, its distance, and the columns reached on the way.

    ``through(length, i, columns)`` are the lengths of a path of this length to row i and then to
    these columns.
    """
    columns = len(row_of_column)
    remaining = np.arange(columns)[::-1].copy()
    distance, previous = np.full(columns, np.inf), np.full(columns, -1)
    reached: list[int] = []
    i = row
    while True:
        lengths = through(length, i, remaining)
        shorter = lengths < distance[remaining]
        distance[remaining[shorter]] = lengths[shorter]
        previous[remaining[shorter]] = i
        length = float(distance[remaining].min())
        if length == np.inf:
            raise errors.infeasible()
        # The first minimum, unless a free column ties with it: then the last of those.
        nearest = np.flatnonzero(distance[remaining] == length)
        free = nearest[row_of_column[remaining[nearest]] < 0]
        index = free[-1] if len(free) else nearest[0]
        j = int(remaining[index])
        remaining[index] = remaining[-1]
        remaining = remaining[:-1]
        reached.append(j)
        if row_of_column[j] < 0:
            return j, length, distance, previous, reached
        i = int(row_of_column[j])
