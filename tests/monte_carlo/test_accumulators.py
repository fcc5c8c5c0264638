"""Accumulators: any cut of the runs, in any order, gives the same bits; and they are right."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import trackmetrics
from trackmetrics import _native, _numpy
from trackmetrics._distributions import clopper_pearson
from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog
from trackmetrics.monte_carlo import (
    ConsistencyAccumulator,
    LabelAccumulator,
    PointSetAccumulator,
    ScoreAccumulator,
    sweep,
)
from trackmetrics.monte_carlo.accumulators.histogram import edges
from trackmetrics.monte_carlo.consistency_summary import _expected_decibels
from trackmetrics.monte_carlo.run_tree import RunTree, dyadic_blocks
from trackmetrics.monte_carlo.serialization import MAGIC


def filter_batch(runs, steps=5, d=3, seed=0, scale=1.0, missing=0.0):
    """Errors that are as large as their covariances say, and innovations of one dimension less."""
    rng = np.random.default_rng(seed)
    root = 0.5 * rng.normal(size=(runs, steps, d, d)) + 2 * np.eye(d)
    truth = rng.normal(size=(runs, steps, d)) * 100
    errors = np.einsum("rtij,rtj->rti", root, rng.normal(size=(runs, steps, d)))
    covariances = root @ root.swapaxes(-1, -2) / scale
    innovations = errors[..., 1:].copy()
    innovations[rng.random((runs, steps)) < missing] = np.nan
    return {
        "truth": truth,
        "estimates": truth - errors,
        "covariances": covariances,
        "innovations": innovations,
        "innovation_covariances": np.ascontiguousarray(covariances[..., 1:, 1:]),
    }


def part(batch, first, stop):
    return {name: array[first:stop] for name, array in batch.items()}


def accumulate(batch, cuts, order=None, first=0):
    """One accumulator of the batch, cut at ``cuts``, the pieces merged in this order."""
    runs = len(batch["truth"])
    bounds = sorted({0, runs, *cuts})
    pieces = []
    for a, b in pairwise(bounds):
        piece = ConsistencyAccumulator()
        piece.update(part(batch, a, b), first + a)
        pieces.append(piece)
    order = range(len(pieces)) if order is None else order
    whole = ConsistencyAccumulator()
    for i in order:
        whole.merge(pieces[i])
    return whole


def node(values, first, start, level):
    """The definition: a node is its left half plus its right half."""
    if level == 0:
        return values[start - first]
    half = 1 << (level - 1)
    return node(values, first, start, level - 1) + node(values, first, start + half, level - 1)


@given(st.integers(0, 40), st.integers(0, 60), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_the_nodes_of_a_batch_are_the_definition(first, runs, columns, seed):
    values = np.random.default_rng(seed).normal(size=(runs, columns)) * 10.0 ** np.arange(columns)
    expected = [node(values, first, *n) for n in dyadic_blocks(first, first + runs)]
    for kernels in (_native, _numpy):
        found = kernels.run_sums(values, first)
        assert found.shape == (len(expected), columns)
        assert np.array_equal(found, np.reshape(expected, found.shape))


@given(st.integers(0, 10**6), st.integers(0, 10**6))
def test_canonical_nodes_are_few_and_cover_the_interval(first, runs):
    nodes = list(dyadic_blocks(first, first + runs))
    assert len(nodes) <= 2 * max(1, math.ceil(math.log2(runs + 1)))
    at = first
    for start, level in nodes:
        assert start == at
        assert start % (1 << level) == 0
        at += 1 << level
    assert at == first + runs


BATCH = filter_batch(60, missing=0.2)


@given(st.data())
def test_any_cut_in_any_order_has_the_same_bits(data):
    cuts = data.draw(st.sets(st.integers(1, 59), max_size=8))
    order = data.draw(st.permutations(range(len(cuts) + 1)))
    first = data.draw(st.sampled_from([0, 1, 5, 64, 10**9]))
    whole = accumulate(BATCH, [], first=first)
    cut = accumulate(BATCH, cuts, order, first)
    assert cut.to_bytes() == whole.to_bytes()
    again = ConsistencyAccumulator.from_bytes(cut.to_bytes())
    assert again.to_bytes() == whole.to_bytes()


@given(st.sets(st.integers(0, 59), max_size=10), st.permutations(range(60)))
@settings(max_examples=15)
def test_runs_that_gave_nothing_can_come_in_any_order_too(lost, order):
    def take(order):
        accumulator = ConsistencyAccumulator()
        for run in order:
            if run in lost:
                accumulator.add_empty_runs(run)
            else:
                accumulator.update(part(BATCH, run, run + 1), run)
        return accumulator

    shuffled = take(order)
    assert shuffled.to_bytes() == take(range(60)).to_bytes()
    assert shuffled.runs == 60 - len(lost)
    assert shuffled.intervals == [(0, 60)]
    kept = [run for run in range(60) if run not in lost]
    expected = q_of(BATCH)[kept].mean(0) / 3
    assert shuffled.result().anees == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_the_number_of_threads_does_not_change_a_bit(threads):
    before = trackmetrics.threads()
    batch = filter_batch(600, steps=40, d=2)
    whole = accumulate(batch, [])
    try:
        trackmetrics.set_threads(threads)
        assert accumulate(batch, [123]).to_bytes() == whole.to_bytes()
    finally:
        trackmetrics.set_threads(before)


def q_of(batch):
    e = batch["truth"] - batch["estimates"]
    return np.einsum("rti,rtij,rtj->rt", e, np.linalg.inv(batch["covariances"]), e)


def test_every_statistic_is_its_definition():
    batch = filter_batch(300)
    e, q = batch["truth"] - batch["estimates"], q_of(batch)
    result = accumulate(batch, [7]).result()
    s = result.states
    assert result.anees == pytest.approx(q.mean(0) / 3, rel=1e-9)
    assert result.rmse == pytest.approx(np.sqrt((e**2).mean(0)), rel=1e-9)
    assert s.bias == pytest.approx(-e.mean(0), rel=1e-9)  # estimate minus truth
    z = e / np.sqrt(np.einsum("rtjj->rtj", batch["covariances"]))
    assert s.normalized_mean_error == pytest.approx(-z.mean(0), rel=1e-9)
    assert s.deviation == pytest.approx(q.std(0, ddof=1) / np.sqrt(6), rel=1e-9)
    for level in (0.5, 0.9, 0.95, 0.99):
        share = (q <= stats.chi2.ppf(level, 3)).mean(0)
        assert np.array_equal(s.coverage[level], share)
    centre = 10 / np.log(10) * (np.log(2) + float(stats.loggamma.mean(1.5)))
    decibels = 10 * np.log10(q)
    assert s.inclination == pytest.approx((decibels - centre).mean(0), abs=1e-9)
    assert s.noncredibility == pytest.approx(np.abs(decibels - centre).mean(0), rel=1e-9)
    low, high = stats.chi2.ppf([0.025, 0.975], 900) / 900
    assert result.anees_interval == pytest.approx([low, high], rel=1e-9)
    median = s.quantiles([0.5])[0]
    assert median == pytest.approx(np.median(q, axis=0), rel=0.05)


def test_innovations_that_were_not_measured_do_not_count():
    batch = filter_batch(200, missing=0.3)
    result = accumulate(batch, [50]).result()
    v, p = batch["innovations"], batch["innovation_covariances"]
    q = np.einsum("rti,rtij,rtj->rt", v, np.linalg.inv(p), v)
    assert np.array_equal(result.innovations.runs, (~np.isnan(q)).sum(0))
    assert result.anis == pytest.approx(np.nanmean(q, 0) / 2, rel=1e-9)
    assert result.innovations.interval.shape == (5, 2)
    assert result.innovations.rmse == pytest.approx(np.sqrt(np.nanmean(v**2, 0)), rel=1e-9)


@given(
    st.integers(1, 12),
    st.integers(1, 4),
    st.integers(0, 9),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1e-12, 1.0, 1e12]),
    st.booleans(),
)
def test_kernel_and_reference_agree(d, steps, runs, seed, scale, innovations):
    rng = np.random.default_rng(seed)
    truth, estimates = rng.normal(size=(2, runs, steps, d)) * scale
    root = rng.normal(size=(runs, steps, d, d)) + 3 * np.sqrt(d) * np.eye(d)
    covariances = root @ root.swapaxes(-1, -2) * scale**2
    if innovations:
        estimates = None
        truth[rng.random((runs, steps)) < 0.3] = np.nan
    periods = np.where(rng.random(d) < 0.3, scale, 0.0)
    arguments = (truth, estimates, covariances, periods, 3, 1.0, np.array([1.0, 5.0]))
    native = _native.consistency_sums(*arguments)
    reference = _numpy.consistency_sums(*arguments)
    for ours, theirs in zip(native, reference, strict=True):
        assert ours.shape == theirs.shape
        assert ours.dtype == theirs.dtype
    for ours, theirs in zip(native[:2], reference[:2], strict=True):
        assert np.allclose(ours, theirs, rtol=1e-9, atol=1e-9 * max(scale**2, 1.0))
    assert np.array_equal(native[2][0], reference[2][0])


@pytest.mark.parametrize("steps", [1, 7, 13])
@pytest.mark.parametrize("d", [1, 2, 3, 4, 6, 9, 10])
def test_wider_vectors_do_not_change_a_bit(d, steps):
    rng = np.random.default_rng(d)
    truth, estimates = rng.normal(size=(2, 21, steps, d))
    root = rng.normal(size=(21, steps, d, d)) + 3 * np.eye(d)
    covariances = root @ root.swapaxes(-1, -2)
    truth[3] = -0.0
    estimates[3] = 0.0
    found = []
    try:
        for width in ("avx2", "widest"):
            _native.set_simd(width)
            sums = _native.consistency_sums(
                truth, estimates, covariances, np.zeros(d), 3, 1.0, np.array([1.0, 5.0])
            )
            found.append([array.tobytes() for array in sums])
    finally:
        _native.set_simd("widest")
    assert found[0] == found[1]


@pytest.mark.parametrize("kernels", [_native, _numpy])
def test_wrong_batches_are_named(kernels):
    batch = filter_batch(6, steps=2, d=2)
    periods, limits = np.zeros(2), np.array([1.0])

    def call(truth, estimates, covariances):
        return kernels.consistency_sums(truth, estimates, covariances, periods, 0, 1.0, limits)

    arrays = {name: batch[name].copy() for name in ("truth", "estimates", "covariances")}
    arrays["covariances"][4, 1] = -np.eye(2)
    with pytest.raises(np.linalg.LinAlgError, match=r"^covariances\[4\]\[1\] is not positive def"):
        call(*arrays.values())
    arrays["estimates"][3, 0, 1] = np.nan
    with pytest.raises(ValueError, match=r"^estimates\[3\]\[0\]\[1\] is not finite: nan$"):
        call(*arrays.values())
    innovations = batch["truth"].copy()
    innovations[2, 1, 0] = np.inf
    innovations[1, 0, 0] = np.nan
    with pytest.raises(ValueError, match=r"^innovations\[2\]\[1\]\[0\] is not finite: inf$"):
        call(innovations, None, batch["covariances"])
    with pytest.raises(ValueError, match=r"^covariances has 44 numbers, truth has 48$"):
        call(batch["truth"], batch["estimates"], np.zeros((11, 1, 2, 2)))
    none = np.zeros((0, 0, 2))
    with pytest.raises(ValueError, match="truth must be of at least one step and one dimension"):
        call(none, none, np.zeros((0, 0, 2, 2)))


def test_angles_are_wrapped():
    batch = {
        "truth": np.array([[[1.0, 359.0]], [[0.0, 10.0]]]),
        "estimates": np.array([[[0.0, 1.0]], [[0.0, 190.0]]]),
        "covariances": np.tile(np.eye(2), (2, 1, 1, 1)),
    }
    accumulator = ConsistencyAccumulator(angles={1: 360.0})
    accumulator.update(batch, 0)
    result = accumulator.result()
    assert result.anees[0] * 2 == pytest.approx((5 + 180**2) / 2)
    assert result.states.bias[0].tolist() == [-0.5, (2 - 180) / 2]


def test_bias_is_estimate_minus_truth_in_a_sweep_and_in_a_diagnosis():
    rng = np.random.default_rng(3)
    truth = np.cumsum(rng.normal(size=(400, 2)), axis=0)
    estimates = truth + 1.0 + rng.normal(size=(400, 2))
    covariances = np.tile(np.eye(2), (400, 1, 1))
    accumulator = ConsistencyAccumulator()
    batch = {"truth": truth, "estimates": estimates, "covariances": covariances}
    accumulator.update({name: array[None] for name, array in batch.items()}, 0)
    states = accumulator.result().states
    log = EstimatorLog.from_columns(
        time=np.arange(400.0), x=estimates, P=covariances, truth=truth, A=np.zeros((400, 2, 2))
    )
    (track,) = diagnose(log).values()
    assert [bias.value for bias in track.biases] == pytest.approx(states.bias.mean(0), abs=0.01)
    assert states.bias.mean(0) == pytest.approx([1.0, 1.0], abs=0.15)
    assert states.normalized_mean_error.mean(0) == pytest.approx([1.0, 1.0], abs=0.15)
    assert trackmetrics.normalized_mean_error(estimates - truth, np.eye(2)).value == pytest.approx(
        states.bias.mean(0)
    )


def test_the_bias_of_innovations_is_their_mean():
    accumulator = ConsistencyAccumulator()
    innovations = np.full((5, 3, 1), 0.5)
    covariances = np.ones((5, 3, 1, 1))
    batch = {"innovations": innovations, "innovation_covariances": covariances}
    accumulator.update(batch, 0)
    assert accumulator.result().innovations.bias.ravel().tolist() == [0.5] * 3


def test_what_cannot_be_accumulated_says_why():
    accumulator = ConsistencyAccumulator()
    accumulator.update(part(BATCH, 0, 10), 0)
    with pytest.raises(ValueError, match=r"the runs 5\.\.10 are in already"):
        accumulator.update(part(BATCH, 0, 10), 5)
    with pytest.raises(ValueError, match=r"the runs 9\.\.10 are in already"):
        accumulator.add_empty_runs(9)
    other = ConsistencyAccumulator()
    other.update(part(BATCH, 0, 3), 8)
    with pytest.raises(ValueError, match=r"the runs 8\.\.10 are in both"):
        accumulator.merge(other)
    with pytest.raises(ValueError, match=r"other shapes: states is \[2, 3\], expected \[5, 3\]"):
        accumulator.update({k: v[:, :2] for k, v in part(BATCH, 0, 3).items()}, 20)
    with pytest.raises(ValueError, match=r"other settings: levels is \[0.5\], expected"):
        accumulator.merge(ConsistencyAccumulator(probabilities=[0.5]))
    with pytest.raises(TypeError, match="cannot merge a ScoreAccumulator into a"):
        accumulator.merge(ScoreAccumulator())
    with pytest.raises(ValueError, match="first_run must be a whole number, at least 0, got -1"):
        accumulator.update(part(BATCH, 0, 10), -1)
    with pytest.raises(ValueError, match="batch has truth but not estimates and covariances"):
        accumulator.update({"truth": BATCH["truth"]}, 100)
    with pytest.raises(ValueError, match=r"covariances has shape \(60, 5, 3\), expected"):
        accumulator.update({**BATCH, "covariances": BATCH["truth"]}, 100)
    with pytest.raises(ValueError, match="neither truth"):
        accumulator.update({}, 100)
    assert accumulator.intervals == [(0, 10)]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda data: data[:-1], "damaged or cut short"),
        (lambda data: data[:40] + b"x" + data[41:], "damaged or cut short"),
        (lambda data: b"x" + data, "not an accumulator"),
        (lambda data: data[:5], "not an accumulator"),
        (lambda data: MAGIC + b"\x09" + data[len(MAGIC) + 1 :], "format 9, this version reads 2"),
        (lambda data: ScoreAccumulator().to_bytes(), "hold a ScoreAccumulator, not a Consistency"),
    ],
)
def test_damaged_bytes_are_refused(damage, message):
    data = accumulate(BATCH, []).to_bytes()
    with pytest.raises(ValueError, match=message):
        ConsistencyAccumulator.from_bytes(damage(data))


@given(st.integers(1, 9))
@settings(max_examples=9)
def test_what_a_consistent_filter_expects_in_decibels(d):
    mean, variance, distance = _expected_decibels(d)
    q = stats.chi2(d).ppf((np.arange(400_000) + 0.5) / 400_000)
    b = 10 * np.log10(q)
    assert mean == pytest.approx(b.mean(), abs=2e-3)
    assert variance == pytest.approx(b.var(), rel=5e-3)
    assert distance == pytest.approx(np.abs(b - mean).mean(), rel=1e-3)


def test_coverage_intervals_are_clopper_pearson():
    hits, runs = np.array([0, 3, 10, 0]), np.array([10, 10, 10, 0])
    found = np.stack(clopper_pearson(hits, runs, 0.95), -1)
    for (low, high), k, n in zip(found[:3], hits, runs, strict=False):
        exact = stats.binomtest(int(k), int(n)).proportion_ci(0.95, "exact")
        assert (low, high) == pytest.approx((exact.low, exact.high), abs=1e-12)
    assert np.isnan(found[3]).all()


@given(st.floats(1e-320, 1e300))
def test_a_number_lies_in_its_bin(x):
    bounds = edges()
    for kernels in (_native, _numpy):
        counts = kernels.histograms(np.array([[x], [np.nan]]))[0]
        (k,) = np.flatnonzero(counts)
        assert bounds[k] <= x < bounds[k + 1]
        assert counts[k] == 1


@given(st.integers(0, 5), st.integers(1, 70), st.sets(st.integers(1, 69)), st.randoms())
def test_scores_keep_blocks_however_they_come(level, runs, cuts, random):
    values = np.random.default_rng(runs).normal(size=runs)
    values[::7] = np.nan
    bounds = sorted({0, runs, *(cut for cut in cuts if cut < runs)})
    pieces = list(pairwise(bounds))
    random.shuffle(pieces)
    scores = ScoreAccumulator(level)
    for a, b in pieces:
        scores.update({"x": values[a:b]}, a)
    whole = ScoreAccumulator(level)
    whole.update({"x": values}, 0)
    assert scores.to_bytes() == whole.to_bytes()
    size = 1 << level
    complete = [k for k in range(0, runs, size) if k + size <= runs]
    complete = [k for k in complete if not np.isnan(values[k : k + size]).any()]
    starts, means = scores.blocks("x")
    assert starts.tolist() == complete
    assert means == pytest.approx([values[k : k + size].mean() for k in complete], rel=1e-12)
    if not np.isnan(values).all():
        assert scores.means()["x"] == pytest.approx(np.nanmean(values), rel=1e-9, abs=1e-12)
    fine = ScoreAccumulator(0)
    fine.update({"x": values}, 0)
    fine.merge_blocks(level)
    assert fine.to_bytes() == whole.to_bytes()


@given(st.sets(st.integers(1, 29)), st.randoms())
def test_label_counts_add_up_however_they_come(cuts, random):
    rng = np.random.default_rng(1)
    counts = {name: rng.integers(0, 50, 30) for name in ("misses", "false_positives", "switches")}
    counts["truth"] = rng.integers(50, 100, 30)
    whole = LabelAccumulator()
    whole.update(counts, 4)
    pieces = list(pairwise(sorted({0, 30, *cuts})))
    random.shuffle(pieces)
    labels = LabelAccumulator()
    for a, b in pieces:
        labels.update({name: values[a:b] for name, values in counts.items()}, 4 + a)
    assert labels.to_bytes() == whole.to_bytes()
    again = LabelAccumulator.from_bytes(labels.to_bytes()).result()
    wrong = sum(counts[name].sum() for name in ("misses", "false_positives", "switches"))
    assert again.mota == pytest.approx(1 - wrong / counts["truth"].sum())
    assert again.runs == 30


def test_wrong_counts_are_named():
    labels = LabelAccumulator()
    with pytest.raises(ValueError, match=r"misses\[1\] must be a whole number, at least 0, got -1"):
        labels.update({"misses": [3, -1]}, 0)
    with pytest.raises(ValueError, match="truth has 1 runs, misses has 2"):
        labels.update({"misses": [3, 1], "truth": [1]}, 0)
    with pytest.raises(ValueError, match="batch has no counts"):
        labels.update({}, 0)
    labels.update({"misses": [3, 1]}, 0)
    with pytest.raises(ValueError, match="other shapes: names is"):
        labels.update({"hits": [3]}, 2)
    with pytest.raises(ValueError, match="no count 'truth', there are misses"):
        _ = labels.result().ratio("misses", "truth")


def point_batch(runs, steps=4, seed=2):
    """Sets of up to three points in the plane, and of reports about them."""
    rng = np.random.default_rng(seed)
    sets = {
        name: [
            [rng.normal(size=(rng.integers(0, 4), 2)) for _ in range(steps)] for _ in range(runs)
        ]
        for name in ("truth", "estimates")
    }
    return sets


POINTS = point_batch(30)


@given(st.sets(st.integers(1, 29)), st.randoms())
@settings(max_examples=20)
def test_point_sets_have_the_same_bits_however_they_come(cuts, random):
    whole = PointSetAccumulator(c=2.0)
    whole.update(POINTS, 3)
    pieces = list(pairwise(sorted({0, 30, *cuts})))
    random.shuffle(pieces)
    points = PointSetAccumulator(c=2.0)
    for a, b in pieces:
        points.update(part(POINTS, a, b), 3 + a)
    assert points.to_bytes() == whole.to_bytes()
    assert PointSetAccumulator.from_bytes(points.to_bytes()).to_bytes() == whole.to_bytes()


@pytest.mark.parametrize("p", [1.0, 2.0])
def test_point_set_statistics_are_their_definitions(p):
    points = PointSetAccumulator(c=2.0, p=p)
    points.update(POINTS, 0)
    result = points.result()
    pairs = [list(zip(*run, strict=True)) for run in zip(*POINTS.values(), strict=True)]
    ospa = np.array([[trackmetrics.ospa(x, y, 2.0, p).ospa for x, y in run] for run in pairs])
    gospa = [[trackmetrics.gospa(x, y, 2.0, p) for x, y in run] for run in pairs]
    assert result.ospa == pytest.approx(ospa.mean(0))
    assert result.ospa_deviation == pytest.approx(ospa.std(0, ddof=1))
    for name in ("localization", "missed", "false"):
        values = np.array([[getattr(one, name) for one in run] for run in gospa])
        assert getattr(result, name) == pytest.approx(values.mean(0))
    distances = np.array([[one.distance for one in run] for run in gospa])
    assert result.gospa == pytest.approx(distances.mean(0))
    assert result.gospa_deviation == pytest.approx(distances.std(0, ddof=1))
    ranks = np.quantile(distances, 0.5, axis=0, method="inverted_cdf")
    assert result.gospa_quantiles([0.5])[0] == pytest.approx(ranks, rel=0.13, abs=1e-6)
    assert result.ospa_quantiles([0.1, 0.9]).shape == (2, 4)


def test_wrong_point_sets_are_named():
    with pytest.raises(ValueError, match="c must be positive and finite, got -1"):
        PointSetAccumulator(c=-1)
    with pytest.raises(ValueError, match=r"p must be at least 1 and finite, got 0\.5"):
        PointSetAccumulator(c=1, p=0.5)
    points = PointSetAccumulator(c=1)
    with pytest.raises(ValueError, match="estimates has 2 runs, truth has 3"):
        points.update({"truth": [[]] * 3, "estimates": [[]] * 2}, 0)
    with pytest.raises(ValueError, match=r"estimates\[1\] has 1 steps, truth\[0\] has 2"):
        points.update({"truth": [[[], []]] * 2, "estimates": [[[], []], [[]]]}, 0)
    points.update(part(POINTS, 0, 2), 0)
    with pytest.raises(ValueError, match=r"the runs 1\.\.2 are in already"):
        points.update(part(POINTS, 0, 2), 1)


def test_a_sweep_merges_the_point_sets_of_its_runs():
    def simulate(rng):
        points = PointSetAccumulator(c=2.0)
        points.update(point_batch(1, seed=rng.integers(1 << 30)), 0)
        return {"points": points}

    result = sweep(simulate, 12, seed=1, progress=False)
    assert result["points"][0].runs == 12
    assert sweep(simulate, 12, seed=1, chunk=5, progress=False).to_bytes() == result.to_bytes()


def test_nodes_stay_few():
    tree = RunTree()
    for run in range(1000):
        tree.add(run, 0, np.zeros(1))
        assert len(list(tree)) <= 10
    assert len(tree) == 1000


def test_a_mean_innovation_is_measurement_minus_prediction():
    filters = ConsistencyAccumulator()
    S = np.ones((4, 1, 1, 1))
    filters.update({"innovations": np.full((4, 1, 1), 2.0), "innovation_covariances": S}, 0)
    assert filters.result().innovations.bias.tolist() == [[2.0]]
