"""Assignment: reference implementation of ``assignment`` in the core."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._numpy.arguments import Floats, plain, plain_numbers

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


def linear_sum_assignment_batch(costs: Any, maximize: object) -> Any:
    """The pairs of many matrices: arrays for an array, a list of pairs of arrays for a list."""
    listed = type(costs) is list
    if not listed:
        plain(costs)
        if costs.ndim != 3:
            raise errors.NotPlain
    found = []
    for index, matrix in enumerate(costs):
        _matrix(matrix)
        try:
            found.append(linear_sum_assignment(matrix, maximize))
        except ValueError as error:
            raise errors.in_matrix(index, error) from None
    if listed:
        return found
    shape = len(costs), min(costs.shape[1:])
    rows, columns = (
        np.array([pairs[part] for pairs in found], dtype=np.int64).reshape(shape) for part in (0, 1)
    )
    return rows, columns


def auction(
    cost_matrix: Floats, epsilon: float | None, maximize: object
) -> tuple[Indices, Indices, float, float]:
    """A matching within a bound of the best one, by Bertsekas' auction with epsilon scaling."""
    plain_numbers(0.0 if epsilon is None else epsilon)
    _matrix(cost_matrix)
    rows, columns = cost_matrix.shape
    tall = rows > columns
    costs = -cost_matrix if maximize else cost_matrix
    costs = costs.T if tall else costs
    solve_bottleneck(costs)
    size = max(rows, columns)
    finite = costs[np.isfinite(costs)]
    largest, whole = float(np.abs(finite).max(initial=0.0)), bool((finite % 1 == 0).all())
    if not 64.0 * largest * size < np.inf:
        raise errors.parameter("cost_matrix", "so small that its elements can be added", largest)
    last = _final_epsilon(epsilon, size, largest, whole)
    square = np.vstack([costs, np.zeros((size - len(costs), size))])
    price, epsilon = np.zeros(size), max(largest / 2, last)
    while True:
        row_of_column = _auction(square, price, epsilon, largest)
        if epsilon <= last:
            break
        epsilon = max(epsilon / 5, last)
    bound = _bound(square, price, row_of_column, largest)
    matched = np.flatnonzero(row_of_column < len(costs))
    i, j = row_of_column[matched], matched
    i, j = (j, i) if tall else (i, j)
    order = np.argsort(i)
    return i[order], j[order], last, 0.0 if bound == 0 or (whole and bound < 1) else bound


def _final_epsilon(epsilon: float | None, size: int, largest: float, whole: bool) -> float:
    # Prices reach size * largest, and have 52 bits.
    least = largest * max(1e-12, 1e-15 * size)
    size = max(size, 1)
    if epsilon is None:
        return max(1 / (size + 1) if whole or largest == 0 else 1e-6 * largest / size, least)
    if not (epsilon > 0 and np.isfinite(epsilon)):
        raise errors.parameter("epsilon", "positive and finite", epsilon)
    if epsilon < least:
        requirement = "at least 1e-12 (and 1e-15 a row) of the largest cost"
        raise errors.parameter("epsilon", requirement, epsilon)
    return float(epsilon)


def _auction(costs: Floats, price: Floats, epsilon: float, largest: float) -> Indices:
    """Rows bid for columns until each has one; ``price`` rises."""
    size = len(costs)
    row_of_column, free = np.full(size, -1), list(range(size))[::-1]
    while free:
        i = free.pop()
        values = costs[i] + price
        j = int(np.argmin(values))
        lowest, values[j] = values[j], np.inf
        second = values.min()
        # A row with one column only can pay any price.
        price[j] += (second - lowest if second < np.inf else largest) + epsilon
        if row_of_column[j] >= 0:
            free.append(int(row_of_column[j]))
        row_of_column[j] = i
    return row_of_column


def _bound(costs: Floats, price: Floats, row_of_column: Indices, largest: float) -> float:
    """What the rows pay more than in their best columns, and what sums may lose by rounding."""
    size = len(costs)
    scale = max(largest, float(np.abs(price).max(initial=0.0)))
    bound = 0.0
    for j, i in enumerate(row_of_column):
        bound += float(costs[i, j] + price[j] - (costs[i] + price).min())
    return bound + 2 * float(np.finfo(float).eps) * scale * size


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
