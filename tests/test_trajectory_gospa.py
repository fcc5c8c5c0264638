"""Trajectory GOSPA against the linear programme of its definition, GOSPA, and the authors."""

import itertools
import json
import math

import numpy as np
import pytest
from scipy.optimize import linprog

from trackmetrics import trajectory_gospa
from trackmetrics.trajectories._gospa_solver import Cluster, _dynamic_program, _linear_program


def by_definition(truth, tracks, c, p, gamma, norm=2.0):
    """The programme of the paper: dense, with dummies, over dictionaries of time to state."""
    times = sorted({t for f in [*truth, *tracks] for t in f})
    n, m, length = len(truth), len(tracks), len(times)
    if not length:
        return 0.0
    costs = np.array(
        [[[cost(f, g, t, c, p, norm) for g in [*tracks, {}]] for f in [*truth, {}]] for t in times]
    )
    w = np.arange(length * (n + 1) * (m + 1)).reshape(length, n + 1, m + 1)
    h = w.size + np.arange((length - 1) * n * m).reshape(length - 1, n, m)
    objective = np.concatenate([costs.ravel(), np.full(h.size, gamma**p / 2)])
    equal, below = [], []
    for t in range(length):
        equal += [(w[t, i], 1.0) for i in range(n)] + [(w[t, :, j], 1.0) for j in range(m)]
    for t, i, j in itertools.product(range(length - 1), range(n), range(m)):
        for sign in (1, -1):
            row = np.zeros(objective.size)
            row[[w[t, i, j], w[t + 1, i, j], h[t, i, j]]] = sign, -sign, -1
            below.append(row)
    a_eq = np.zeros((len(equal), objective.size))
    for row, (places, _) in zip(a_eq, equal, strict=True):
        row[places] = 1
    solved = linprog(
        objective,
        A_ub=np.array(below) if below else None,
        b_ub=np.zeros(len(below)) if below else None,
        A_eq=a_eq if equal else None,
        b_eq=np.ones(len(equal)) if equal else None,
    )
    return max(solved.fun, 0.0) ** (1 / p)


def cost(f, g, t, c, p, norm):
    if t in f and t in g:
        return min(c, np.linalg.norm(f[t] - g[t], norm)) ** p
    return c**p / 2 if t in f or t in g else 0.0


def as_pairs(side):
    return [(list(f), [f[t] for t in f]) for f in side]


def random_side(rng, largest, d, times):
    side = []
    for _ in range(rng.integers(0, largest + 1)):
        alive = times[rng.random(len(times)) < rng.choice([0.3, 0.9])]
        side.append({t: rng.integers(-2, 3, d) + rng.normal(0, 0.1, d) for t in alive})
    return side


@pytest.mark.parametrize("seed", range(60))
def test_the_programme_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    d, p = int(rng.integers(1, 3)), float(rng.choice([1.0, 2.0, 3.0]))
    times = np.arange(rng.integers(1, 6)) * 0.5
    truth, tracks = random_side(rng, 3, d, times), random_side(rng, 3, d, times)
    c, gamma = rng.choice([0.8, 2.0, 5.0]), rng.choice([0.1, 1.0, 4.0])
    for base, norm in (("euclidean", 2.0), ("p-norm", p)):
        expected = by_definition(truth, tracks, c, p, gamma, norm)
        result = trajectory_gospa(as_pairs(truth), as_pairs(tracks), c, p, gamma, base)
        assert result.distance == pytest.approx(expected, rel=1e-6, abs=1e-6)
        assert sum(result.totals().values()) == pytest.approx(result.distance**p, rel=1e-12)


def test_a_chain_of_choices_solves_its_linear_programme():
    rng = np.random.default_rng(1)
    for _ in range(60):
        pairs, length = rng.integers(1, 5), rng.integers(1, 9)
        powers = np.minimum(rng.random((pairs, length)) * 1.5, 1)
        cluster = Cluster(
            np.stack([np.zeros(pairs, int), np.arange(pairs)], axis=1), np.arange(length), powers
        )
        price = rng.choice([0.05, 0.3, 1.0])

        def value(held, powers=powers, price=price):
            return ((1 - powers) * held).sum() - price * np.abs(np.diff(held, axis=1)).sum()

        chain = _dynamic_program(cluster.gains, price)
        assert (chain.sum(axis=0) <= 1).all()
        assert value(chain) == pytest.approx(value(_linear_program(cluster, price)), abs=1e-7)


def test_one_step_is_gospa_and_a_price_of_nothing_is_its_sum():
    rng = np.random.default_rng(2)
    for _ in range(30):
        times = np.arange(4.0)
        truth, tracks = random_side(rng, 3, 2, times), random_side(rng, 3, 2, times)
        c, p = 2.0, 2.0
        steps = [[[{t: f[t]} for f in side if t in f] for side in (truth, tracks)] for t in times]
        powers = [trajectory_gospa(*map(as_pairs, s), c, p, 1.0).distance ** p for s in steps]
        for (x, y), power in zip(steps, powers, strict=True):
            assert power == pytest.approx(gospa_power(x, y, c, p), rel=1e-6, abs=1e-9)
        free = trajectory_gospa(as_pairs(truth), as_pairs(tracks), c, p, 1e-6)
        assert free.distance**p == pytest.approx(sum(powers), rel=1e-6, abs=1e-9)


def gospa_power(x, y, c, p):
    """GOSPA for alpha = 2, by every assignment."""
    x, y = sorted(([next(iter(f.values())) for f in side] for side in (x, y)), key=len)
    least = min(
        sum(min(np.linalg.norm(x[i] - y[j]), c) ** p for i, j in enumerate(chosen))
        for chosen in itertools.permutations(range(len(y)), len(x))
    )
    return least + c**p / 2 * (len(y) - len(x))


def test_axioms():
    """Identity, symmetry and the triangle inequality."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        x, y, z = (as_pairs(random_side(rng, 3, 1, np.arange(4.0))) for _ in range(3))

        def d(a, b):
            return trajectory_gospa(a, b, 2.0, 1.0, 1.0).distance

        assert d(x, x) == pytest.approx(0, abs=1e-6)
        assert d(x, y) == pytest.approx(d(y, x), abs=1e-6)
        assert d(x, z) <= d(x, y) + d(y, z) + 1e-6


def test_scale_and_small_distances():
    times = np.arange(5.0)
    for scale in (1e-12, 1e12):
        truth, tracks = [(times, times * scale)], [(times, (times + 1e-9) * scale)]
        result = trajectory_gospa(truth, tracks, 10 * scale, 2, scale)
        assert result.distance == pytest.approx(math.sqrt(5) * 1e-9 * scale, rel=1e-6)


def test_a_switch_that_is_too_costly_is_never_made():
    times = np.arange(4.0)
    truth = [(times, times)]
    tracks = [(times[:3], times[:3]), (times[2:], times[2:])]
    for gamma in (1e3, 1e300):
        result = trajectory_gospa(truth, tracks, 1e-3, 3, gamma)
        assert result.totals()["switching"] == 0.0
        assert result.totals()["missed"] == pytest.approx(0.5e-9)
    one, many = (
        [(times, rng.normal(size=4)) for _ in range(3)]
        for rng in map(np.random.default_rng, (1, 2))
    )
    costly, larger = (trajectory_gospa(one, many, 1.0, 2, gamma).distance for gamma in (1e2, 1e200))
    assert costly == pytest.approx(larger, rel=1e-7)


def test_nothing():
    result = trajectory_gospa([], [], 1, 1, 1)
    assert (result.distance, result.times.size, result.switching.size) == (0.0, 0, 0)
    result = trajectory_gospa([([0, 1], [[1, 2], [3, 4]])], [([], [])], 3, 2, 1)
    assert result.totals() == {"localization": 0, "missed": 9.0, "false": 0, "switching": 0}
    assert result.distance == 3.0
    assert isinstance(result.distance, float)
    assert list(result.to_dict()) == [
        "distance",
        "times",
        "localization",
        "missed",
        "false",
        "switching",
    ]


POINT = [([0.0], [[0.0, 0.0]])]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"c": math.inf}, "c must be positive and finite, got inf"),
        ({"c": 1e200, "p": 2}, "c must be such that its p-th power is finite, got 1e+200"),
        ({"gamma": 0}, "gamma must be positive and finite, got 0.0"),
        ({"p": 0.5}, "p must be finite and at least 1, got 0.5"),
        ({"distance": "taxi"}, "distance must be 'euclidean' or 'p-norm', got 'taxi'"),
        ({"tracks": [([], []), ([0], [[1.0]])]}, "tracks[1][0] has 1 coordinates, expected 2"),
        ({"truth": [([0, 0], [[1.0], [2.0]])]}, "truth[0] has time 0.0 twice"),
    ],
)
def test_bad_arguments_are_named(arguments, text):
    with pytest.raises(ValueError, match=r"^") as raised:
        trajectory_gospa(
            **{"truth": POINT, "tracks": POINT, "c": 1, "p": 1, "gamma": 1, **arguments}
        )
    assert str(raised.value) == text


def oracle_side(case, side):
    """States stand at their times; what lies outside a trajectory's life is filler."""
    pairs = []
    for states, start, length in zip(
        case[f"{side}_states"], case[f"{side}_start"], case[f"{side}_len"], strict=True
    ):
        times = [t for t in range(start, start + length) if None not in states[t - 1]]
        pairs.append((times, [states[t - 1] for t in times]))
    return pairs


@pytest.mark.data
def test_values_of_the_authors_code(data):
    record = json.loads((data / "mot/values/tgospa_reference.json").read_text())
    for case in record["cases"]:
        sides = oracle_side(case, "x"), oracle_side(case, "y")
        result = trajectory_gospa(*sides, case["c"], case["p"], case["gamma"], distance="p-norm")
        assert result.distance == pytest.approx(case["dxy"], rel=9e-7)
        names = ("loc", "miss", "fa", "switch")
        for part, name in zip(result.totals().values(), names, strict=True):
            assert part == pytest.approx(sum(case[name]), rel=1e-6, abs=1e-6)
