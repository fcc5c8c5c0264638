"""Factors on claimed noises: likelihoods against joint densities, estimates on known plants."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import trackmetrics
from trackmetrics.diagnostics import LinearModel, estimate_noise
from trackmetrics.diagnostics._noise_fit import ErrorModel, Profile, maximise, tail_scales
from trackmetrics.diagnostics._noise_model import log_model
from trackmetrics.logs import EstimatorLog, read_log


@pytest.fixture
def native():
    """The compiled kernels, whatever the backend of the other tests."""
    with trackmetrics.use_backend("native"):
        yield


def random_model(rng, n, m, updates, tracks=1, types=1, groups=1, missing=0.0, periods=False):
    """An error model with arbitrary matrices and corrections."""
    rows = updates * tracks

    def covariances(*shape):
        root = rng.normal(size=(*shape, shape[-1]))
        return root @ root.swapaxes(-1, -2) + 0.1 * np.eye(shape[-1])

    innovations = rng.normal(size=(rows, m)) * 2
    innovations[rng.random((rows, m)) < missing] = np.nan
    period = np.full((rows, m), np.nan)
    if periods:
        period[:, 0] = 3.0
    return ErrorModel(
        innovations=innovations,
        H=rng.normal(size=(rows, m, n)),
        R=covariances(rows, m),
        types=rng.integers(0, types, rows),
        F=rng.normal(size=(rows, n, n)) * 0.6,
        Q=covariances(rows, groups, n),
        corrections=rng.normal(size=(rows, n)),
        periods=period,
        initial=covariances(tracks, n),
        starts=np.arange(tracks + 1) * updates,
        process=tuple(f"q{i}" for i in range(groups)),
        measurement=tuple(f"r{i}" for i in range(types)),
        initial_factor=1.7,
    )


def joint_density(model, factors):
    """The log-density of all innovations of one track, from their mean and full covariance."""
    rows, m, n = model.H.shape
    split = len(model.process)
    q, r = factors[:split], factors[split:]
    # The error is a linear function of (initial error, noises), with a mean from the corrections.
    size = n * rows
    step, mean = np.zeros((n, size)), np.zeros(n)
    step[:, :n] = np.eye(n)
    prior = np.zeros((size, size))
    prior[:n, :n] = model.initial_factor * model.initial[0]
    maps, means, noise = [], [], np.zeros((rows * m, rows * m))
    for k in range(rows):
        if k:
            own = slice(k * n, k * n + n)
            step, mean = model.F[k] @ step, model.F[k] @ (mean - model.corrections[k - 1])
            step[:, own] += np.eye(n)
            prior[own, own] = np.einsum("g,gij->ij", q, model.Q[k])
        maps.append(model.H[k] @ step)
        means.append(model.H[k] @ mean)
        block = slice(k * m, k * m + m)
        noise[block, block] = r[model.types[k]] * model.R[k]
    G = np.concatenate(maps)
    covariance = G @ prior @ G.T + noise
    values, there = model.innovations.ravel(), ~np.isnan(model.innovations.ravel())
    return stats.multivariate_normal.logpdf(
        values[there], np.concatenate(means)[there], covariance[np.ix_(there, there)]
    )


@pytest.mark.parametrize(
    ("n", "m", "updates", "missing"), [(1, 1, 6, 0), (2, 1, 5, 0), (3, 2, 6, 0.3)]
)
def test_the_likelihood_is_the_joint_density_of_all_innovations(n, m, updates, missing):
    rng = np.random.default_rng(n)
    model = random_model(rng, n, m, updates, types=2, groups=2, missing=missing)
    factors = np.array([0.7, 2.0, 1.5, 0.4])
    assert model.likelihood(factors) == pytest.approx(joint_density(model, factors), rel=1e-9)


@given(
    st.integers(0, 2**32 - 1), st.integers(1, 7), st.integers(1, 5), st.integers(0, 4),
    st.sampled_from([math.inf, 4.0]), st.booleans(),
)  # fmt: skip
def test_kernel_and_reference_agree(seed, n, m, updates, tail_dof, periods):
    rng = np.random.default_rng(seed)
    model = random_model(
        rng, n, m, updates, tracks=2, types=2, groups=2, missing=0.2, periods=periods
    )
    model = replace(model, tail_dof=tail_dof)
    factors = rng.uniform(0.2, 4, 4)
    for derivatives in (True, False):
        found = []
        for backend in ("native", "numpy"):
            with trackmetrics.use_backend(backend):
                found.append(model.evaluate(factors, derivatives))
        for kernel, reference in zip(*found, strict=True):
            assert kernel.shape == reference.shape
            np.testing.assert_allclose(kernel, reference, rtol=1e-6, atol=1e-7)


@given(st.integers(0, 2**32 - 1), st.sampled_from([math.inf, 4.0]))
def test_the_gradient_is_that_of_finite_differences(seed, tail_dof):
    rng = np.random.default_rng(seed)
    model = replace(random_model(rng, 3, 2, 6, types=2, groups=2), tail_dof=tail_dof)
    factors = rng.uniform(0.5, 3, 4)
    gradient = model.evaluate(factors)[1].sum(0)
    for i in range(5):
        moved = []
        for h in (1e-5, -1e-5):
            shifted = factors + h * (np.arange(4) == i)
            initial = model.initial_factor + h * (i == 4)
            densities = model.evaluate(shifted, False, initial)[0]
            moved.append(densities.sum())
        # A weight of exactly 1 is where the likelihood of the t distribution has a kink.
        if tail_dof == math.inf:
            assert gradient[i] == pytest.approx((moved[0] - moved[1]) / 2e-5, rel=1e-4, abs=1e-4)
        else:
            assert gradient[i] == pytest.approx((moved[0] - moved[1]) / 2e-5, rel=1e-2, abs=1e-2)


def test_sizes_that_are_padded_agree_with_the_reference():
    for n, m in [(10, 3), (17, 5), (33, 2)]:
        model = random_model(np.random.default_rng(n), n, m, 3)
        model = replace(model, F=model.F / n)
        results = []
        for backend in ("native", "numpy"):
            with trackmetrics.use_backend(backend):
                results.append(model.evaluate(np.array([1.3, 0.8])))
        for kernel, reference in zip(*results, strict=True):
            np.testing.assert_allclose(kernel, reference, rtol=1e-8, atol=1e-9)


def test_threads_change_no_bit():
    model = random_model(np.random.default_rng(3), 4, 2, 5, tracks=40)
    before = trackmetrics.threads()
    found = []
    try:
        for threads in (1, 2):
            trackmetrics.set_threads(threads)
            found.append(model.evaluate(np.ones(2)))
    finally:
        trackmetrics.set_threads(before)
    for one, many in zip(*found, strict=True):
        assert (one == many).all()


def test_a_steady_random_walk_has_the_density_of_its_closed_form():
    # P_pred = q (1 + sqrt(1 + 4 r / q)) / 2, S = P_pred + r; innovations are independent N(0, S).
    q, r, updates = 2.0, 3.0, 40
    P_pred = q * (1 + math.sqrt(1 + 4 * r / q)) / 2
    S, rng = P_pred + r, np.random.default_rng(5)
    nu = rng.normal(size=(updates, 1)) * math.sqrt(S)
    ones = np.ones((updates, 1, 1))
    model = ErrorModel(
        nu, ones, r * ones, np.zeros(updates, np.int64), ones, q * ones[:, None],
        nu * P_pred / S, np.full((updates, 1), np.nan), np.full((1, 1, 1), P_pred),
        np.array([0, updates]), ("all",), ("all",), initial_factor=1.0,
    )  # fmt: skip
    expected = stats.norm.logpdf(nu, scale=math.sqrt(S)).sum()
    assert model.likelihood(np.ones(2)) == pytest.approx(expected, rel=1e-12)
    # Both factors together scale S: the best common factor is the mean of nu^2 / S.
    best = float((nu**2).mean() / S)
    larger = replace(model, initial=model.initial * best)
    both = stats.norm.logpdf(nu, scale=math.sqrt(best * S)).sum()
    assert larger.likelihood(np.full(2, best)) == pytest.approx(both, rel=1e-12)


@pytest.mark.usefixtures("native")
def test_the_maximum_has_no_slope_and_the_interval_has_its_likelihood_ratio():
    model = walk(q=3.0, r=0.5, updates=200, seed=1)
    fit = maximise(model)
    assert np.abs(model.evaluate(fit.factors)[1].sum(0)[:2] * fit.factors).max() < 0.05
    low, high = Profile(model, fit, 1).interval(0.95)
    for end in (low, high):
        pinned = maximise(model, np.array([fit.factors[0], end]), [1])
        assert 2 * (fit.value - pinned.value) == pytest.approx(3.84, abs=0.06)


def test_scales_of_the_t_distribution_leave_normal_innovations_alone():
    scales, ratio = tail_scales(3, 5.0)
    assert (scales[1:] > 1).all()
    assert 0.6 < ratio < 1
    assert tail_scales(2, math.inf)[0].tolist() == [1, 1, 1]


# Logs ------------------------------------------------------------------------------------------
# An estimate takes hundreds of likelihoods; the reference is compared with the kernel above.


def walk_columns(q=1.0, r=1.0, updates=300, seed=0, outliers=0.0, claimed=1.0):
    """A random walk with steps of variance 4 and a gauge of variance 9 as the filter claims."""
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(size=updates)) * 2 * math.sqrt(q)
    v = rng.normal(size=updates) * 3 * math.sqrt(r)
    hit = rng.random(updates) < outliers
    v[hit] = 30.0 * rng.choice([-1, 1], hit.sum())
    x, P = 0.0, 100.0
    columns = {name: [] for name in ("innovation", "S", "P_pred", "P", "A", "x", "x_pred", "R")}
    for z in truth + v:
        P_pred, x_pred = P + 4.0, x
        S, nu = P_pred + 9.0, z - x_pred
        K = P_pred / S
        x, P = x_pred + K * nu, (1 - K) * P_pred
        row = ([nu], [[S]], [[P_pred]], [[P]], [[1 - K]], [x], [x_pred], [[9.0]])
        for name, value in zip(columns, row, strict=True):
            columns[name].append(value)
    return columns


def walk_log(drop=(), extra=None, **settings):
    columns = walk_columns(**settings)
    kept = {name: values for name, values in columns.items() if name not in drop}
    return EstimatorLog.from_columns(
        states=["level"], measurement_type=["gauge"] * len(columns["x"]), **kept, **(extra or {})
    )


def walk(**settings):
    H = np.ones((settings.get("updates", 300), 1, 1))
    return log_model(walk_log(extra={"H": H}, **settings), "all", "by_type", None).errors


OBSERVED = {"observed": [["level"]] * 300}


@pytest.mark.usefixtures("native")
@pytest.mark.parametrize(
    ("q", "r", "cause"),
    [(1, 1, ()), (10, 1, ("process all",)), (1, 4, ("measurement gauge",)),
     (1, 0.25, ("measurement gauge",))],
)  # fmt: skip
def test_factors_and_causes_are_found(q, r, cause):
    found = estimate_noise(walk_log(q=q, r=r, extra=OBSERVED))
    for factor, true in ((found.process["all"], q), (found.measurement["gauge"], r)):
        assert factor.interval[0] < true < factor.interval[1]
        assert true / 1.8 < factor.factor < true * 1.8
    assert found.causes == cause
    assert found.explained
    assert found.grade == "exact"
    assert ("no change is significant" in repr(found)) == (not cause)
    assert "measurement noise of gauge: " in repr(found)
    assert found.to_dict()["measurement"]["gauge"]["factor"] == found.measurement["gauge"].factor


def test_both_backends_give_the_same_estimate():
    log = walk_log(r=4, updates=40, extra={"observed": [["level"]] * 40})
    found = []
    for backend in ("native", "numpy"):
        with trackmetrics.use_backend(backend):
            found.append(estimate_noise(log))
    for one, other in zip(*(list(e.measurement.values()) for e in found), strict=True):
        assert one.factor == pytest.approx(other.factor, rel=1e-4)
        assert one.interval == pytest.approx(other.interval, rel=1e-3)


@pytest.mark.usefixtures("native")
def test_every_sufficient_set_of_columns_gives_the_same_answer():
    H = np.ones((300, 1, 1))
    whole = estimate_noise(walk_log(r=4, extra={"H": H}))
    for drop, extra, model in (
        ((), OBSERVED, None),
        (("R",), {"H": H}, None),
        (("P_pred",), {"H": H}, None),
        (("x", "x_pred"), {"H": H}, None),
        (("A",), {"H": H}, LinearModel(F=[[1.0]])),
        (("A", "P"), {}, LinearModel(F=lambda x, dt: [[1.0]], H={"gauge": [[1.0]]})),
        (("A",), {}, LinearModel(F=[[1.0]], H=lambda x_pred, kind: [[1.0]])),
    ):
        other = estimate_noise(walk_log(drop=drop, r=4, extra=extra), model=model)
        assert other.measurement["gauge"].factor == pytest.approx(
            whole.measurement["gauge"].factor, rel=1e-4
        )


@pytest.mark.usefixtures("native")
def test_innovations_and_covariances_alone_give_a_direction():
    drop = ("P_pred", "P", "A", "x", "x_pred", "R")
    found = estimate_noise(walk_log(drop=drop, q=20))
    assert found.grade == "direction"
    assert found.direction == "process noise too small"
    assert found.process == {}
    assert math.isnan(found.statistic)
    assert "No number" in repr(found)
    assert estimate_noise(walk_log(drop=drop)).direction is None


@pytest.mark.usefixtures("native")
def test_what_the_log_does_not_tell_is_no_number():
    # An update only: no process noise has acted, and one innovation with an unknown start.
    columns = {name: values[:1] for name, values in walk_columns().items()}
    log = EstimatorLog.from_columns(states=["level"], observed=[["level"]], **columns)
    found = estimate_noise(log)
    assert found.identifiable == {"process all": False, "measurement all": False}
    assert math.isnan(found.process["all"].factor)
    assert found.process["all"].interval == (0.0, math.inf)
    assert "the log does not tell" in repr(found)


@pytest.mark.usefixtures("native")
def test_outliers_are_named_and_a_robust_estimate_ignores_them():
    log = walk_log(outliers=0.03, extra=OBSERVED)
    plain, robust = estimate_noise(log), estimate_noise(log, robust=True)
    assert (plain.explained, plain.reason) == (False, "outliers")
    assert plain.causes == ()
    assert plain.measurement["gauge"].factor > 1.5
    assert robust.measurement["gauge"].factor == pytest.approx(1, abs=0.35)


@pytest.mark.usefixtures("native")
def test_tracks_are_pooled_and_those_that_disagree_named():
    parts = [walk_columns(seed=i, r=16.0 if i == 2 else 1.0, updates=100) for i in range(4)]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    log = EstimatorLog.from_columns(
        states=["level"], track=np.repeat(list("abcd"), 100), observed=[["level"]] * 400, **columns
    )
    found = estimate_noise(log)
    assert "c" in found.disagreeing
    assert found.updates == 400


@pytest.mark.usefixtures("native")
def test_a_block_of_states_has_its_own_factor():
    one, two = walk_columns(q=10, seed=1), walk_columns(seed=2)
    both = {name: [np.concatenate(pair) for pair in zip(one[name], two[name], strict=True)]
            for name in ("x", "x_pred", "innovation")}  # fmt: skip
    for name in ("S", "P_pred", "P", "A", "R"):
        both[name] = [
            np.diag([a[0][0], b[0][0]]) for a, b in zip(one[name], two[name], strict=True)
        ]
    log = EstimatorLog.from_columns(states=["a", "b"], observed=[["a", "b"]] * 300, **both)
    found = estimate_noise(log, process="by_block")
    assert set(found.process) == {"a", "b"}
    assert found.process["a"].interval[0] > 3
    assert found.process["b"].interval[0] < 1 < found.process["b"].interval[1]
    named = estimate_noise(log, process={"first": ["a"], "second": ["b"]})
    assert named.process["first"].factor == found.process["a"].factor
    with pytest.raises(ValueError, match="state 'a' is in two groups"):
        estimate_noise(log, process={"first": ["a"], "second": ["a", "b"]})
    with pytest.raises(ValueError, match="'b' has process noise and is in no group"):
        estimate_noise(log, process={"first": ["a"]})


@pytest.mark.usefixtures("native")
def test_wrong_arguments_are_named():
    log = walk_log(extra=OBSERVED)
    with pytest.raises(ValueError, match="confidence must be between 0 and 1, got 2"):
        estimate_noise(log, confidence=2)
    with pytest.raises(ValueError, match="measurement must be 'by_type' or 'all', got 'x'"):
        estimate_noise(log, measurement="x")
    with pytest.raises(ValueError, match="process must be 'all', 'by_block' or a dictionary"):
        estimate_noise(log, process="x")
    with pytest.raises(ValueError, match="for a direction the log needs innovation and S"):
        estimate_noise(EstimatorLog.from_columns(nis=[1.0, 2.0], nis_dof=1))
    columns = walk_columns()
    columns["P_pred"] = [[[p[0][0] / 3]] for p in columns["P_pred"]]
    wrong = EstimatorLog.from_columns(states=["level"], **columns, **OBSERVED)
    with pytest.raises(ValueError, match="do not belong to one filter"):
        estimate_noise(wrong, model=LinearModel(F=[[1.0]]))


@pytest.mark.parametrize("ending", ["jsonl", "csv", "parquet"])
def test_observation_matrices_survive_a_file(tmp_path, ending):
    if ending == "parquet":
        pytest.importorskip("polars")
    H = [[[1.0, 0.5], [0.0, -2.0]], None, [[0.25, 0.0]]]
    log = EstimatorLog.from_columns(
        states=["a", "b"],
        innovation=[[1.0, 2.0], [0.5], [0.1]],
        S=[np.eye(2), [[1.0]], [[2.0]]],
        time=[0, 1, 2],
        H=H,
    )
    path = tmp_path / f"log.{ending}"
    log.write(path)
    again = read_log(path)
    np.testing.assert_array_equal(again.columns.H, log.columns.H)
    assert log.columns.H.shape == (3, 2, 2)
    assert np.isnan(log.columns.H[2, 1]).all()


def test_an_observation_matrix_of_another_width_is_refused():
    with pytest.raises(ValueError, match=r"H\[1\] has shape \(1, 3\), expected \(m, 2\)"):
        EstimatorLog.from_columns(
            states=["a", "b"], nis=[1.0, 2.0], nis_dof=1, H=[[[1.0, 0.0]], [[1.0, 0.0, 0.0]]]
        )
