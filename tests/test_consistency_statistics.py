"""The statistics of trackmetrics.consistency: closed forms, and null distributions by simulation.

The simulated filter is consistent: a nearly constant velocity in two dimensions, seen by two
sensors in turn. Every test with a nominal 5 % must reject about 5 % of its runs.
"""

import json
import math

import numpy as np
import pytest

import trackmetrics
from trackmetrics import consistency

RUNS, STEPS, STATES, MEASURED = 2000, 60, 4, 2


class Simulation:
    """A consistent Kalman filter over many runs: errors, innovations and its matrices."""

    def __init__(self, runs=RUNS, steps=STEPS, seed=7):
        rng = np.random.default_rng(seed)
        t = 5.0
        f = np.kron(np.array([[1, t], [0, 1]]), np.eye(2))
        q = 0.5 * np.kron(np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]]), np.eye(2))
        h = np.hstack([np.eye(2), np.zeros((2, 2))])
        p = np.diag([100.0, 100.0, 25.0, 25.0])
        e = rng.multivariate_normal(np.zeros(4), p, runs)
        self.h = h
        names = ["errors", "predicted", "innovations", "noise"]
        record = {name: [] for name in [*names, "P", "P_pred", "S", "R", "A"]}
        for k in range(steps):
            r = np.eye(2) * (10.0 if k % 2 else 15.0) ** 2
            e = e @ f.T + rng.multivariate_normal(np.zeros(4), q, runs)
            prior = f @ p @ f.T + q
            v = rng.multivariate_normal(np.zeros(2), r, runs)
            s = h @ prior @ h.T + r
            gain = np.linalg.solve(s, h @ prior).T
            innovation = e @ h.T + v
            record["predicted"].append(e)
            e = e - innovation @ gain.T
            joseph = np.eye(4) - gain @ h
            p = joseph @ prior @ joseph.T + gain @ r @ gain.T
            p = (p + p.T) / 2
            for name, value in zip(
                ["errors", "innovations", "noise", "P", "P_pred", "S", "R", "A"],
                [e, innovation, v, p, prior, s, r, joseph @ f],
                strict=True,
            ):
                record[name].append(value)
        for name, values in record.items():
            axis = 1 if values[0].ndim == 2 and len(values[0]) == runs else 0
            setattr(self, name, np.stack(values, axis))
        self.P_pred = (self.P_pred + self.P_pred.swapaxes(1, 2)) / 2
        self.S = (self.S + self.S.swapaxes(1, 2)) / 2
        self.nees = np.stack([self.of(k) for k in range(steps)], 1)
        every = [trackmetrics.nis(self.innovations[:, k], self.S[k]) for k in range(steps)]
        self.nis = np.stack(every, 1)

    def of(self, k):
        """NEES of all runs at step k."""
        return trackmetrics.nis(self.errors[:, k], self.P[k])


@pytest.fixture(scope="module")
def sim():
    return Simulation()


def rejected(passed):
    """The share of tests that did not pass."""
    return 1 - np.mean(passed)


def near_five_percent(share, tests):
    """Within four standard errors of 5 %, and half a percent for an approximate distribution."""
    return abs(share - 0.05) < 4 * math.sqrt(0.05 * 0.95 / tests) + 0.005


def test_anees_rejects_as_often_as_it_says(sim):
    groups = sim.nees.reshape(40, 50, STEPS)
    test = consistency.anees(groups, STATES, axis=1)
    assert test.value.shape == (40, STEPS)
    # Steps of one group are correlated: about a third of them count.
    assert near_five_percent(rejected(test.is_consistent), 40 * STEPS / 3)
    assert float(test.dof[0, 0]) == 200


@pytest.mark.parametrize(
    ("runs", "lower", "upper"),
    [(1, 0.166, 2.567), (10, 0.647, 1.428), (25, 0.768, 1.263), (100, 0.880, 1.128)],
)
def test_anees_intervals_of_the_literature(runs, lower, upper):
    test = consistency.anees(np.full(runs, 5.0), 5)
    assert (test.lower, test.upper) == pytest.approx((lower, upper), abs=6e-4)
    assert test.value == 1.0
    assert test.is_consistent is True
    assert test.to_dict()["dof"] == 5.0 * runs


def test_anees_agrees_with_the_consistency_test():
    values = np.random.default_rng(0).chisquare(3, 25)
    ours, theirs = consistency.anees(values, 3), consistency.consistency_test(values, 3)
    assert ours.value * 3 == pytest.approx(theirs.mean_value, rel=1e-12)
    assert ours.lower * 3 == pytest.approx(theirs.lower_bound, rel=1e-12)
    assert ours.upper * 3 == pytest.approx(theirs.upper_bound, rel=1e-12)
    assert ours.is_consistent == theirs.is_consistent


def test_average_nis_of_one_run(sim):
    test = consistency.average_nis(sim.nis, MEASURED)
    assert near_five_percent(rejected(test.is_consistent), RUNS)
    mixed = np.random.default_rng(1)
    df = np.array([2, 4, 2, 3] * 10)
    test = consistency.average_nis(mixed.chisquare(df, (2000, 40)), np.tile(df, (2000, 1)))
    assert test.dof[0] == df.sum()
    assert near_five_percent(rejected(test.is_consistent), 2000)


def test_nees_over_time_knows_its_correlation(sim):
    naive = consistency.anees(sim.nees, STATES, axis=1)
    assert rejected(naive.is_consistent) > 0.10
    matrices = {"transitions": sim.A, "covariances": sim.P}
    model = consistency.nees_over_time(sim.nees, STATES, **matrices)
    assert near_five_percent(rejected(model.is_consistent), RUNS)
    own = consistency.nees_over_time(sim.nees, STATES)
    assert rejected(own.is_consistent) < 0.09
    one = consistency.nees_over_time(sim.nees[5], STATES)
    assert one.upper == pytest.approx(own.upper[5])


def test_correlation_time_predicts_the_variance_of_a_sum(sim):
    tau = consistency.nees_correlation_time(sim.A, sim.P)
    predicted = 2 * STATES * tau.sum()
    assert sim.nees.sum(1).var() == pytest.approx(predicted, rel=0.12)
    assert tau.mean() > 1.5


def test_correlation_time_against_the_double_sum(sim):
    a, p = sim.A[:8], sim.P[:8]
    roots = np.linalg.cholesky(p)
    expected = np.ones(8)
    for k in range(8):
        chain = np.eye(4)
        for i in range(k - 1, -1, -1):
            chain = chain @ a[i + 1]
            c = np.linalg.inv(roots[k]) @ chain @ roots[i]
            expected[[k, i]] += (c**2).sum() / 4
    np.testing.assert_allclose(consistency.nees_correlation_time(a, p), expected, rtol=1e-9)


def geyer(x):
    """The definition: pairs of autocorrelations, while positive and no larger than before."""
    x = np.asarray(x) - np.mean(x)
    rho = [float(x[: len(x) - lag] @ x[lag:]) / float(x @ x) for lag in range(len(x))]
    total, smallest = 0.0, np.inf
    for even, odd in zip(rho[::2], rho[1::2], strict=False):
        if even + odd <= 0:
            break
        smallest = min(smallest, even + odd)
        total += smallest
    return max(1.0, 2 * total - 1)


def test_correlation_times_of_many_are_the_definition_of_each():
    from trackmetrics.consistency.correlation_time import correlation_times

    rng = np.random.default_rng(4)
    sequences = [np.ones(3), np.ones(9)]
    for n in (4, 5, 16, 17, 31, 33, 64, 200, 201):
        noise = rng.normal(size=n)
        sequences += [noise, np.cumsum(noise), noise + np.roll(noise, 1)]
        sequences.append(np.sin(np.arange(n) / 20.0))
    expected = [1.0, 1.0, *map(geyer, sequences[2:])]
    np.testing.assert_allclose(correlation_times(sequences), expected, rtol=1e-9)
    for sequence, time in zip(sequences, expected, strict=True):
        assert consistency.correlation_time(sequence) == pytest.approx(time)


def test_correlation_time_of_an_autoregression():
    rng = np.random.default_rng(4)
    x = np.zeros(20_000)
    for k in range(1, x.size):
        x[k] = 0.8 * x[k - 1] + rng.standard_normal()
    assert consistency.correlation_time(x) == pytest.approx(9.0, rel=0.15)
    assert consistency.correlation_time(rng.standard_normal(20_000)) < 1.15
    assert consistency.correlation_time([1.0, 1.0, 1.0, 1.0, 1.0]) == 1.0


def test_decorrelated_nees_is_exact_in_one_run(sim):
    result = consistency.decorrelated_nees(sim.errors, sim.P, sim.A)
    assert result.values.shape == (RUNS, STEPS)
    df = np.broadcast_to(result.dof.astype(float), result.values.shape)
    test = consistency.average_nis(result.values, df)
    assert near_five_percent(rejected(test.is_consistent), RUNS)
    lag1 = [np.corrcoef(run[:-1], run[1:])[0, 1] for run in result.values[:300]]
    assert abs(np.mean(lag1)) < 0.04
    np.testing.assert_allclose(result.values[:, 0], sim.nees[:, 0], rtol=1e-6)


def test_normalized_mean_error(sim):
    groups = sim.errors.reshape(40, 50, STEPS, STATES)[:, :, 30]
    tests = [consistency.normalized_mean_error(e, sim.P[30]) for e in groups]
    assert near_five_percent(rejected([test.is_consistent for test in tests]), 160)
    shifted = groups[0] + np.sqrt(np.diag(sim.P[30]))
    assert not consistency.normalized_mean_error(shifted, sim.P[30]).is_consistent.any()


def test_whiteness_along_time(sim):
    s = np.broadcast_to(sim.S, (RUNS, STEPS, 2, 2))
    test = consistency.whiteness(sim.innovations, s, lags=5)
    assert near_five_percent(rejected(test.is_white), RUNS)
    assert near_five_percent(rejected(np.abs(test.correlation) <= test.bound), RUNS * 5)
    assert test.bound[0, 0] == pytest.approx(1.96 / np.sqrt(2 * 59), rel=1e-4)
    one = consistency.whiteness(sim.innovations[3], sim.S, lags=5)
    np.testing.assert_allclose(one.correlation, test.correlation[3], rtol=1e-9)
    mixed = consistency.whiteness([*sim.innovations[3], [1.0]], [*sim.S, [[1.0]]], lags=5)
    assert mixed.bound[0] < one.bound[0]
    coloured = np.repeat(sim.innovations[0][::2], 2, axis=0)
    assert not consistency.whiteness(coloured, sim.S).is_white


def test_whiteness_does_not_depend_on_units():
    rng = np.random.default_rng(2)
    v, s = rng.standard_normal((40, 2)), np.eye(2)
    plain = consistency.whiteness(v, [s] * 40)
    units = np.array([1e6, 1e-3])
    other = consistency.whiteness(v * units, [np.diag(units**2)] * 40)
    np.testing.assert_allclose(other.correlation, plain.correlation, rtol=1e-9)


def test_whiteness_of_mixed_measurements():
    rng = np.random.default_rng(3)
    passed = []
    for _ in range(200):
        sizes = rng.choice([1, 2, 4], 50)
        v = [rng.standard_normal(m) for m in sizes]
        passed.append(consistency.whiteness(v, [np.eye(m) for m in sizes], lags=4).is_white)
    assert near_five_percent(rejected(passed), 200)


def test_whiteness_across_runs(sim):
    groups = sim.innovations.reshape(40, 50, STEPS, MEASURED)
    s = np.broadcast_to(sim.S, (50, STEPS, 2, 2)).copy()
    tests = [consistency.whiteness_across_runs(v, s) for v in groups]
    inside = np.array([np.abs(test.correlation) <= test.bound for test in tests])
    assert near_five_percent(rejected(inside), inside.size)
    assert near_five_percent(rejected([test.is_white for test in tests]), 40)


def test_inclination_and_noncredibility(sim):
    groups = [sim.errors[i * 50 : (i + 1) * 50, k] for i in range(40) for k in (10, 30, 50)]
    p = [sim.P[k] for _ in range(40) for k in (10, 30, 50)]
    tests = [consistency.inclination_index(*pair) for pair in zip(groups, p, strict=True)]
    inside = [test.lower <= test.value <= test.upper for test in tests]
    assert near_five_percent(rejected(inside), 120)
    assert tests[0].upper == pytest.approx(1.96 * 3.48772 / np.sqrt(50), rel=1e-3)
    pairs = zip(groups, p, strict=True)
    nci = [consistency.noncredibility_index(*pair).value for pair in pairs]
    assert np.mean(nci) == pytest.approx(0.68, abs=0.08)
    doubled = consistency.inclination_index(groups[0], p[0] / 2).value
    assert doubled - tests[0].value == pytest.approx(10 * math.log10(2), rel=1e-9)
    sample = consistency.inclination_index(groups[0], p[0] / 2, reference="sample").value
    same = consistency.inclination_index(groups[0], p[0], reference="sample").value
    assert sample - same == pytest.approx(10 * math.log10(2), rel=1e-9)


def test_the_expected_logarithm_of_five_states():
    """6.064 dB and 3.041 dB, of 10 log10 of a chi-square of five."""
    errors = np.zeros((9, 5))
    errors[:, 0] = 1.0
    test = consistency.inclination_index(errors, np.eye(5))
    assert test.value == pytest.approx(-6.064, abs=5e-4)
    assert test.upper == pytest.approx(1.959964 * 3.041 / 3, rel=2e-4)


@pytest.mark.parametrize("runs", [8, 15, 50])
def test_covariance_test_has_its_size(runs):
    e = np.random.default_rng(runs).standard_normal((1500, runs, 3))
    passed = [consistency.covariance_test(x, np.eye(3)).is_consistent for x in e]
    assert near_five_percent(rejected(passed), 1500)
    assert not consistency.covariance_test(e[0] * [3, 1, 1], np.eye(3)).is_consistent


def test_bias_tests_have_their_size(sim):
    rng = np.random.default_rng(5)
    e = rng.standard_normal((1500, 20, 4)) @ np.linalg.cholesky(sim.P[30]).T
    known = [consistency.bias_test(x, sim.P[30]).is_consistent for x in e]
    assert near_five_percent(rejected(known), 1500)
    unknown = [consistency.hotelling_test(x * 1e3).is_consistent for x in e]
    assert near_five_percent(rejected(unknown), 1500)
    shifted = e[0] + 2 * np.sqrt(np.diag(sim.P[30]))
    assert not consistency.bias_test(shifted, sim.P[30]).is_consistent
    assert not consistency.hotelling_test(shifted).is_consistent


def test_bias_test_of_one_covariance_is_a_quadratic_form(sim):
    e = sim.errors[:30, 20]
    mean = e.mean(0)
    expected = 30 * mean @ np.linalg.solve(sim.P[20], mean)
    assert consistency.bias_test(e, sim.P[20]).statistic == pytest.approx(expected, rel=1e-9)


def test_coverage(sim):
    values = sim.nees[:, ::20]
    test = consistency.coverage(values[:, 0], STATES)
    assert test.share == pytest.approx(0.95, abs=0.02)
    assert test.is_consistent is True
    curve = consistency.coverage_curve(values[:, 0], STATES)
    assert curve.share.shape == (99,)
    assert np.abs(curve.share - curve.probability).max() < 0.04
    share = consistency.credibility_interval(sim.errors[:, 0], sim.P[0])
    assert test.share == share


def test_clopper_pearson_holds_what_it_claims():
    """The interval of 19 in 20, and all and nothing, as tables have them."""
    values = np.r_[np.zeros(19), 100.0]
    test = consistency.coverage(values, 1)
    assert (test.lower, test.upper) == pytest.approx((0.7513, 0.9987), abs=1e-4)
    everything = consistency.coverage(np.zeros(10), 1)
    assert (everything.lower, everything.upper) == pytest.approx((0.6915, 1.0), abs=1e-4)
    nothing = consistency.coverage(np.full(10, 100.0), 1)
    assert (nothing.lower, nothing.upper) == pytest.approx((0.0, 0.3085), abs=1e-4)


@pytest.mark.parametrize("count", [5, 20, 200])
def test_pit_has_its_size(count):
    values = np.random.default_rng(count).chisquare(3, (2000, count))
    tests = [consistency.pit_test(v, 3) for v in values]
    assert near_five_percent(np.mean([test.ks_p_value < 0.05 for test in tests]), 2000)
    assert near_five_percent(np.mean([test.cvm_p_value < 0.05 for test in tests]), 2000)
    assert not consistency.pit_test(3 * values.ravel()[:200], 3).is_consistent


def test_pit_against_scipy():
    from scipy import stats

    values = np.random.default_rng(0).chisquare(2, 150)
    test = consistency.pit_test(values, 2)
    ks = stats.kstest(stats.chi2.cdf(values, 2), "uniform")
    assert test.ks_statistic == pytest.approx(ks.statistic, rel=1e-12)
    assert test.ks_p_value == pytest.approx(ks.pvalue, abs=0.01)
    cvm = stats.cramervonmises(stats.chi2.cdf(values, 2), "uniform")
    assert test.cvm_statistic == pytest.approx(cvm.statistic, rel=1e-9)
    assert test.cvm_p_value == pytest.approx(cvm.pvalue, abs=0.005)


def test_scores(sim):
    assert consistency.excess_nll(sim.nees, STATES).mean() == pytest.approx(0, abs=0.06)
    crps = consistency.gaussian_crps(sim.errors[:, 30], sim.P[30])
    expected = np.sqrt(np.diag(sim.P[30]) / np.pi)
    np.testing.assert_allclose(crps.mean(0), expected, rtol=0.06)
    # By its definition: the integral of (F(x) - [x >= e])^2.
    x = np.linspace(-30, 30, 600_001)
    distribution = np.array([0.5 * math.erfc(-v / 2 / math.sqrt(2)) for v in x[::100]])
    gap = (distribution - (x[::100] >= 1.5)) ** 2
    integral = gap.sum() * (x[100] - x[0])
    assert consistency.gaussian_crps([1.5], [[4.0]])[0] == pytest.approx(integral, rel=1e-2)


def test_fading_memory_and_moving_window(sim):
    for test in (
        consistency.fading_memory_nis(sim.nis, MEASURED, 0.9),
        consistency.moving_average_nis(sim.nis, MEASURED, 20),
    ):
        for k in (0, 20, -1):
            assert near_five_percent(rejected(test.is_consistent[:, k]), RUNS)
    long = consistency.fading_memory_nis(np.full(400, 2.0), 2, 0.9)
    assert long.dof[-1] == pytest.approx(2 * 1.9 / 0.1, rel=1e-9)
    np.testing.assert_allclose(long.value, 1.0)


def test_marginal_and_subspace(sim):
    zero = np.zeros_like(sim.errors[:, 30])
    e, p = sim.errors[:, 30], sim.P[30]
    marginal = consistency.marginal_nees(e, zero, p)
    np.testing.assert_allclose(marginal, e**2 / np.diag(p), rtol=1e-12)
    assert marginal.mean(0) == pytest.approx(np.ones(4), abs=0.12)
    one = consistency.subspace_nees(e, zero, p, [2])
    np.testing.assert_allclose(one, marginal[:, 2], rtol=1e-12)
    np.testing.assert_allclose(consistency.subspace_nees(e, zero, p, range(4)), sim.of(30))
    with pytest.raises(ValueError, match=r"indices\[1\] is 4, the state has 4 components"):
        consistency.subspace_nees(e, zero, p, [0, 4])
    with pytest.raises(ValueError, match="indices names a state twice"):
        consistency.subspace_nees(e, zero, p, [0, -4])


def test_every_update_of_a_linear_filter_adds_up(sim):
    for k in (0, 7, 59):
        before = trackmetrics.nis(sim.predicted[:, k], sim.P_pred[k])
        arguments = (sim.nis[:, k], before, sim.nees[:, k], sim.noise[:, k], sim.R[k])
        assert consistency.update_identity(*arguments).holds.all()
        wrong = consistency.update_identity(sim.nis[:, k] * 1.01, *arguments[1:])
        assert wrong.holds.mean() < 0.01


def test_covariance_scale():
    scales = consistency.covariance_scale(
        0.5 * np.random.default_rng(6).chisquare(4, (1000, 30)), 4, axis=1
    )
    covered = (scales.lower <= 0.5) & (scales.upper >= 0.5)
    assert near_five_percent(rejected(covered), 1000)
    one = consistency.covariance_scale([11.2] * 5, 4)
    assert one.scale == pytest.approx(2.8)
    assert str(one).startswith("multiply P by 2.8 [")
    wide = consistency.covariance_scale([11.2] * 5, 4, correlation_time=2.0)
    assert wide.lower < one.lower
    assert wide.upper > one.upper
    assert wide.scale == pytest.approx(2.8)


REFUSED = [
    (lambda: consistency.anees([], 2), "nees_values is empty"),
    (lambda: consistency.anees([1.0, -1.0], 2), "nees_values[1] must be finite and at least 0"),
    (lambda: consistency.anees([1.0], 0), "dof must be positive and finite, got 0.0"),
    (lambda: consistency.average_nis([1.0, 2.0], [1, 2, 3]), "dof has shape (3,), expected (2,)"),
    (lambda: consistency.average_nis([1.0, 2.0], [1, 0]), "dof[1] must be positive and finite"),
    (lambda: consistency.anees([1.0], 2, confidence=95), "confidence must be between 0 and 1"),
    (lambda: consistency.moving_average_nis([1.0], 2, 2), "window must be between 1 and 1, got 2"),
    (lambda: consistency.fading_memory_nis([1.0], 2, 1.0), "factor must be between 0 and 1"),
    (lambda: consistency.bias_test([[np.nan]], [[1.0]]), "errors[0][0] is not finite: nan"),
    (lambda: consistency.bias_test([[1.0]], [[-1.0]]), "covariances is not positive definite"),
    (lambda: consistency.bias_test([1.0], [[1.0]]), "errors has shape (1,), expected (N, ..., d)"),
    (lambda: consistency.covariance_test(np.ones((2, 2)), np.eye(2)), "errors has 2 runs, at leas"),
    (lambda: consistency.whiteness([[1.0]] * 3, [[[1.0]]] * 2), "innovation_covariances has shap"),
    (lambda: consistency.whiteness([[1.0]] * 2, [[[1.0]]] * 2), "innovations has 2 updates, at l"),
    (
        lambda: consistency.whiteness([[1.0]] * 9, [[[1.0]]] * 8 + [[[0.0]]]),
        "innovation_covariances[8] is not positive definite (leading minor 1)",
    ),
    (
        lambda: consistency.whiteness([[1.0, 2.0]] + [[1.0]] * 8, [np.eye(2)] + [[[0.0]]] * 8),
        "innovation_covariances[1] is not positive definite (leading minor 1)",
    ),
    (lambda: consistency.coverage([1.0], 1, 1.0), "probability must be between 0 and 1"),
    (lambda: consistency.nees_over_time([1.0], 1, transitions=[[[1]]]), "transitions and covaria"),
    (lambda: consistency.inclination_index([[1.0]], [[1.0]], reference="x"), "reference must be"),
    (lambda: consistency.covariance_scale([1.0], 1, correlation_time=0.5), "correlation_time must"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_what_is_refused(call, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the text is compared below
        call()
    assert str(caught.value).startswith(message)


@pytest.mark.data
def test_real_updates(data):
    """NIS and NEES of 946 real updates: means and coverage as the peers have them."""
    sets = json.loads((data / "mot" / "values" / "nees_nis_real.json").read_text())
    for values in sets.values():
        nis, expected = np.array(values["nis_exact"]), values["consistency_nis_99"]
        test = consistency.average_nis(nis, 2, confidence=0.99)
        assert test.value * 2 == pytest.approx(expected["mean_value"], rel=1e-12)
        assert test.lower * 2 == pytest.approx(expected["lower_bound"], rel=1e-12)
        assert test.upper * 2 == pytest.approx(expected["upper_bound"], rel=1e-12)
        nees = np.array(values["nees_position_exact"])
        shares = consistency.coverage(nees, 2, [0.5, 0.95]).share
        assert shares.tolist() == [values["credibility_50"], values["credibility_95"]]
