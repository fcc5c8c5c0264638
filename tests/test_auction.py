"""The auction's bound, against the exact solver, brute force (SciPy) and the reference."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment as scipy_assignment

import trackmetrics
from trackmetrics import _native, _numpy, auction


def total(costs, pairs):
    return math.fsum(costs[pairs[0], pairs[1]])


@st.composite
def matrices(draw):
    n, m = draw(st.tuples(st.integers(0, 6), st.integers(0, 6)))
    entries = draw(
        st.sampled_from(
            [
                st.integers(-3, 3).map(float),
                st.integers(-(10**6), 10**6).map(float),
                st.sampled_from([0.0, 1.0, math.inf]),
                st.floats(-1.0, 1.0),
                st.floats(1e-12, 1e-11),
                st.floats(-1e12, 1e12),
            ]
        )
    )
    return np.array(draw(st.lists(entries, min_size=n * m, max_size=n * m))).reshape(n, m)


@given(matrices(), st.sampled_from([None, 0.3, 0.001]), st.booleans())
def test_the_bound_holds_and_kernel_and_reference_agree(costs, relative, maximize):
    costs = -costs if maximize else costs
    largest = np.abs(costs[np.isfinite(costs)]).max(initial=0.0)
    epsilon = None if relative is None else relative * (largest or 1.0)
    try:
        best = total(costs, scipy_assignment(costs, maximize))
    except ValueError:
        for kernels in (_native, _numpy):
            with pytest.raises(ValueError, match=r"^cost matrix is infeasible$"):
                kernels.auction(costs, epsilon, maximize)
        return
    rows, columns, last, bound = _native.auction(costs, epsilon, maximize)
    assert len(rows) == len(set(columns.tolist())) == min(costs.shape)
    assert rows.tolist() == sorted(rows.tolist())
    assert last == (epsilon or last)
    rounding = 1e-14 * largest * max(costs.shape)
    assert 0 <= bound <= max(costs.shape) * last + rounding
    assert abs(total(costs, (rows, columns)) - best) <= bound + 1e-16 * largest
    reference = _numpy.auction(costs, epsilon, maximize)
    np.testing.assert_array_equal(rows, reference[0])
    np.testing.assert_array_equal(columns, reference[1])
    assert reference[2:] == pytest.approx((last, bound), rel=1e-9, abs=rounding)


@pytest.mark.parametrize("shape", [(60, 60), (40, 90), (90, 40)])
def test_whole_numbers_are_solved_to_the_optimum(shape):
    rng = np.random.default_rng(8)
    for most in (2, 100, 10**6):
        costs = rng.integers(0, most, shape)
        for maximize in (False, True):
            result = auction(costs, maximize=maximize)
            assert result.bound == 0.0
            best = costs[scipy_assignment(costs, maximize)].sum()
            assert costs[result.row_ind, result.col_ind].sum() == best


def test_points_with_forbidden_pairs():
    rng = np.random.default_rng(9)
    costs = np.linalg.norm(rng.random((80, 1, 2)) - rng.random((1, 80, 2)), axis=-1)
    costs[rng.random(costs.shape) < 0.6] = math.inf
    best = total(costs, scipy_assignment(costs))
    result = auction(costs)
    assert result.bound <= 1.01e-6 * costs[np.isfinite(costs)].max()
    assert best <= total(costs, (result.row_ind, result.col_ind)) <= best + result.bound


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_what_is_wrong_is_said(backend):
    with trackmetrics.use_backend(backend):
        for epsilon in (0, -1.0, math.nan, math.inf):
            with pytest.raises(ValueError, match=r"^epsilon must be positive and finite, got"):
                auction([[1.0]], epsilon)
        with pytest.raises(
            ValueError, match=r"^epsilon must be at least 1e-12 \(and 1e-15 a row\)"
        ):
            auction([[1.0]], 1e-13)
        with pytest.raises(
            ValueError, match=r"^cost_matrix must be so small that its elements can"
        ):
            auction([[1e308]])
        with pytest.raises(ValueError, match=r"^expected a matrix"):
            auction([1.0])
        result = auction([[0.5]])
        assert [type(value) for value in (result.epsilon, result.bound)] == [float, float]
        assert sorted(result.to_dict()) == ["bound", "col_ind", "epsilon", "row_ind"]
