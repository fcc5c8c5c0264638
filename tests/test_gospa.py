"""GOSPA and the pairs of OSPA against brute force, SciPy, their reference and the authors' code."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

import trackmetrics
from trackmetrics import (
    Mahalanobis,
    _native,
    _numpy,
    gospa,
    gospa_from_distances,
    gospa_over_time,
    ospa,
    ospa_assignment,
    ospa_from_distances,
)


def brute_force(x, y, c, p, alpha):
    """The definition, over every assignment of the smaller set."""
    if len(x) > len(y):
        x, y = y, x
    n, m = len(y), len(x)
    d = np.minimum(np.linalg.norm(x[:, None] - y[None], axis=-1), c) if m else np.empty((0, n))
    total = min(
        (d[np.arange(m), list(chosen)] ** p).sum() for chosen in itertools.permutations(range(n), m)
    )
    return (total + c**p / alpha * (n - m)) ** (1 / p)


def by_scipy(x, y, c, p):
    """The pairs closer than the cutoff, from squares, with SciPy's ties."""
    if not len(x) or not len(y):
        return []
    squares = sum((a[:, None] - b) ** 2 for a, b in zip(x.T, y.T, strict=True))
    d = np.sqrt(squares)
    costs = np.where(d < c, squares ** (p / 2) if p % 2 == 0 else d**p, np.float64(c) ** p)
    rows, columns = linear_sum_assignment(costs)
    return [[i, j] for i, j in zip(rows, columns, strict=True) if d[i, j] < c]


@st.composite
def pairs_of_sets(draw, largest=5):
    d = draw(st.integers(1, 5))
    grid = st.integers(-3, 3).map(float)
    point = st.lists(grid, min_size=d, max_size=d)
    sizes = draw(st.tuples(st.integers(0, largest), st.integers(0, largest)))
    sets = [draw(st.lists(point, min_size=n, max_size=n)) for n in sizes]
    return [np.array(s).reshape(len(s), d) for s in sets]


ALPHAS = st.sampled_from([0.5, 1.0, 2.0, 2.0, 2.0])


@given(pairs_of_sets(), st.sampled_from([1.0, 2.0, 3.5]), st.sampled_from([1.0, 2.0, 3.0]), ALPHAS)
def test_kernel_reference_and_definition_agree(sets, c, p, alpha):
    x, y = sets
    (parts, pairs), reference = _native.gospa(x, y, c, p, alpha), _numpy.gospa(x, y, c, p, alpha)
    assert parts[0] == pytest.approx(brute_force(x, y, c, p, alpha), rel=1e-12, abs=1e-15)
    assert reference[0] == pytest.approx(parts, rel=1e-12, nan_ok=True)
    assert parts[4:] == (len(x) - len(pairs), len(y) - len(pairs))
    if alpha == 2:
        assert sum(parts[1:4]) == pytest.approx(parts[0] ** p, rel=1e-12, abs=1e-15)
        assert parts[2:4] == (parts[4] * (c**p / 2), parts[5] * (c**p / 2))
    else:
        assert all(map(math.isnan, parts[1:4]))
    if p != 3.0:  # whose powers round differently
        assert pairs.tolist() == by_scipy(x, y, c, p) == reference[1].tolist()


@given(st.integers(0, 2**32), st.integers(0, 30), st.integers(0, 30), st.sampled_from([1.0, 2.0]))
def test_pairs_fall_as_in_scipy_on_larger_grids(seed, m, n, p):
    rng = np.random.default_rng(seed)
    span = rng.integers(2, 40)
    x, y = (rng.integers(0, span, (k, 2)).astype(float) for k in (m, n))
    pairs = by_scipy(x, y, 6.0, p)
    assert ospa_assignment(x, y, 6.0, p).tolist() == pairs
    assert gospa(x, y, 6.0, p).assignment.tolist() == pairs
    assert gospa(y, x, 6.0, p).distance == pytest.approx(gospa(x, y, 6.0, p).distance, rel=1e-15)


@given(st.integers(0, 2**32), st.integers(1, 25), st.integers(1, 25))
def test_pairs_fall_as_in_scipy_where_there_are_no_ties(seed, m, n):
    rng = np.random.default_rng(seed)
    x, y = (rng.uniform(0, 20, (k, 3)) for k in (m, n))
    assert ospa_assignment(x, y, 8.0, 2.0).tolist() == by_scipy(x, y, 8.0, 2.0)


def test_pairs_of_infinite_order_and_cutoff():
    x, y = [[0.0], [4.0]], [[5.0], [1.0], [90.0]]
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            assert ospa_assignment(x, y, 3.0, math.inf).tolist() == [[0, 1], [1, 0]]
            assert ospa_assignment(x, y, math.inf, 2.0).tolist() == [[0, 1], [1, 0]]
            assert ospa_assignment(x, y, 100.0, 400.0).tolist() == [[0, 1], [1, 0]]
            assert ospa_assignment(x, [], 3.0, math.inf).shape == (0, 2)
            far = ospa_assignment([[0.0], [1e200]], [[1e200], [1e-3]], 1e199, 3.0)
            assert far.tolist() == [[0, 1], [1, 0]]


@pytest.mark.parametrize("p", [2.0, 100.0, 1000.0])
@pytest.mark.parametrize("scale", [1e-180, 1e-12, 1.0, 1e12, 1e180])
def test_the_distance_survives_powers_that_leave_the_range(p, scale):
    x = scale * np.array([[0.0], [50.0], [75.0]])
    y = scale * np.array([[3.0], [46.0]])
    expected = 100 * scale * ((0.03**p + 0.04**p) + 0.5) ** (1 / p)
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            assert gospa(x, y, 100 * scale, p).distance == pytest.approx(expected, rel=1e-12)
            same = gospa(x[:2], y, 100 * scale, p).distance
            assert same == pytest.approx(4 * scale * (1 + 0.75**p) ** (1 / p), rel=1e-12)


def test_types_of_the_result():
    result = gospa([[0, 0]], [(3, 4), (9, 9)], 6)
    assert result.to_dict().keys() == {
        "distance",
        "localization",
        "missed",
        "false",
        "num_missed",
        "num_false",
        "assignment",
    }
    assert [type(v) for v in result.to_dict().values()] == [float] * 4 + [int] * 2 + [list]
    assert result.assignment.dtype == np.int64
    assert gospa([], [], 1.0).distance == 0.0
    assert gospa([], [[1.0]], 2.0).missed == 0.0


def test_over_time_is_frame_by_frame():
    rng = np.random.default_rng(0)
    x = [rng.uniform(0, 9, (n, 2)) for n in (3, 0, 12, 5)]
    y = [rng.uniform(0, 9, (n, 2)) for n in (4, 2, 9, 0)]
    for alpha in (1.0, 2.0):
        result = gospa_over_time(x, y, 3.0, 2.0, alpha)
        frames = [gospa(a, b, 3.0, 2.0, alpha) for a, b in zip(x, y, strict=True)]
        for name, values in vars(result).items():
            expected = [getattr(frame, name) for frame in frames]
            np.testing.assert_array_equal(values, expected)
    empty = gospa_over_time([], [], 1.0)
    assert empty.distance.shape == empty.num_false.shape == (0,)


METRICS = {
    "manhattan": lambda a, b: np.abs(a - b).sum(),
    "haversine": lambda a, b: great_circle(a, b),
}


def great_circle(a, b):
    """By the angle between two unit vectors."""
    (f, g), (h, k) = np.radians(a), np.radians(b)
    u = np.array([np.cos(f) * np.cos(g), np.cos(f) * np.sin(g), np.sin(f)])
    v = np.array([np.cos(h) * np.cos(k), np.cos(h) * np.sin(k), np.sin(h)])
    return 6_371_008.8 * np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)


@pytest.mark.parametrize("name", METRICS)
@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_named_distances(name, backend):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-60, 60, (4, 2)), rng.uniform(-60, 60, (3, 2))
    c = 4e6 if name == "haversine" else 30.0
    matrix = [[METRICS[name](a, b) for b in y] for a in x]
    with trackmetrics.use_backend(backend):
        for p in (1.0, 2.0, 3.0, math.inf):
            got = ospa(x, y.tolist(), c, p, distance=name)
            assert got == pytest.approx(ospa_from_distances(matrix, c, p), rel=1e-9)
            assert ospa(x, y, c, p, distance=METRICS[name]) == pytest.approx(got, rel=1e-9)
        one = gospa(x, y, c, distance=name)
        two = gospa_from_distances(matrix, c)
        assert one.distance == pytest.approx(two.distance, rel=1e-9)
        assert one.assignment.tolist() == two.assignment.tolist()
        assert ospa([], y, c, distance=name).ospa == c


def test_a_ready_matrix_is_the_same_as_points():
    rng = np.random.default_rng(8)
    for m, n in ((0, 3), (2, 3), (3, 2), (9, 12), (12, 9)):
        x, y = rng.uniform(0, 9, (m, 2)), rng.uniform(0, 9, (n, 2))
        matrix = np.linalg.norm(x[:, None] - y[None], axis=-1)
        for backend in ("native", "numpy"):
            with trackmetrics.use_backend(backend):
                for p in (0.5, 1.0, 2.0, 3.0, math.inf):
                    expected = ospa(x, y, 4.0, p)
                    assert ospa_from_distances(matrix, 4.0, p) == pytest.approx(expected, rel=1e-12)
                assert gospa_from_distances(matrix, 4.0).distance == pytest.approx(
                    gospa(x, y, 4.0).distance, rel=1e-12
                )
    never = [[math.inf, 1.0], [math.inf, math.inf]]
    assert gospa_from_distances(never, 5.0, 1.0).distance == 6.0


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_mahalanobis(backend):
    rng = np.random.default_rng(4)
    x, y = rng.normal(size=(4, 3)), rng.normal(size=(5, 3))
    roots = rng.normal(size=(4, 3, 3))
    each = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(3)

    def matrix(covariances):
        d = y[None] - x[:, None]
        return np.sqrt(np.einsum("ijk,ikl,ijl->ij", d, np.linalg.inv(covariances), d))

    with trackmetrics.use_backend(backend):
        for covariances in (each[0], each):
            every = np.broadcast_to(covariances, (4, 3, 3))
            expected = ospa_from_distances(matrix(every), 2.5, 2.0)
            got = ospa(x, y, 2.5, 2.0, distance=Mahalanobis(covariances))
            assert got == pytest.approx(expected, rel=1e-12)


WRONG = [
    (lambda: gospa([], [], math.inf), "c must be positive and finite, got inf"),
    (lambda: gospa([], [], -1), "c must be positive and finite, got -1.0"),
    (lambda: gospa([], [], 1, 0.5), "p must be at least 1 and finite, got 0.5"),
    (lambda: gospa([], [], 1, math.inf), "p must be at least 1 and finite, got inf"),
    (lambda: gospa([], [], 1, 1, 0), "alpha must be above 0 and at most 2, got 0.0"),
    (lambda: gospa([], [], 1, 1, 2.5), "alpha must be above 0 and at most 2, got 2.5"),
    (lambda: gospa([[math.nan]], [[1.0]], 1), "X[0] is not finite: nan"),
    (lambda: gospa([[1.0]], [[1.0, 2.0]], 1), "Y[0] has 2 coordinates, expected 1"),
    (lambda: ospa_from_distances([[1.0, -2.0]]), "distances[0][1] must be at least 0, got -2.0"),
    (
        lambda: gospa_from_distances([[1.0], [math.nan]], 1),
        "distances[1][0] must be at least 0, got nan",
    ),
    (lambda: ospa_from_distances([1.0]), "distances has shape (1,), expected (m, n)"),
    (
        lambda: ospa([[1.0]], [[2.0]], distance="cosine"),
        "distance must be one of 'euclidean', 'manhattan', 'haversine', a Mahalanobis or a "
        "callable, got 'cosine'",
    ),
    (
        lambda: ospa([[1.0]], [[2.0, 1.0]], distance="haversine"),
        "X[0] has 1 coordinates, expected 2",
    ),
    (
        lambda: ospa([[1.0]], [[2.0]], distance=Mahalanobis([[-1.0]])),
        "covariances is not positive definite (leading minor 1)",
    ),
    (
        lambda: ospa([[1.0]] * 2, [[2.0]], distance=Mahalanobis([[[1.0]], [[0.0]]])),
        "covariances[1] is not positive definite (leading minor 1)",
    ),
    (
        lambda: ospa([[1.0, 2.0]], [[2.0, 1.0]], distance=Mahalanobis([[1.0, 0.5], [0.2, 1.0]])),
        "covariances is not symmetric: elements [0, 1] and [1, 0] differ",
    ),
    (
        lambda: ospa([[1.0]], [[2.0]], distance=Mahalanobis(np.ones((2, 1, 1)))),
        "covariances has shape (2, 1, 1), expected (d, d) or one such for each point of X",
    ),
    (lambda: gospa_over_time([[]], [], 1), "Y_sequence has 0 frames, X_sequence has 1"),
]


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize(("call", "text"), WRONG, ids=[text for _, text in WRONG])
def test_what_is_wrong_is_named(backend, call, text):
    with trackmetrics.use_backend(backend), pytest.raises(ValueError) as caught:  # noqa: PT011
        call()
    assert str(caught.value) == text


@pytest.mark.data
def test_the_authors_matlab(data):
    """1 485 sets; the assignment is the column of each row, counted from 1, 0 for none.

    It also holds pairs at the cutoff or beyond, which are none here.
    """
    for case in json.loads((data / "mot/values/matlab_gospa_ospa.json").read_text())["sets"]:
        d = max([len(point) for point in case["x"] + case["y"]], default=1)
        x, y = (np.array(case[k], dtype=float).reshape(len(case[k]), d) for k in "xy")
        c, p, alpha = case["c"], case["p"], case["alpha"]
        result = gospa(x, y, c, p, alpha)
        assert result.distance == pytest.approx(case["gospa"], rel=1e-12)
        if alpha == 2:
            parts = [result.localization, result.missed, result.false]
            expected = [case[k] for k in ("localisation", "missed", "false")]
            assert parts == pytest.approx(expected, rel=1e-11, abs=1e-11)
            columns = np.atleast_1d(case["assignment"])
            pairs = [[i, int(j) - 1] for i, j in enumerate(columns) if j] if len(y) else []
            near = [[i, j] for i, j in pairs if np.linalg.norm(x[i] - y[j]) < c]
            assert result.assignment.tolist() == near
        if "ospa" in case:
            parts = [case[k] for k in ("ospa", "ospa_loc", "ospa_card")]
            assert ospa(x, y, c, p) == pytest.approx(parts, rel=1e-12, abs=1e-12)


@pytest.mark.data
def test_a_vector_computed_in_matlab(data):
    path = data / "mot/values/matlab_gospa_vector_gospapy.json"
    case = json.loads(path.read_text())
    result = gospa(case["x"], case["y"], case["c"], case["p"], case["alpha"])
    assert result.distance == pytest.approx(32.73676032916644, rel=1e-14)
    assert (result.num_missed, result.num_false) == (0, 2)
    columns = (result.assignment[:, 1] + 1).tolist()
    assert columns == case["assignment_1based_0_unassigned"]


def _centres(path, frames, confident):
    rows = np.loadtxt(path, delimiter=",")
    if confident:
        rows = rows[rows[:, 6] >= 1]
    centres = rows[:, 2:4] + rows[:, 4:6] / 2
    return [centres[rows[:, 0] == t] for t in frames]


@pytest.mark.data
@pytest.mark.parametrize(
    ("sequence", "tracker"), [("TUD-Campus", "CEM"), ("TUD-Campus", "SORT"), ("KITTI-17", "SORT")]
)
def test_stone_soup_on_recordings(data, sequence, tracker):
    path = data / f"mot/values/mot15__{sequence}__{tracker}__conf1.stonesoup.json"
    values = json.loads(path.read_text())
    truth = _centres(data / f"mot/{sequence}/gt.txt", values["frames"], True)
    tracks = _centres(data / f"mot/{sequence}/{tracker}.txt", values["frames"], False)
    for c, p in ((50, 1), (50, 2), (100, 2), (20, 1), (100, 3)):
        expected = values[f"px c={c} p={p}"]
        result = gospa_over_time(truth, tracks, c, p)
        assert result.distance == pytest.approx(expected["gospa"], rel=1e-12)
        for ours, theirs in (("localization", "localisation"), ("missed",) * 2, ("false",) * 2):
            got = getattr(result, ours)
            assert got == pytest.approx(expected[theirs], rel=1e-11, abs=1e-9)
        distances = trackmetrics.ospa_over_time(truth, tracks, c, p)
        assert distances == pytest.approx(expected["ospa_optimal_assignment"], rel=1e-12)
