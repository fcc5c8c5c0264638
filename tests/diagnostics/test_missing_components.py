"""Vectors of which some components are missing: what is left, with its own degrees of freedom."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackmetrics import use_backend
from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog, State, read_log

NAN = np.nan


def covariance(rng, d):
    root = rng.normal(size=(d, d))
    return root @ root.T + 0.5 * np.eye(d)


def masked(matrix, there):
    return np.where(there[:, None] & there[None, :], matrix, NAN)


@st.composite
def rows(draw):
    """Vectors and covariances, each with some components missing, not always the same ones."""
    d, count = draw(st.integers(1, 4)), draw(st.integers(1, 5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    vectors = rng.normal(size=(count, d)) * 10.0 ** rng.integers(-3, 4, d)
    matrices = [masked(covariance(rng, d), rng.random(d) < 0.8) for _ in range(count)]
    return np.where(rng.random((count, d)) < 0.7, vectors, NAN), np.array(matrices)


def form(vector, matrix):
    """The definition: the sub-vector and its sub-covariance."""
    both = np.flatnonzero(~np.isnan(vector) & ~np.isnan(matrix.diagonal()))
    if not len(both):
        return NAN, 0
    v, p = vector[both], matrix[np.ix_(both, both)]
    return v @ np.linalg.solve(p, v), len(both)


@given(rows())
def test_nis_and_nees_are_those_of_what_is_there(case):
    vectors, matrices = case
    d = vectors.shape[1]
    expected = [form(v, p) for v, p in zip(vectors, matrices, strict=True)]
    for vector, matrix, value in (("innovation", "S", "nis"), ("error", "P", "nees")):
        log = EstimatorLog.from_columns(
            **{vector: vectors, matrix: matrices}, status="tentative", state_dim=d
        )
        np.testing.assert_allclose(
            getattr(log.columns, value), [e for e, _ in expected], rtol=1e-9, atol=1e-300
        )
        dof = getattr(log.columns, f"{value}_dof")
        known = ~np.isnan(getattr(log.columns, value))
        assert dof[known].tolist() == [n for _, n in expected if n]


def test_a_constant_number_of_components_does_not_overrule_what_is_there():
    log = EstimatorLog.from_columns(
        innovation=[[1.0, 2.0], [NAN, 2.0]], S=np.tile(np.eye(2), (2, 1, 1)), nis_dof=2
    )
    assert log.columns.nis.tolist() == [5.0, 4.0]
    assert log.columns.nis_dof.tolist() == [2.0, 1.0]
    logged = EstimatorLog.from_columns(z=[[1.0, 2.0], [NAN, 2.0]], nis=[5.0, 4.0], nis_dof=2)
    assert logged.columns.nis_dof.tolist() == [2.0, 2.0]


def test_a_logged_nees_is_of_all_states_unless_the_log_says_otherwise():
    columns = {"nees": [4.0, 4.0, 4.0], "error": [[k, NAN, 2.0] for k in (1.0, 2.0, 3.0)]}
    alone = EstimatorLog.from_columns(**columns)
    assert alone.columns.nees_dof.tolist() == [3.0, 3.0, 3.0]
    said = EstimatorLog.from_columns(**columns, nees_dof=2)
    assert said.columns.nees_dof.tolist() == [2.0, 2.0, 2.0]
    shown = EstimatorLog.from_columns(**columns, P=[np.eye(3), None, np.eye(3)])
    assert shown.columns.nees_dof.tolist() == [2.0, 3.0, 2.0]


def test_innovations_and_errors_follow_component_by_component():
    log = EstimatorLog.from_columns(
        z=[[NAN, 350.0]], x_pred=[[1.0, 5.0, 0.0]], observed=[["east", "course"]],
        P_pred=np.eye(3)[None], R=4 * np.eye(2)[None],
        x=[[2.0, 3.0, NAN]], truth=[[NAN, 359.0, 7.0]], P=9 * np.eye(3)[None],
        states=[State("east"), State("course", "deg", 360.0), State("rate")],
    )  # fmt: skip
    c = log.columns
    np.testing.assert_array_equal(c.innovation, [[NAN, -15.0]])
    np.testing.assert_array_equal(c.error, [[NAN, 4.0, NAN]])
    assert (c.nis[0], c.nis_dof[0]) == (pytest.approx(225.0 / 5.0), 1.0)
    assert (c.nees[0], c.nees_dof[0]) == (pytest.approx(16.0 / 9.0), 1.0)


@pytest.mark.parametrize("ending", ["jsonl", "csv", "parquet"])
def test_a_log_with_gaps_comes_back_from_its_file(tmp_path, ending):
    rng = np.random.default_rng(2)
    n = 12
    gaps = rng.random((n, 3)) < 0.3
    log = EstimatorLog.from_columns(
        time=10.0 * np.arange(n),
        z=np.where(gaps, NAN, rng.normal(size=(n, 3))),
        observed=[[-1, 2, 0]] * n,
        x_pred=rng.normal(size=(n, 3)),
        S=[masked(covariance(rng, 3), ~gap) for gap in gaps],
        x=np.where(gaps[::-1], NAN, rng.normal(size=(n, 3))),
        P=[masked(covariance(rng, 3), ~gap) for gap in gaps[::-1]],
        truth=rng.normal(size=(n, 3)),
    )
    log.write(tmp_path / f"log.{ending}")
    back = read_log(tmp_path / f"log.{ending}").columns
    for name in ("z", "observed", "innovation", "S", "x", "P", "error", "nis", "nees", "nees_dof"):
        np.testing.assert_array_equal(getattr(back, name), getattr(log.columns, name), name)


# -- a consistent filter whose sensor and whose truth come in parts

F = np.kron(np.eye(2), [[1.0, 5.0], [0.0, 1.0]])
Q = np.kron(np.eye(2), 0.5 * np.array([[125 / 3, 12.5], [12.5, 5.0]]))
H = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 1.0, 0, 0]])
R = np.diag([100.0, 225.0, 4.0])
STATES = [State("x", "m"), State("vx", "m/s"), State("y", "m"), State("vy", "m/s")]


def simulate(
    runs, updates=60, lost=0.35, untold=0.35, model=True, r=1.0, offset=(0, 0, 0), truth_offset=0.0,
    seed=0,
):  # fmt: skip
    """Constant velocity; x, y and the speed along x are each lost at random, the truth as well."""
    rng = np.random.default_rng(seed)
    names = ("innovation", "S", "error", "P", "P_pred", "A")
    shapes = ((3,), (3, 3), (4,), (4, 4), (4, 4), (4, 4))
    out = {n: np.full((runs, updates, *s), NAN) for n, s in zip(names, shapes, strict=True)}
    for run in range(runs):
        P, truth = np.diag([100.0, 25.0, 100.0, 25.0]), np.zeros(4)
        x = rng.normal(size=4) * [10.0, 5.0, 10.0, 5.0]
        for k in range(updates):
            truth = F @ truth + np.linalg.cholesky(Q) @ rng.normal(size=4)
            there = rng.random(3) >= lost
            there[rng.integers(3)] = True
            h, noise = H[there], R[np.ix_(there, there)]
            z = h @ truth + np.sqrt(noise.diagonal()) * rng.normal(size=len(h))
            z = z + np.asarray(offset)[there]
            x, P_pred = F @ x, F @ P @ F.T + Q
            S = h @ P_pred @ h.T + r * noise
            K = np.linalg.solve(S, h @ P_pred).T
            innovation = z - h @ x
            x, P = x + K @ innovation, P_pred - K @ S @ K.T
            known = rng.random(4) >= untold
            known[rng.integers(4)] = True
            error = x - truth + truth_offset * np.sqrt(P.diagonal())
            out["innovation"][run, k, there] = innovation
            out["S"][run, k][np.ix_(there, there)] = S
            out["error"][run, k, known] = error[known]
            out["P"][run, k], out["P_pred"][run, k] = (P + P.T) / 2, P_pred
            out["A"][run, k] = (np.eye(4) - K @ h) @ F
    columns = {n: v.reshape(runs * updates, *v.shape[2:]) for n, v in out.items()}
    if not model:
        del columns["A"]
    return EstimatorLog.from_columns(
        track=np.repeat([f"run {i}" for i in range(runs)], updates),
        time=np.tile(5.0 * np.arange(updates), runs),
        measurement_type="radar",
        observed=[["x", "y", "vx"]] * (runs * updates),
        states=STATES,
        **columns,
    )


@pytest.mark.parametrize("model", [True, False])
def test_a_well_tuned_filter_is_consistent(model):
    found = diagnose(simulate(200, model=model, seed=3))
    wrong = [t.verdict for t in found.values() if not t.consistent]
    # At most 5 % in the long run: 10 of 200, and as much again in one case of 400.
    assert len(wrong) <= 19
    assert {t.nis.verdict for t in found.values()} >= {"consistent"}


@settings(max_examples=4)
@given(st.integers(0, 2**32))
def test_nis_and_nees_have_the_distribution_of_their_own_degrees_of_freedom(seed):
    from scipy import stats

    c = simulate(10, updates=40, seed=seed).columns
    for values, dof in ((c.nis, c.nis_dof), (c.nees[::20], c.nees_dof[::20])):
        assert len(set(dof)) > 2
        assert stats.kstest(stats.chi2.cdf(values, dof), "uniform").pvalue > 1e-6


def test_a_noise_that_is_too_small_is_found_and_the_page_names_no_other_cause():
    found = diagnose(simulate(20, updates=80, r=0.25, seed=5))
    assert sum(t.verdict == "optimistic" for t in found.values()) >= 18
    assert {t.cause for t in found.values()} <= {"measurement noise too small", None}


def test_an_offset_of_one_component_is_named():
    found = diagnose(simulate(20, updates=80, offset=(0.0, 0.0, 4.0), seed=6))
    named = [b.component for t in found.values() for b in t.biases if b.kind == "innovation"]
    assert sum(t.verdict == "biased" for t in found.values()) >= 18
    assert named.count("vx") >= 18
    assert named.count("y") <= 2


def test_an_offset_of_the_states_is_found_without_a_whole_error():
    found = diagnose(simulate(10, updates=80, truth_offset=1.5, seed=7))
    assert sum(t.nees.verdict == "biased" for t in found.values()) >= 9
    assert all(b.value > 0 for t in found.values() for b in t.biases if b.kind == "state")


def test_offsets_are_generalised_least_squares_over_what_is_there():
    from trackmetrics.diagnostics.bias import mean_innovations
    from trackmetrics.diagnostics.innovations import Innovations

    rng = np.random.default_rng(8)
    n = 40
    values = rng.normal(size=(n, 3))
    values[rng.random((n, 3)) < 0.4] = NAN
    values[5:, 2] = NAN
    s = np.array([masked(covariance(rng, 3), ~np.isnan(v)) for v in values])
    found = mean_innovations(Innovations(values, s, np.full(n, "radar", object)))
    # Stacked rows y = E b + noise, of the components that have eight values.
    information, pulled = np.zeros((2, 2)), np.zeros(2)
    for v, p in zip(values, s, strict=True):
        i = np.flatnonzero(~np.isnan(v[:2]))
        design = np.eye(2)[i]
        weight = np.linalg.inv(p[np.ix_(i, i)]) if len(i) else np.zeros((0, 0))
        information += design.T @ weight @ design
        pulled += design.T @ weight @ v[i]
    assert [b.index for b in found] == [0, 1]
    assert [b.value for b in found] == pytest.approx(np.linalg.solve(information, pulled))


def test_shares_are_averages_over_the_updates_that_have_the_state():
    from trackmetrics.diagnostics.attribution import attribute_nees

    errors = np.array([[3.0, 4.0, NAN], [1.0, NAN, NAN], [NAN, 2.0, NAN]])
    found = attribute_nees(errors, np.tile(np.eye(3), (3, 1, 1)))
    np.testing.assert_allclose(found.shapley_nees, [5.0, 10.0, NAN])
    np.testing.assert_allclose(found.marginal_nees, [5.0, 10.0, NAN])
    np.testing.assert_allclose(found.conditional_nees, [5.0, 10.0, NAN])
    np.testing.assert_allclose(found.nees_share, [10 / 30, 20 / 30, NAN])
    correlated = np.array([[[1.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 1.0]]])
    pair = attribute_nees(errors[:1], correlated)
    alone = attribute_nees(errors[:1, :2], correlated[:, :2, :2])
    np.testing.assert_allclose(pair.shapley_nees[:2], alone.shapley_nees)
    np.testing.assert_allclose(pair.conditional_nees[:2], alone.conditional_nees)


def test_support_and_notes_count_what_is_there():
    log = simulate(1, updates=40, seed=9)
    track = diagnose(log)["run 0"]
    seen = ~np.isnan(log.columns.innovation)
    # x, y and vx are the components; vy is never observed.
    assert [s.num_direct_updates for s in track.states] == [*seen.sum(axis=0)[[0, 2, 1]], 0]
    lacking = int((~seen).any(axis=1).sum())
    assert track.notes[0].startswith(f"{lacking} innovations lack components")
    assert track.notes[1].split()[1] == "errors"
    assert track.notes[0] in track.text


def test_both_backends_say_the_same():
    log = simulate(4, updates=40, offset=(0.0, 60.0, 0.0), seed=11)
    with use_backend("numpy"):
        reference = diagnose(log)
    for name, track in diagnose(log).items():
        assert reference[name].verdict == track.verdict
        assert reference[name].nees.autocorrelation_time == pytest.approx(
            track.nees.autocorrelation_time, rel=1e-9
        )
        for ours, theirs in zip(track.states, reference[name].states, strict=True):
            assert theirs.nees_share == pytest.approx(ours.nees_share, rel=1e-9, nan_ok=True)
