"""The bottleneck assignment against brute force and its reference implementation."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

import trackmetrics
from trackmetrics import _native, _numpy, bottleneck_assignment


def brute_force(costs):
    """The smallest largest cost over every matching of the shorter side."""
    n, m = costs.shape
    if n > m:
        costs, n, m = costs.T, m, n
    chosen = itertools.permutations(range(m), n)
    return min(max(costs[i, j] for i, j in enumerate(columns)) for columns in chosen)


@st.composite
def matrices(draw):
    n, m = draw(st.tuples(st.integers(1, 5), st.integers(1, 5)))
    entries = draw(
        st.sampled_from(
            [
                st.integers(-3, 3).map(float),
                st.sampled_from([-0.0, 0.0, 1.0]),
                st.floats(-1e300, 1e300),
                st.sampled_from([1e-12, 1e12, math.inf]),
            ]
        )
    )
    return np.array(draw(st.lists(entries, min_size=n * m, max_size=n * m))).reshape(n, m)


@given(matrices())
def test_kernel_reference_and_definition_agree(costs):
    expected = brute_force(costs)
    if expected == math.inf:
        for solve in (_native.bottleneck_assignment, _numpy.bottleneck_assignment):
            with pytest.raises(ValueError, match=r"^cost matrix is infeasible$"):
                solve(costs)
        return
    value, rows, columns = _native.bottleneck_assignment(costs)
    assert value == expected == costs[rows, columns].max()
    assert len(rows) == len(set(columns.tolist())) == min(costs.shape)
    reference_value, reference_rows, reference_columns = _numpy.bottleneck_assignment(costs)
    assert reference_value == value
    np.testing.assert_array_equal(rows, reference_rows)
    np.testing.assert_array_equal(columns, reference_columns)


@pytest.mark.parametrize("shape", [(40, 40), (30, 90), (90, 30), (1, 50)])
@pytest.mark.parametrize("levels", [3, 50, 10**9])
def test_larger_matrices_by_feasibility(shape, levels):
    """The value is feasible, and the next smaller cost is not: no sum of indicators is 0."""
    costs = np.random.default_rng(levels).integers(0, levels, shape).astype(float)
    result = bottleneck_assignment(costs)
    assert costs[result.row_ind, result.col_ind].max() == result.cost
    assert len(set(result.col_ind.tolist())) == min(shape)
    rows, columns = linear_sum_assignment(costs >= result.cost)
    assert (costs >= result.cost)[rows, columns].any()
    reference = _numpy.bottleneck_assignment(costs)
    assert reference[0] == result.cost
    np.testing.assert_array_equal(reference[2], result.col_ind)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_without_pairs_there_is_no_cost(backend):
    with trackmetrics.use_backend(backend):
        for shape in [(0, 0), (0, 3), (3, 0)]:
            result = bottleneck_assignment(np.zeros(shape))
            assert math.isnan(result.cost)
            assert result.row_ind.tolist() == result.col_ind.tolist() == []


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_forms_and_errors_are_those_of_the_linear_sum(backend):
    with trackmetrics.use_backend(backend):
        assert bottleneck_assignment(np.array([[3, 1], [2, 5]]).T).cost == 2.0
        assert bottleneck_assignment([[True, False]]).to_dict()["cost"] == 0.0
        assert type(bottleneck_assignment([[1]]).cost) is float
        for costs, text in [
            ([1, 2], r"expected a matrix \(2-D array\), got a 1 array"),
            ([[math.nan]], "matrix contains invalid numeric entries"),
            ([[-math.inf]], "matrix contains invalid numeric entries"),
            ([[math.inf, math.inf], [1, 2]], "cost matrix is infeasible"),
        ]:
            with pytest.raises(ValueError, match=f"^{text}$"):
                bottleneck_assignment(costs)
