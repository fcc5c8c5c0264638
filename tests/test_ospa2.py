"""OSPA(2) against its definition, the reference implementation, and the authors' values."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackmetrics
from trackmetrics import ospa, ospa2


def by_definition(truth, tracks, c, p, q, window, base, times):
    """Dictionaries of time to state, every assignment."""
    return np.array([at_time(truth, tracks, c, p, q, window, base, t) for t in times])


def at_time(truth, tracks, c, p, q, window, base, now):
    inside = [
        [{t: s for t, s in f.items() if now - window < t <= now} for f in side]
        for side in (truth, tracks)
    ]
    x, y = sorted(([f for f in side if f] for side in inside), key=len)
    if not y:
        return 0.0
    costs = [[track_distance(f, g, c, q, p if base == "p-norm" else 2) ** p for g in y] for f in x]
    total = min(
        sum(costs[i][j] for i, j in enumerate(chosen))
        for chosen in itertools.permutations(range(len(y)), len(x))
    )
    return ((total + c**p * (len(y) - len(x))) / len(y)) ** (1 / p)


def track_distance(f, g, c, q, order):
    powers = [
        min(c, np.linalg.norm(f[t] - g[t], order)) ** q if t in f and t in g else c**q
        for t in {*f, *g}
    ]
    return (sum(powers) / len(powers)) ** (1 / q)


def as_pairs(side):
    return [(list(f), [f[t] for t in f]) for f in side]


def random_side(rng, d, times, scale):
    side = []
    for _ in range(rng.integers(0, 4)):
        alive = times[rng.random(len(times)) < rng.choice([0.0, 0.4, 0.9])]
        side.append({t: rng.integers(-2, 3, d) * scale for t in rng.permutation(alive)})
    return side


@given(
    st.integers(0, 2**32),
    st.sampled_from([1.0, 1e-12, 1e12]),
    st.sampled_from([(1, 1), (2, 2), (3, 3), (1, 2), (2, 1), (2.5, 1.5)]),
    st.sampled_from(["euclidean", "p-norm"]),
    st.sampled_from([1, 2, 3.5, math.inf]),
)
def test_kernel_reference_and_definition_agree(seed, scale, orders, base, window):
    rng = np.random.default_rng(seed)
    d, (p, q) = int(rng.integers(1, 4)), orders
    clock = np.arange(7) * rng.choice([0.5, 1.0, 10.0])
    truth, tracks = (random_side(rng, d, clock, scale) for _ in range(2))
    c, window = rng.choice([0.7, 1.5, 4.0]) * scale, window * clock[1]
    times = rng.permutation(np.append(clock, [-1.0, clock[-1] + 0.3]))
    expected = by_definition(truth, tracks, c, p, q, window, base, times)
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            result = ospa2(
                as_pairs(truth),
                as_pairs(tracks),
                c,
                p,
                q,
                window=window,
                distance=base,
                times=times,
            )
        np.testing.assert_allclose(result.distance, expected, rtol=1e-12)
        np.testing.assert_allclose(
            result.localization**p + result.cardinality**p, expected**p, rtol=1e-12
        )


def test_a_window_of_one_step_is_ospa():
    rng = np.random.default_rng(1)
    truth, tracks = (random_side(rng, 2, np.arange(9.0), 1.0) for _ in range(2))
    result = ospa2(as_pairs(truth), as_pairs(tracks), 1.5, 2, window=1)
    for now, value in zip(result.times, result.distance, strict=True):
        sets = [[f[now] for f in side if now in f] for side in (truth, tracks)]
        assert value == pytest.approx(ospa(*sets, c=1.5, p=2).ospa, rel=1e-12)


def test_steps_that_floats_round():
    times = np.arange(8) * 0.1
    result = ospa2([(times, np.arange(8.0))], [(times, np.arange(8.0) ** 2)], 90, 1, window=0.2)
    distances = np.arange(8.0) ** 2 - np.arange(8.0)
    assert result.distance[1:] == pytest.approx((distances[1:] + distances[:-1]) / 2, rel=1e-12)


def test_empty_sides():
    assert ospa2([], [], 1, 1).distance.size == 0
    result = ospa2([], [([2], [0.0])], 3, 2, times=[1, 2, 3])
    assert result.distance.tolist() == [0.0, 3.0, 3.0]
    assert result.cardinality.tolist() == [0.0, 3.0, 3.0]
    assert ospa2([([], [])], [([], np.empty((0, 2)))], 3, 2, times=[0]).distance.tolist() == [0.0]
    assert result.to_dict()["times"] == [1, 2, 3]


def test_one_thread_and_two_give_the_same_bits():
    """Of the Rust kernel: many windows are cut into pieces that threads share."""
    rng = np.random.default_rng(2)
    walks = [
        [(np.arange(300), rng.normal(size=(300, 2)).cumsum(0)) for _ in range(20)] for _ in range(2)
    ]
    with trackmetrics.use_backend("native"):
        before = trackmetrics.threads()
        try:
            trackmetrics.set_threads(1)
            one = ospa2(*walks, 10, 2, window=50)
            trackmetrics.set_threads(2)
            two = ospa2(*walks, 10, 2, window=50)
        finally:
            trackmetrics.set_threads(before)
        some = ospa2(*walks, 10, 2, window=50, times=[123, 299])
    np.testing.assert_array_equal(one.distance, two.distance)
    np.testing.assert_allclose(some.distance, one.distance[[123, 299]], rtol=1e-12)


def test_axioms():
    """Identity, symmetry and the triangle inequality, in every window."""
    rng = np.random.default_rng(3)
    for _ in range(150):
        d, times = rng.integers(1, 3), np.arange(5.0)
        x, y, z = (as_pairs(random_side(rng, d, times, 1.0)) for _ in range(3))
        options = {
            "c": rng.choice([0.5, 2.0]),
            "p": rng.choice([1.0, 2.0]),
            "q": rng.choice([1.0, 2.0]),
            "window": rng.choice([1.0, 3.0]),
            "distance": str(rng.choice(["euclidean", "p-norm"])),
            "times": times,
        }
        xy, yx, yz, xz, xx = (
            ospa2(*sides, **options).distance for sides in [(x, y), (y, x), (y, z), (x, z), (x, x)]
        )
        assert not xx.any()
        np.testing.assert_allclose(xy, yx, rtol=1e-12)
        assert (xz <= xy + yz + 1e-12).all()


POINT = [([0.0], [[0.0, 0.0]])]


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"c": 0}, ValueError, "c must be positive and finite, got 0.0"),
        ({"c": math.inf}, ValueError, "c must be positive and finite, got inf"),
        ({"p": 0.5}, ValueError, "p must be finite and at least 1, got 0.5"),
        ({"p": math.nan}, ValueError, "p must be finite and at least 1, got nan"),
        ({"q": math.inf}, ValueError, "q must be finite and at least 1, got inf"),
        ({"window": 0}, ValueError, "window must be positive, got 0.0"),
        ({"distance": "taxi"}, ValueError, "distance must be 'euclidean' or 'p-norm', got 'taxi'"),
        ({"times": [0, math.nan]}, ValueError, "times[1] is not finite: nan"),
        ({"times": [[0]]}, ValueError, "times has shape (1, 1), expected (T,)"),
        ({"truth": {}}, TypeError, "truth must be a list of (times, states), got dict"),
        ({"truth": [[1, 2, 3]]}, TypeError, "truth[0] must be a pair (times, states)"),
        (
            {"tracks": [([0], [1]), ([0, 1], [1])]},
            ValueError,
            "tracks[1][1] has 1 times, tracks[1][0] has 2",
        ),
        ({"tracks": [([3, 1, 3], [1, 2, 3])]}, ValueError, "tracks[0] has time 3.0 twice"),
        ({"truth": [([0], [[math.inf]])]}, ValueError, "truth[0][1][0] is not finite: inf"),
        ({"truth": [([math.nan], [[1]])]}, ValueError, "truth[0][0][0] is not finite: nan"),
        ({"tracks": [([0], [[1.0]])]}, ValueError, "tracks[0][0] has 1 coordinates, expected 2"),
        (
            {"tracks": [([0], [[1]]), ([1], [[1, 2]])]},
            ValueError,
            "tracks[1][0] has 2 coordinates, expected 1",
        ),
    ],
)
def test_bad_arguments_are_named(arguments, error, text):
    with pytest.raises(error) as raised:
        ospa2(**{"truth": POINT, "tracks": POINT, "c": 1, "p": 1, **arguments})
    assert str(raised.value) == text


@pytest.mark.data
def test_values_of_the_authors_code(data):
    record = json.loads((data / "mot/values/ospa2_reference.json").read_text())
    for case in record["cases"]:
        sides = [
            [
                ([t for t, s in enumerate(f) if s is not None], [s for s in f if s is not None])
                for f in case[side]
            ]
            for side in ("truth", "tracks")
        ]
        result = ospa2(
            *sides,
            case["c"],
            case["p"],
            window=math.floor(case["window"]),
            distance="p-norm",
            times=range(case["times"]),
        )
        for ours, theirs in zip(
            (result.distance, result.localization, result.cardinality),
            (case["ospa2"], case["loc"], case["card"]),
            strict=True,
        ):
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-13 * case["c"])
