"""NEES and NIS: kernel, reference and exact rational arithmetic; forms of input; refusals."""

import json
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import _native, _numpy

EPS = np.finfo(float).eps
PLAIN = (1e-8, None, False)


def exact_form(e, p):
    """e' P^-1 e by Gaussian elimination on rational numbers."""
    d = len(e)
    rows = [[Fraction(float(x)) for x in p[i]] + [Fraction(float(e[i]))] for i in range(d)]
    for j in range(d):
        for i in range(j + 1, d):
            factor = rows[i][j] / rows[j][j]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[j], strict=True)]
    return float(sum(row[d] ** 2 / row[i] for i, row in enumerate(rows)))


def tolerance(p):
    """What the documentation claims, relative to the form."""
    deviations = np.sqrt(np.diag(p))
    return 1e-12 + 8 * EPS * np.linalg.cond(p / np.outer(deviations, deviations))


@st.composite
def problems(draw, most=12):
    """Truths, estimates and covariances, from well to badly conditioned, in any units."""
    d, n = draw(st.integers(1, most)), draw(st.integers(1, 11))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    root = rng.standard_normal((n, d, d))
    root[:, :, 0] *= 10.0 ** draw(st.integers(-5, 0))
    p = root @ root.swapaxes(-1, -2) + 10.0 ** draw(st.integers(-10, 1)) * np.eye(d)
    units = 10.0 ** rng.integers(-6, 7, d) * 10.0 ** draw(st.integers(-6, 6))
    p = p * units[:, None] * units
    p = np.tril(p) + np.tril(p, -1).swapaxes(-1, -2)
    x = rng.standard_normal((n, d)) * units
    return x, x + rng.standard_normal((n, d)) * units, p


@given(problems())
def test_kernel_and_reference_are_as_near_to_exact_as_nominal(problem):
    x, y, p = problem
    exact = np.array([exact_form(*pair) for pair in zip(x - y, p, strict=True)])
    allowed = [tolerance(matrix) for matrix in p]
    for kernels in (_native, _numpy):
        got = kernels.nees_sequence(x, y, p, *PLAIN)
        assert got.shape == exact.shape
        np.testing.assert_array_less(np.abs(got - exact), allowed * exact + 1e-300)


@pytest.mark.parametrize("width", ["scalar", "avx2", "widest"])
@pytest.mark.parametrize("d", range(1, 13))
def test_every_width_and_every_remainder(d, width):
    rng = np.random.default_rng(d)
    n = 37
    root = rng.standard_normal((n, d, d))
    p = root @ root.swapaxes(-1, -2) + np.eye(d)
    p = (p + p.swapaxes(-1, -2)) / 2
    x, y = rng.standard_normal((2, n, d))
    expected = np.einsum("ni,ni->n", x - y, np.linalg.solve(p, (x - y)[..., None])[..., 0])
    _native.set_simd(width)
    try:
        for count in range(n + 1):
            got = _native.nees_sequence(x[:count], y[:count], p[:count], *PLAIN)
            np.testing.assert_allclose(got, expected[:count], rtol=1e-10)
            got = _native.nis_sequence((x - y)[:count], p[0], *PLAIN)
            again = _numpy.nis_sequence((x - y)[:count], p[0], *PLAIN)
            np.testing.assert_allclose(got, again, rtol=1e-10)
    finally:
        _native.set_simd("widest")


def test_threads_do_not_change_a_bit():
    rng = np.random.default_rng(0)
    root = rng.standard_normal((40_000, 6, 6))
    p = root @ root.swapaxes(-1, -2) + np.eye(6)
    v = rng.standard_normal((40_000, 6))
    trackmetrics.set_threads(1)
    one = _native.nis_sequence(v, p, *PLAIN)
    trackmetrics.set_threads(3)
    three = _native.nis_sequence(v, p, *PLAIN)
    trackmetrics.set_threads(0)
    assert one.tobytes() == three.tobytes()


def test_hilbert_matrices_have_integer_forms():
    for d in (3, 5, 8):
        hilbert = 1 / (np.arange(d)[:, None] + np.arange(d) + 1.0)
        assert trackmetrics.nis(np.ones(d), hilbert) == pytest.approx(d * d, rel=tolerance(hilbert))


FORMS = {
    "lists": lambda a: a.tolist(),
    "integers": lambda a: a.astype(int),
    "float32": lambda a: a.astype(np.float32),
    "strided": lambda a: np.repeat(a, 2, axis=0)[::2],
    "fortran": np.asfortranarray,
    "tuples": lambda a: tuple(map(tuple, a.tolist())) if a.ndim == 2 else a.tolist(),
    "list of arrays": list,
    "big endian": lambda a: a.astype(">f8"),
}


@pytest.mark.parametrize("form", FORMS)
def test_input_as_users_hold_it(form):
    convert = FORMS[form]
    x = np.array([[3.0, 1.0], [0.0, 2.0], [5.0, 5.0]])
    y = np.array([[1.0, 0.0], [0.0, 0.0], [4.0, 1.0]])
    p = np.array([[[4.0, 0.0], [0.0, 1.0]]] * 3)
    got = trackmetrics.nees_sequence(convert(x), convert(y), convert(p))
    assert got.tolist() == [2.0, 4.0, 16.25]
    assert trackmetrics.nees(convert(x), convert(y), convert(p[0])).tolist() == [2.0, 4.0, 16.25]


def test_leading_axes_and_numbers():
    x = np.arange(24.0).reshape(2, 3, 4)
    got = trackmetrics.nis(x, np.broadcast_to(np.eye(4), (2, 3, 4, 4)))
    assert got.shape == (2, 3)
    np.testing.assert_array_equal(got, (x**2).sum(-1))
    np.testing.assert_array_equal(trackmetrics.nis(x, np.eye(4)), got)
    for number in (
        trackmetrics.nees([1.0], [3.0], [[4.0]]),
        trackmetrics.nees(1.0, 3.0, 4.0),
        trackmetrics.nees([[1.0], [0.0]], [[0.0], [0.0]], np.eye(2)),
        trackmetrics.nis(np.float32(1.0), 1.0),
    ):
        assert type(number) is float
        assert number == 1.0


def test_nothing_and_no_dimension():
    assert trackmetrics.nees_sequence(np.empty((0, 3)), np.empty((0, 3)), np.eye(3)).shape == (0,)
    assert trackmetrics.nees([], [], np.empty((0, 0))) == 0.0
    with pytest.raises(ValueError, match="true_states is empty"):
        trackmetrics.average_nees(np.empty((0, 3)), np.empty((0, 3)), np.eye(3))


EYES = np.broadcast_to(np.eye(2), (3, 2, 2)).copy()
ZEROS = np.zeros((3, 2))


def at(array, index, value):
    """A copy with one element changed."""
    changed = array.copy()
    changed[index] = value
    return changed


SINGULAR = np.array([[0.01, 0.03], [0.03, 0.09]])
WRONG = {
    "estimated_states has shape (2, 2), expected (3, 2)": (ZEROS, ZEROS[:2], EYES),
    "estimated_states has shape (2,), expected (3, 2)": (ZEROS, ZEROS[0], EYES),
    "covariances has shape (2, 2, 2), expected (3, 2, 2) or (2, 2)": (ZEROS, ZEROS, EYES[:2]),
    "covariances has shape (3, 3), expected (3, 2, 2) or (2, 2)": (ZEROS, ZEROS, np.eye(3)),
    "true_states has shape (2,), expected (..., N, d)": (ZEROS[0], ZEROS[0], np.eye(2)),
    "true_states[1][0] is not finite: nan": (at(ZEROS, (1, 0), np.nan), ZEROS, EYES),
    "estimated_states[2][1] is not finite: -inf": (ZEROS, at(ZEROS, (2, 1), -np.inf), EYES),
    "covariances[1][0][1] is not finite: nan": (ZEROS, ZEROS, at(EYES, (1, 0, 1), np.nan)),
    "covariances[2][1][1] is not finite: inf": (ZEROS, ZEROS, at(EYES, (2, 1, 1), np.inf)),
    "covariances[1] is not symmetric: elements [1, 0] and [0, 1] differ": (
        ZEROS,
        ZEROS,
        at(EYES, (1, 0, 1), 1e-7),
    ),
    "covariances[2] is not positive definite (leading minor 1)": (
        ZEROS,
        ZEROS,
        at(EYES, (2, 0, 0), -1.0),
    ),
    "covariances[0] is not positive definite (leading minor 2)": (
        ZEROS,
        ZEROS,
        at(EYES, 0, SINGULAR),
    ),
    "covariances is not positive definite (leading minor 2)": (ZEROS, ZEROS, SINGULAR),
    "covariances[0][1] is not finite: inf": (ZEROS, ZEROS, at(np.eye(2), (0, 1), np.inf)),
}


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_is_named_alike_by_both_backends(message):
    kind = np.linalg.LinAlgError if "definite" in message else ValueError
    for kernels in (_native, _numpy):
        with pytest.raises(kind) as caught:
            kernels.nees_sequence(*WRONG[message], *PLAIN)
        assert str(caught.value) == message


def test_an_index_has_every_leading_axis_and_the_argument_its_own_name():
    p = np.broadcast_to(np.eye(2), (2, 3, 2, 2)).copy()
    p[1, 2] = SINGULAR
    message = r"innovation_covariance\[1\]\[2\] is not positive definite \(leading minor 2\)"
    with pytest.raises(np.linalg.LinAlgError, match=message):
        trackmetrics.nis(np.ones((2, 3, 2)), p)
    with pytest.raises(ValueError, match=r"covariance has shape \(3, 3\), expected \(2, 2\)"):
        trackmetrics.nees([1.0, 2.0], [1.0, 2.0], np.eye(3))
    with pytest.raises(ValueError, match=r"estimated_state has shape \(1,\), expected \(3,\)"):
        trackmetrics.nees(np.ones(3), np.ones(1), np.eye(3))


@given(st.integers(1, 12), st.integers(1, 20), st.integers(0, 2**32 - 1))
@settings(max_examples=100)
def test_near_singular_covariances_are_refused_by_both_or_neither(d, n, seed):
    """Sums of d - 1 outer products, some with a little more."""
    rng = np.random.default_rng(seed)
    root = rng.integers(-3, 4, (n, d, max(d - 1, 0))) / 10
    p = root @ root.swapaxes(-1, -2)
    p += rng.choice([0.0, 0.0, 1e-13, 1e-3], n)[:, None, None] * np.eye(d)
    p = np.tril(p) + np.tril(p, -1).swapaxes(-1, -2)
    v = rng.standard_normal((n, d))
    got = _native.nis_sequence(v, p, 1e-8, None, True)
    reference = _numpy.nis_sequence(v, p, 1e-8, None, True)
    np.testing.assert_array_equal(np.isnan(got), np.isnan(reference))
    errors = []
    for kernels in (_native, _numpy):
        try:
            kernels.nis_sequence(v, p, *PLAIN)
            errors.append(None)
        except np.linalg.LinAlgError as error:
            errors.append(str(error))
    assert errors[0] == errors[1]


@pytest.mark.parametrize("d", [2, 5, 9, 11])
def test_small_asymmetry_is_averaged(d):
    rng = np.random.default_rng(d)
    root = rng.standard_normal((20, d, d))
    p = root @ root.swapaxes(-1, -2) + np.eye(d)
    skew = rng.uniform(-1, 1, p.shape) * 2e-9
    asymmetric = p + skew
    mean = (asymmetric + asymmetric.swapaxes(-1, -2)) / 2
    v = rng.standard_normal((20, d))
    expected = np.einsum("ni,ni->n", v, np.linalg.solve(mean, v[..., None])[..., 0])
    for kernels in (_native, _numpy):
        np.testing.assert_allclose(
            kernels.nis_sequence(v, asymmetric, *PLAIN), expected, rtol=1e-11
        )


def test_single_precision_may_be_less_symmetric():
    p = np.array([[1.0, 0.5], [0.5001, 1.0]])
    with pytest.raises(ValueError, match="covariance is not symmetric"):
        trackmetrics.nees([1.0, 0.0], [0.0, 0.0], p)
    got = trackmetrics.nees([1.0, 0.0], [0.0, 0.0], p.astype(np.float32))
    assert got == pytest.approx(1 / (1 - 0.50005**2), rel=1e-6)


def test_angles_are_wrapped():
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            got = trackmetrics.nees_sequence(
                [[1.0, 359.0], [1.0, -180.0], [1.0, 725.0]],
                [[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]],
                np.diag([1.0, 4.0]),
                angles={-1: 360.0},
            )
            assert got.tolist() == [1.0 + 1.0, 1.0 + 180.0**2 / 4, 1.0 + 25.0 / 4]
            assert trackmetrics.nis([4.0], [[1.0]], angles={0: 2 * np.pi}) == pytest.approx(
                (4 - 2 * np.pi) ** 2
            )
    for angles, message in (
        ({2: 360.0}, r"angles\[0\] is 2, the state has 1 components"),
        ({0: 0.0}, r"angles\[0\] must be positive and finite, got 0.0"),
        ({0: np.nan}, r"angles\[0\] must be positive and finite, got nan"),
    ):
        with pytest.raises(ValueError, match=message):
            trackmetrics.nis([1.0], [[1.0]], angles=angles)


def test_a_sweep_may_survive_what_is_invalid():
    x, p = at(ZEROS + 1.0, (0, 1), np.nan), at(EYES, 1, SINGULAR)
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            for angles in (None, {0: 360.0}):
                got = trackmetrics.nees_sequence(x, ZEROS, p, angles=angles, on_invalid="nan")
                np.testing.assert_array_equal(got, [np.nan, np.nan, 2.0])
            got = trackmetrics.nees_sequence(x, ZEROS, -np.eye(2), on_invalid="nan")
            assert np.isnan(got).all()
    with pytest.raises(ValueError, match="on_invalid must be 'raise' or 'nan', got 'skip'"):
        trackmetrics.nis([1.0], [[1.0]], on_invalid="skip")


def test_complex_and_ragged_input_is_refused():
    with pytest.raises(TypeError, match="true_state must hold real numbers, got dtype complex128"):
        trackmetrics.nees([1j], [0.0], [[1.0]])
    with pytest.raises(ValueError, match="estimated_state is ragged"):
        trackmetrics.nees([[1.0], [2.0]], [[1.0], [2.0, 3.0]], np.eye(1))


@pytest.mark.data
def test_real_updates_are_at_least_as_near_to_exact_as_the_peer(data):
    sets = json.loads((data / "mot" / "values" / "nees_nis_real.json").read_text())
    for values in sets.values():
        rows = values["rows"]
        v, s = (np.array([row[key] for row in rows]) for key in ("innovation", "S"))
        ours = trackmetrics.nis_sequence(v, s)
        assert _distance(ours, values["nis_exact"]) <= _distance(
            values["nis_pytcl"], values["nis_exact"]
        )
        judged = [row for row in rows if row["truth_position"] is not None]
        truth = np.array([row["truth_position"] for row in judged])
        x, p = (np.array([row[key] for row in judged]) for key in ("x", "P"))
        ours = trackmetrics.nees_sequence(truth, x[:, [0, 2]], p[:, [0, 2]][:, :, [0, 2]])
        exact = values["nees_position_exact"]
        assert _distance(ours, exact) <= _distance(values["nees_position_pytcl"], exact)
        assert _distance(ours, exact) <= _distance(values["nees_position_filterpy"], exact)
        average = trackmetrics.average_nees(truth, x[:, [0, 2]], p[:, [0, 2]][:, :, [0, 2]])
        assert average == pytest.approx(values["average_nees"], rel=1e-12)


def _distance(values, exact):
    """The mean relative distance from the exact values."""
    return np.mean(np.abs(np.asarray(values) / np.asarray(exact) - 1))


@pytest.mark.peers
def test_thousands_of_random_inputs_against_pytcl():
    from pytcl import performance_evaluation as peer

    rng = np.random.default_rng(5)
    for d in range(1, 10):
        n = 300
        root = rng.standard_normal((n, d, d))
        p = root @ root.swapaxes(-1, -2) + 0.1 * np.eye(d)
        p = (p + p.swapaxes(-1, -2)) / 2
        x, y = rng.standard_normal((2, n, d))
        expected = peer.nees_sequence(x, y, p)
        allowed = np.array([tolerance(matrix) for matrix in p]) * expected
        # Twice: the peer has errors of its own.
        got = trackmetrics.nees_sequence(x, y, p)
        np.testing.assert_array_less(np.abs(got - expected), 2 * allowed)
        got = trackmetrics.nis_sequence(x, p)
        allowed = allowed / expected * got
        np.testing.assert_array_less(np.abs(got - peer.nis_sequence(x, p)), 2 * allowed)
        average = peer.average_nees(x, y, p)
        assert trackmetrics.average_nees(x, y, p) == pytest.approx(average, rel=1e-9)
        for i in range(20):
            number = peer.nees(x[i], y[i], p[i])
            assert trackmetrics.nees(x[i], y[i], p[i]) == pytest.approx(number, rel=1e-9)
            number = peer.nis(x[i], p[i])
            assert trackmetrics.nis(x[i], p[i]) == pytest.approx(number, rel=1e-9)


def test_arrays_that_were_pickled_are_read_as_others():
    rng = np.random.default_rng(0)
    arrays = rng.normal(size=(4, 2)), rng.normal(size=(4, 2)), np.eye(2)
    copies = pickle.loads(pickle.dumps(arrays))
    np.testing.assert_array_equal(trackmetrics.nees(*copies), trackmetrics.nees(*arrays))
    assert trackmetrics.ospa(*copies[:2], 2.0, 1.0) == trackmetrics.ospa(*arrays[:2], 2.0, 1.0)
    assert (
        trackmetrics.gospa(*copies[:2], 2.0).distance
        == trackmetrics.gospa(*arrays[:2], 2.0).distance
    )
