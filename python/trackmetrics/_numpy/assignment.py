"""The linear assignment problem of a dense cost matrix: twin of ``assignment::dense``."""

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats


def solve(costs: Floats) -> NDArray[np.int64]:
    """The column of each row at the least total cost, -1 for a row without one.

    Shortest augmenting paths with ties as in SciPy; see the core for the algorithm and its source.
    """
    if np.isnan(costs).any() or np.isneginf(costs).any():
        raise errors.invalid_costs()
    rows, columns = costs.shape
    if columns >= rows:
        return _solve_wide(costs)[0]
    return _solve_wide(np.ascontiguousarray(costs.T))[1]


def _solve_wide(costs: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    rows, columns = costs.shape
    u, v = np.zeros(rows), np.zeros(columns)
    column_of_row, row_of_column = np.full(rows, -1), np.full(columns, -1)
    for row in range(rows):
        sink, length, distance, previous, reached = _shortest_path(costs, row, u, v, row_of_column)
        inner = reached[:-1]
        u[row] += length
        for j in inner:
            u[row_of_column[j]] += length - distance[j]
        for j in reached:
            v[j] -= length - distance[j]
        j = sink
        while True:
            i = previous[j]
            row_of_column[j] = i
            column_of_row[i], j = j, column_of_row[i]
            if i == row:
                break
    return column_of_row, row_of_column


def _shortest_path(
    costs: Floats, row: int, u: Floats, v: Floats, row_of_column: NDArray[np.int64]
) -> tuple[int, float, Floats, NDArray[np.int64], list[int]]:
    """The nearest free column along reduced costs, and the columns reached on the way."""
    columns = costs.shape[1]
    remaining = np.arange(columns)[::-1].copy()
    distance, previous = np.full(columns, np.inf), np.full(columns, -1)
    reached: list[int] = []
    i, length = row, 0.0
    while True:
        through = length + costs[i, remaining] - u[i] - v[remaining]
        shorter = through < distance[remaining]
        distance[remaining[shorter]] = through[shorter]
        previous[remaining[shorter]] = i
        length = distance[remaining].min()
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
            return j, float(length), distance, previous, reached
        i = int(row_of_column[j])
