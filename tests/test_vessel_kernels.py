"""The vessel estimator's kernels: Rust, NumPy reference and definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from trackmetrics import _native, _numpy
from trackmetrics._numpy.vessel_motion import KNOT, degree, noise

CONSTANT = (1e-3, 1e-7, 1e-6, np.inf)
MOTIONS = st.tuples(
    st.sampled_from([0.0, 1e-4, 1e-2]),
    st.sampled_from([0.0, 1e-9, 1e-4]),
    st.sampled_from([0.0, 1e-4]),
    st.sampled_from([np.inf, 60.0, 3600.0]),
)
RULES = st.tuples(
    st.integers(1, 4), st.sampled_from([0.02, 0.5]), st.booleans(), st.sampled_from([600.0, 3600.0])
)


def close(found, expected, scale=None, rel=1e-8):
    """Equal to rounding, element by element or against a scale."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    assert (np.isnan(found) == np.isnan(expected)).all()
    size = np.abs(expected) if scale is None else scale
    assert (np.nan_to_num(np.abs(found - expected)) <= rel * np.nan_to_num(size) + 1e-300).all()


def close_covariances(found, expected, rel=1e-8):
    """Element (i, j) in units of the deviations i and j: states have five different units."""
    d = np.sqrt(np.einsum("nii->ni", expected))
    close(found, expected, d[:, :, None] * d[:, None, :], rel)


def angle_error(a, b):
    d = (a - b) % 360.0
    return np.minimum(d, 360.0 - d)


@st.composite
def states(draw, n):
    """States and covariances as a filter has them."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    x = np.stack(
        [
            rng.uniform(-85, 85, n),
            rng.choice([-179.999, 179.999, 0.0, 30.0], n) + rng.uniform(-0.01, 0.01, n),
            rng.uniform(0, 40, n),
            rng.uniform(0, 360, n),
            rng.uniform(-0.3, 0.3, n),
        ],
        axis=1,
    )
    root = rng.normal(size=(n, 5, 5)) * np.array([1e-4, 1e-4, 1.0, 5.0, 0.05])[:, None]
    return x, root @ root.transpose(0, 2, 1)


@given(states(7), MOTIONS, st.sampled_from([0.0, 1e-3, 10.0, 700.0, 3000.0]))
def test_predictions_agree(state, motion, longest):
    x, p = state
    times = np.linspace(0.0, longest, len(x))
    ours, reference = (b.vessel_predict(x, p, times, motion) for b in (_native, _numpy))
    assert (angle_error(ours[0], reference[0]) < 1e-7).all()
    close_covariances(ours[1], reference[1])
    d = np.sqrt(np.einsum("nii->ni", reference[1]))
    close(ours[2], reference[2], np.abs(reference[2]) + d[:, :, None] / d[:, None, :], rel=1e-7)
    moved = [b.vessel_advance(x, times, motion) for b in (_native, _numpy)]
    assert (angle_error(moved[0], moved[1]) < 1e-7).all()
    assert (angle_error(moved[0], ours[0]) < 1e-9).all()


def test_the_path_is_that_of_small_steps():
    """Integrating the motion in steps of 0.1 s on the ellipsoid's degrees gives the same end."""
    for decay in (np.inf, 200.0):
        x = np.array([60.0, 5.0, 15.0, 350.0, 0.2])
        state = x.copy()
        for _ in range(3000):
            middle = state[3] + state[4] * 0.05
            m_north, m_east, _, _ = degree(state[0])
            d = state[2] * KNOT * 0.1
            state[0] += d * np.cos(np.radians(middle)) / m_north
            state[1] += d * np.sin(np.radians(middle)) / m_east
            state[3] = (state[3] + state[4] * 0.1) % 360
            state[4] *= np.exp(-0.1 / decay)
        end = _native.vessel_advance(x[None], np.array([300.0]), (0.0, 0.0, 0.0, decay))[0]
        error = (end - state) * [111_000.0, 56_000.0, 1, 1, 1]
        # 2.3 km sailed; the course of this explicit integration is itself only of first order.
        assert np.abs(error[:2]).max() < 0.7
        assert abs(error[3]) < 2e-2
        assert abs(error[4]) < 1e-4


@pytest.mark.parametrize("decay", [np.inf, 400.0])
def test_noise_is_the_covariance_of_simulated_paths(decay):
    """4000 paths in steps of 2 s with random kicks, against Q: deviations within 5 percent."""
    rng, n, time, dt = np.random.default_rng(1), 4000, 120.0, 2.0
    motion = (1e-3, 1e-7, 1e-4, decay)
    x0 = np.array([50.0, 0.0, 20.0, 60.0, 0.0])
    x = np.tile(x0, (n, 1))
    for _ in range(int(time / dt)):
        # Half the kick before and half after: the sum over steps is then right to second order.
        kick = rng.normal(size=(n, 3)) * np.sqrt(np.array(motion[:3]) * dt) / [KNOT, 1, 1]
        x[:, [2, 4, 3]] += kick / 2
        x = _native.vessel_advance(x, np.full(n, dt), motion)
        x[:, [2, 4, 3]] += kick / 2
    q = noise(x0, time, motion)
    error = x - _native.vessel_advance(x0[None], np.array([time]), motion)
    error[:, 3] = (error[:, 3] + 180) % 360 - 180
    found = np.cov(error.T)
    scale = np.sqrt(np.outer(np.diag(q), np.diag(q)))
    assert np.abs((found - q) / scale).max() < 0.09
    assert np.abs(np.sqrt(np.diag(found) / np.diag(q)) - 1).max() < 0.05


@st.composite
def reports(draw):
    """Reports of a few vessels: mixed kinds, silences, equal and falling times, far jumps."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    counts = draw(st.lists(st.integers(0, 12), min_size=1, max_size=4))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    n = int(starts[-1])
    steps = rng.choice([0.0, 2.0, 60.0, 400.0, 1900.0, 4000.0, -30.0], n)
    times = np.cumsum(steps) + draw(st.sampled_from([0.0, 1.7e9]))
    # Northward at 10 kt: nonsense would make the filter chaotic, and rounding errors with it.
    sailed = np.cumsum(np.maximum(steps, 0)) * 10 * KNOT / 111_000
    jumps = rng.choice([0.0, 0.01], n, p=[0.9, 0.1])
    z = np.stack(
        [
            draw(st.sampled_from([-80.0, 0.0, 60.0])) + sailed + rng.normal(size=n) * 1e-4,
            draw(st.sampled_from([0.0, 179.999])) + jumps + rng.normal(size=n) * 1e-4,
            np.abs(rng.normal(10, 1, n)),
            rng.normal(0, 5, n) % 360,
        ],
        axis=1,
    )
    observed = rng.integers(2, 5, n)
    z[np.arange(4) >= observed[:, None]] = np.nan
    sigmas = np.tile(draw(st.sampled_from([[10.0, 0.3, 1.5], [600.0, 2.0, 3.0]])), (n, 1))
    return starts, times, z, observed, sigmas


def empty(tracks):
    return np.zeros((tracks, 7)), np.zeros((tracks, 5)), np.zeros((tracks, 5, 5))


@given(reports(), MOTIONS, RULES)
def test_filters_agree(batch, motion, rules):
    state = empty(len(batch[0]) - 1)
    ours, reference = (b.vessel_filter(*state, *batch, motion, rules) for b in (_native, _numpy))
    assert ours[1][0].tolist() == reference[1][0].tolist()
    assert ours[1][1].tolist() == reference[1][1].tolist()
    close(ours[0][0], reference[0][0])
    # Where an update shrinks a variance a million times, so it does the digits that are left of it.
    for k in (3, 5, 6, 9):
        close_covariances(np.nan_to_num(ours[1][k]), np.nan_to_num(reference[1][k]), rel=1e-5)
        assert (np.isnan(ours[1][k]) == np.isnan(reference[1][k])).all()
    close(ours[1][7], reference[1][7], np.abs(reference[1][7]) + 1e-2, rel=1e-4)
    for k in (2, 8):
        assert (np.nan_to_num(angle_error(ours[1][k], reference[1][k])) < 1e-3).all()
    assert np.isfinite(ours[1][8][ours[1][0] > 0]).all()
    assert np.isfinite(ours[1][9][ours[1][0] > 0]).all()
    assert np.isfinite(ours[1][7][ours[1][0] == 3]).all()


@given(reports(), st.integers(0, 12))
def test_two_calls_are_one(batch, cut):
    """The tracks carry everything that the next call needs, to the last bit."""
    starts, times, z, observed, sigmas = batch
    motion, rules = (1e-4, 1e-7, 0.0, np.inf), (2, 0.02, False, 3600.0)
    whole = _native.vessel_filter(*empty(len(starts) - 1), *batch, motion, rules)
    state = empty(1)
    n = int(starts[1])
    cut = min(cut, n)
    parts = []
    for rows in (slice(0, cut), slice(cut, n)):
        piece = [np.ascontiguousarray(a[rows]) for a in (times, z, observed, sigmas)]
        offsets = np.array([0, len(piece[0])])
        state, out = _native.vessel_filter(*state, offsets, *piece, motion, rules)
        parts.append(out)
    for k in range(11):
        joined = np.concatenate([parts[0][k], parts[1][k]])
        assert np.array_equal(joined, whole[1][k][:n], equal_nan=True)


@given(states(9), MOTIONS, st.integers(0, 2**32), st.sampled_from([0.0, 10.0, 3000.0]))
def test_gates_are_those_of_all_pairs(state, motion, seed, longest):
    x, p = state
    rng = np.random.default_rng(seed)
    p[0] *= 1e6
    p[1, 3, :] *= 30.0
    p[1, :, 3] *= 30.0
    times = rng.uniform(0, longest, len(x)) if longest else np.zeros(len(x))
    ends = _native.vessel_advance(x, times, motion)[:, :2]
    z = (
        ends[rng.integers(0, len(x), 30)]
        + rng.normal(size=(30, 2)) * rng.choice([1e-4, 0.1], 30)[:, None]
    )
    z[:, 0] = np.clip(z[:, 0], -89, 89)
    sigmas = rng.choice([10.0, 500.0], 30)
    gate = float(chi2.ppf(0.999, 2))
    arguments = (x, p, times, z, sigmas, gate, motion)
    ours, reference = _native.vessel_gate(*arguments), _numpy.vessel_gate(*arguments)
    assert ours[0].tolist() == reference[0].tolist()
    assert ours[1].tolist() == reference[1].tolist()
    close(ours[2], reference[2], np.abs(reference[2]) + 1.0, rel=1e-6)
    close(ours[3], reference[3], np.abs(reference[3]), rel=1e-6)


def one(**change):
    """Arguments of a filter over one report, some of them wrong."""
    arguments = {
        "life": np.zeros((1, 7)),
        "x": np.zeros((1, 5)),
        "P": np.zeros((1, 5, 5)),
        "starts": np.array([0, 1]),
        "times": np.array([0.0]),
        "z": np.array([[50.0, 1.0, 10.0, 90.0]]),
        "observed": np.array([4]),
        "sigmas": np.array([[10.0, 0.3, 1.5]]),
        "motion": CONSTANT,
        "rules": (2, 0.02, False, 3600.0),
    }
    return {**arguments, **change}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"times": np.array([np.nan])}, "times[0] is not finite: nan"),
        ({"z": np.array([[50.0, np.inf, 1.0, 1.0]])}, "z[0][1] is not finite: inf"),
        (
            {"z": np.array([[91.0, 0, 1, 1]])},
            "z[0][0] must be a latitude within 90 degrees, got 91.0",
        ),
        ({"observed": np.array([5])}, "observed[0] must be 2, 3 or 4, got 5.0"),
        (
            {"sigmas": np.array([[10.0, 0.0, 1]])},
            "sigmas[0][1] must be positive and finite, got 0.0",
        ),
        ({"sigmas": np.zeros((2, 3))}, "sigmas has 2 reports, times has 1"),
        (
            {"starts": np.array([0, 2])},
            "starts: starts must rise from 0 to 1, the number of points",
        ),
        ({"motion": (-1.0, 0.0, 0.0, 1.0)}, "acceleration must be at least 0 and finite, got -1.0"),
        ({"motion": (0.0, 0.0, 0.0, 0.0)}, "decay must be positive, got 0.0"),
        ({"rules": (0, 0.02, False, 1.0)}, "tentative must be positive, got 0.0"),
        ({"rules": (1, np.nan, False, 1.0)}, "turn_rate must be positive, got nan"),
        ({"rules": (1, 0.1, False, -5.0)}, "delete_after must be positive, got -5.0"),
    ],
)
@pytest.mark.parametrize("backend", [_native, _numpy])
def test_what_is_wrong_is_named(backend, change, text):
    with pytest.raises(ValueError, match=r"\w") as caught:
        backend.vessel_filter(**one(**change))
    assert str(caught.value) == text


@pytest.mark.parametrize("backend", [_native, _numpy])
def test_a_covariance_that_overflows_is_named(backend):
    state = one(
        life=np.array([[5.0, 1, 0, 0, 50, 1, 10]]),
        P=np.full((1, 5, 5), -1e3),
        times=np.array([1.0]),
    )
    with pytest.raises(
        np.linalg.LinAlgError, match=r"S\[0\] is not positive definite \(leading minor 1\)"
    ):
        backend.vessel_filter(**state)


@pytest.mark.parametrize("backend", [_native, _numpy])
@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"x": np.full((1, 5), np.nan)}, "x[0][0] is not finite: nan"),
        ({"P": np.full((1, 5, 5), np.inf)}, "P[0] is not finite: inf"),
        ({"times": np.array([-1.0])}, "times[0] must be at least 0 and finite, got -1.0"),
        ({"z": np.array([[np.nan, 0.0]])}, "z[0][0] is not finite: nan"),
        ({"z": np.zeros((2, 2))}, "z has 2 positions, sigmas has 1"),
        ({"sigmas": np.array([-1.0])}, "sigmas[0] must be positive and finite, got -1.0"),
        ({"gate": 0.0}, "gate must be positive and finite, got 0.0"),
        ({"x": np.zeros((2, 5))}, "x has 2 states, times has 1"),
        ({"P": np.zeros((2, 5, 5))}, "P has 2 states, times has 1"),
    ],
)
def test_what_is_wrong_with_a_gate_is_named(backend, change, text):
    arguments = {
        "x": np.zeros((1, 5)),
        "P": np.eye(5)[None],
        "times": np.array([1.0]),
        "z": np.zeros((1, 2)),
        "sigmas": np.array([10.0]),
        "gate": 9.0,
        "motion": CONSTANT,
        **change,
    }
    with pytest.raises(ValueError, match=r"\w") as caught:
        backend.vessel_gate(**arguments)
    assert str(caught.value) == text
