"""The RMSE family: kernel, reference and definition; axes, integers, NaN, what is refused."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import _native, _numpy


def definition(x, y, axes):
    """The mean of exact squares, one element after the other."""
    kept = [i for i in range(x.ndim) if i not in axes]
    result = np.empty([x.shape[i] for i in kept])
    for index in np.ndindex(*result.shape):
        where = [slice(None)] * x.ndim
        for i, k in zip(kept, index, strict=True):
            where[i] = k
        errors = (x[tuple(where)] - y[tuple(where)]).ravel()
        result[index] = math.sqrt(math.fsum(errors * errors) / errors.size)
    return result


@st.composite
def problems(draw):
    shape = draw(st.lists(st.integers(1, 12), min_size=1, max_size=4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    scale = 10.0 ** draw(st.integers(-12, 12))
    axes = draw(st.lists(st.sampled_from(range(len(shape))), unique=True))
    x, y = rng.standard_normal((2, *shape)) * scale
    return x, y, axes


@given(problems())
def test_kernel_reference_and_definition_agree(problem):
    x, y, axes = problem
    expected = definition(x, y, axes)
    for kernels in (_native, _numpy):
        got = kernels.rmse(x, y, axes)
        np.testing.assert_allclose(got, expected, rtol=1e-13)
        assert np.shape(got) == expected.shape
        np.testing.assert_array_equal(kernels.monte_carlo_rmse(x - y, axes), got)


@pytest.mark.parametrize("width", ["scalar", "avx2", "widest"])
@pytest.mark.parametrize("d", range(1, 13))
def test_rows_of_every_length(d, width):
    x, y = np.random.default_rng(d).standard_normal((2, 501, d))
    _native.set_simd(width)
    try:
        for axes in (None, [0], [1], [0, 1], []):
            expected = _numpy.rmse(x, y, axes)
            np.testing.assert_allclose(_native.rmse(x, y, axes), expected, rtol=1e-13)
    finally:
        _native.set_simd("widest")


def test_every_axis_that_numpy_accepts():
    x, y = np.random.default_rng(0).standard_normal((2, 3, 4, 5, 2))
    errors = x - y
    choices = [None, 0, -1, np.int64(2), (), (0, 2), (3, 1), (-1, 0), (0, 1, 2, 3)]
    for axis, backend in itertools.product(choices, ("native", "numpy")):
        expected = np.sqrt(np.mean(errors**2, axis=axis))
        with trackmetrics.use_backend(backend):
            np.testing.assert_allclose(trackmetrics.rmse(x, y, axis=axis), expected, rtol=1e-13)
            got = trackmetrics.monte_carlo_rmse(errors, axis=axis)
            np.testing.assert_allclose(got, expected, rtol=1e-13)


def test_the_right_numbers_of_the_documented_examples():
    true = np.array([[0, 0], [1, 1], [2, 2]])
    estimated = np.array([[0.1, -0.1], [1.2, 0.9], [1.8, 2.1]])
    assert trackmetrics.rmse(true, estimated) == pytest.approx(0.1414213562, abs=1e-10)
    expected = [0.17320508, 0.1]
    np.testing.assert_allclose(trackmetrics.rmse(true, estimated, axis=0), expected, atol=1e-8)
    true = np.array([[0, 1, 0, 1], [1, 1, 1, 1]])
    estimated = np.array([[0.1, 1, -0.1, 1], [1.2, 1, 0.9, 1]])
    assert trackmetrics.position_rmse(true, estimated, [0, 2]) == pytest.approx(0.1322875656)
    true = np.array([[0, 10, 0, 5], [1, 10, 0.5, 5]])
    estimated = np.array([[0, 9.5, 0, 5.2], [1, 10.2, 0.5, 4.9]])
    assert trackmetrics.velocity_rmse(true, estimated, [1, 3]) == pytest.approx(0.2915475947)


def test_integers_never_overflow():
    for dtype in (np.int8, np.uint8, np.int16, np.uint64, bool):
        zero, most = np.zeros(3, dtype), np.ones(3, dtype) * dtype(100)
        assert trackmetrics.rmse(zero, most) == float(most[0])
        assert trackmetrics.rmse(most, zero) == float(most[0])
        assert trackmetrics.monte_carlo_rmse(most) == float(most[0])


def test_nan_propagates_to_where_it_belongs():
    x = np.array([[1.0, np.nan], [3.0, 4.0]])
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            assert np.isnan(trackmetrics.rmse(x, np.zeros((2, 2))))
            got = trackmetrics.rmse(x, np.zeros((2, 2)), axis=1)
            np.testing.assert_allclose(got, [np.nan, np.sqrt(12.5)])
            assert np.isnan(trackmetrics.position_rmse(x, np.zeros((2, 2)), [1]))
            assert trackmetrics.position_rmse(x, np.zeros((2, 2)), [0]) == np.sqrt(5)
            assert trackmetrics.rmse([np.inf], [0.0]) == np.inf
            assert np.isnan(trackmetrics.rmse([np.inf], [np.inf]))


def test_numbers_are_python_numbers():
    assert type(trackmetrics.rmse([1.0], [2.0])) is float
    assert type(trackmetrics.rmse(1.0, 2.0)) is float
    assert type(trackmetrics.monte_carlo_rmse([1.0])) is float
    assert type(trackmetrics.position_rmse([[1.0]], [[2.0]], [0])) is float


MASK = np.array([True, False, True, False])


@pytest.mark.parametrize(
    "indices", [[0, 2], (0, 2), np.array([0, 2]), [0, -2], slice(0, 3, 2), MASK]
)
def test_indices_as_users_hold_them(indices):
    x, y = np.random.default_rng(4).standard_normal((2, 5, 6, 4))
    for function in (trackmetrics.position_rmse, trackmetrics.velocity_rmse):
        expected = np.sqrt(np.mean((x - y)[..., [0, 2]] ** 2))
        assert function(x, y, indices) == pytest.approx(expected, rel=1e-13)
        expected = np.sqrt(np.mean((x - y)[..., 1] ** 2))
        assert function(x.tolist(), y.tolist(), 1) == pytest.approx(expected, rel=1e-13)


X = np.zeros((3, 2))
REFUSED = [
    (trackmetrics.rmse, (X, X[:2]), "estimated_states has shape (2, 2), expected (3, 2)"),
    (trackmetrics.rmse, (X, X[0]), "estimated_states has shape (2,), expected (3, 2)"),
    (trackmetrics.rmse, (X[:, :1], X[:, 0]), "estimated_states has shape (3,), expected (3, 1)"),
    (trackmetrics.rmse, (X[:0], X[:0]), "true_states is empty"),
    (trackmetrics.rmse, (X[:0], X[:0], 0), "true_states is empty"),
    (trackmetrics.rmse, (X, X, 2), "axis must be among the 2 axes of the array, each once, got 2"),
    (trackmetrics.rmse, (X, X, (0, -2)), "axis must be among the 2 axes of the array, each once"),
    (trackmetrics.monte_carlo_rmse, ([],), "errors is empty"),
    (trackmetrics.monte_carlo_rmse, (X, -3), "axis must be among the 2 axes of the array"),
    (trackmetrics.position_rmse, (X, X, [0, 2]), "position_indices[1] is 2, the state has 2 comp"),
    (trackmetrics.velocity_rmse, (X, X, [-3]), "velocity_indices[0] is -3, the state has 2 comp"),
    (trackmetrics.position_rmse, (X, X, []), "position_indices is empty"),
    (trackmetrics.position_rmse, (X[:0], X[:0], [0]), "true_states is empty"),
    (trackmetrics.position_rmse, (X, X[:1], [0]), "estimated_states has shape (1, 2), expected"),
    (trackmetrics.position_rmse, (1.0, 1.0, [0]), "true_states has shape (), expected (..., d)"),
    (
        trackmetrics.estimation_error_bounds,
        (np.array([[[1.0, 0.0], [0.0, -1.0]]]),),
        "covariances[0][1][1] must be finite and at least 0, got -1.0",
    ),
    (trackmetrics.estimation_error_bounds, (np.ones((2, 3)),), "covariances has shape (2, 3), ex"),
    (trackmetrics.estimation_error_bounds, (np.ones(2),), "covariances has shape (2,), expected"),
    (trackmetrics.estimation_error_bounds, (np.eye(2), np.nan), "sigma must be finite, got nan"),
]


@pytest.mark.parametrize(("function", "arguments", "message"), REFUSED)
def test_what_is_refused_alike_by_both_backends(function, arguments, message):
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend), pytest.raises(ValueError) as caught:  # noqa: PT011
            function(*arguments)
        assert str(caught.value).startswith(message)


def test_complex_numbers_are_refused():
    with pytest.raises(TypeError, match="true_states must hold real numbers"):
        trackmetrics.rmse([1j], [0.0])
    with pytest.raises(TypeError, match="position_indices must be a list of whole numbers"):
        trackmetrics.position_rmse(X, X, [0.5])


def test_error_bounds():
    p = np.array([[[1.0, 0], [0, 4.0]], [[0.25, 0], [0, 1.0]]])
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            got = trackmetrics.estimation_error_bounds(p, sigma=2.0)
            assert got.tolist() == [[2.0, 4.0], [1.0, 2.0]]
            assert trackmetrics.estimation_error_bounds(p[0].tolist()).tolist() == [2.0, 4.0]
            assert trackmetrics.estimation_error_bounds(np.empty((0, 3, 3))).shape == (0, 3)
            assert trackmetrics.estimation_error_bounds(p[None]).shape == (1, 2, 2)


@pytest.mark.peers
def test_random_inputs_against_pytcl():
    from pytcl import performance_evaluation as peer

    rng = np.random.default_rng(2)
    for _ in range(500):
        n, d = int(rng.integers(1, 40)), int(rng.integers(1, 10))
        x, y = rng.standard_normal((2, n, d)) * 10.0 ** rng.integers(-12, 12)
        for axis in (None, 0, 1):
            got = trackmetrics.rmse(x, y, axis)
            np.testing.assert_allclose(got, peer.rmse(x, y, axis), rtol=1e-12)
        indices = [int(i) for i in rng.integers(-d, d, rng.integers(1, d + 1))]
        for name in ("position_rmse", "velocity_rmse"):
            expected = getattr(peer, name)(x, y, indices)
            assert getattr(trackmetrics, name)(x, y, indices) == pytest.approx(expected, rel=1e-12)
        errors = rng.standard_normal((4, n, d))
        for axis in (0, 1, None):
            expected = peer.monte_carlo_rmse(errors, axis)
            got = trackmetrics.monte_carlo_rmse(errors, axis)
            np.testing.assert_allclose(got, expected, rtol=1e-12)
        p = np.abs(rng.standard_normal((n, d, d)))
        got = trackmetrics.estimation_error_bounds(p, 3.0)
        np.testing.assert_allclose(got, peer.estimation_error_bounds(p, 3.0), rtol=1e-15)
