"""Ten thousand runs of a hundred steps: the statistics against batched NumPy and a pytcl loop; the
cost of driving a sweep; threads, processes and Dask."""

import time

import numpy as np

import trackmetrics
from harness import Bench
from trackmetrics.monte_carlo import ConsistencyAccumulator, sweep

RUNS, STEPS, STATES = 10_000, 100, 4
THRESHOLDS = (3.356694, 7.779440, 9.487729, 13.276704)  # chi-square of 4: 50, 90, 95, 99 %
RUN_SECONDS = 0.005
FRAMES = 50_000


def batch(runs):
    """Errors as large as their covariances say."""
    rng = np.random.default_rng(0)
    root = 0.5 * rng.normal(size=(runs, STEPS, STATES, STATES)) + 2 * np.eye(STATES)
    errors = np.einsum("rtij,rtj->rti", root, rng.normal(size=(runs, STEPS, STATES)))
    truth = rng.normal(size=errors.shape)
    return {
        "truth": truth,
        "estimates": truth - errors,
        "covariances": root @ root.swapaxes(-1, -2),
    }


def accumulated(arrays):
    accumulator = ConsistencyAccumulator()
    accumulator.update(arrays, 0)
    return accumulator.result()


def by_functions(arrays):
    """ANEES, RMSE and coverage, by the functions for arrays of any shape."""
    q = trackmetrics.nees(*arrays.values())
    coverage = [(q <= threshold).mean(0) for threshold in THRESHOLDS]
    return q.mean(0) / STATES, trackmetrics.rmse(arrays["truth"], arrays["estimates"], 0), coverage


def in_numpy(arrays):
    """ANEES, RMSE and coverage, as one writes them with NumPy."""
    e = arrays["truth"] - arrays["estimates"]
    q = np.einsum("rti,rti->rt", e, np.linalg.solve(arrays["covariances"], e[..., None])[..., 0])
    coverage = [(q <= threshold).mean(0) for threshold in THRESHOLDS]
    return q.mean(0) / STATES, np.sqrt((e**2).mean(0)), coverage


def all_in_numpy(arrays):
    """Everything that the accumulator keeps, with NumPy."""
    anees, rmse, coverage = in_numpy(arrays)
    e = arrays["truth"] - arrays["estimates"]
    q = np.einsum("rti,rti->rt", e, np.linalg.solve(arrays["covariances"], e[..., None])[..., 0])
    decibels = 10 * np.log10(q)
    z = e / np.sqrt(np.einsum("rtjj->rtj", arrays["covariances"]))
    bins = np.geomspace(1e-6, 1e8, 386)
    histogram = [np.histogram(q[:, t], bins)[0] for t in range(STEPS)]
    kept = decibels.mean(0), np.abs(decibels - 5.0).mean(0), (q**2).mean(0)
    return anees, rmse, coverage, kept, e.mean(0), z.mean(0), histogram


def in_pytcl(arrays, runs):
    """A loop over runs with pytcl."""
    from pytcl.performance_evaluation import nees_sequence, rmse

    nees = [nees_sequence(*(arrays[name][r] for name in arrays)) for r in range(runs)]
    errors = [rmse(arrays["truth"][r], arrays["estimates"][r], axis=0) for r in range(runs)]
    return np.mean(nees, 0) / STATES, errors


def simulate(rng):
    """A run that takes five milliseconds of a processor."""
    end = time.thread_time() + RUN_SECONDS
    errors = rng.normal(size=(STEPS, STATES))
    while time.thread_time() < end:
        pass
    return {"truth": np.zeros_like(errors), "estimates": errors, "covariances": _UNIT}


_UNIT = np.broadcast_to(np.eye(STATES), (STEPS, STATES, STATES))


def statistics(bench):
    arrays = batch(RUNS)
    theirs, everything = in_numpy(arrays), accumulated(arrays)
    kept = everything.anees, everything.rmse, list(everything.coverage.values())
    for ours in (by_functions(arrays), kept):
        for found, expected in zip(ours, theirs, strict=True):
            assert np.allclose(found, expected, rtol=1e-9)
    what = "NEES, RMSE, coverage: 10 000 runs x 100 steps x 4"
    bench.compare(
        what,
        lambda: by_functions(arrays),
        {"NumPy": lambda: in_numpy(arrays)},
        target=10.0,
        seconds=8.0,
        rounds=9,
    )
    bench.report(what, against_loop(by_functions, arrays), "x pytcl, from 20 runs", 400.0)
    what = "all that an accumulator keeps of them"
    bench.compare(
        what,
        lambda: accumulated(arrays),
        {"NumPy": lambda: all_in_numpy(arrays), "NumPy, the three": lambda: in_numpy(arrays)},
        seconds=12.0,
        rounds=9,
    )
    bench.report(what, against_loop(accumulated, arrays), "x pytcl, NEES and RMSE, from 20 runs")


def against_loop(call, arrays):
    """How many times sooner than pytcl, whose time is that of a few runs, times as many."""
    few = {name: array[:20].copy() for name, array in arrays.items()}
    assert np.allclose(in_pytcl(few, 20)[0], accumulated(few).anees, rtol=1e-9)
    loop, ours = [], []
    for _ in range(5):
        start = time.perf_counter()
        in_pytcl(few, 20)
        loop.append(RUNS / 20 * (time.perf_counter() - start))
        start = time.perf_counter()
        call(arrays)
        ours.append(time.perf_counter() - start)
    return float(np.median(loop) / np.median(ours))


def threads(bench):
    arrays = batch(RUNS)
    ratio = two_threads(lambda: accumulated(arrays))
    bench.report("two threads, accumulator", ratio, "x one thread", 1.4)
    rng = np.random.default_rng(0)
    truths = rng.uniform(0.0, 100.0, (10 * FRAMES, 2))
    estimates, starts = truths + rng.normal(size=truths.shape), np.arange(0, 10 * FRAMES + 1, 10)
    sequences = (truths, starts), (estimates, starts)
    ratio = two_threads(lambda: trackmetrics.ospa_over_time(*sequences, c=10.0, p=2.0))
    bench.report("two threads, OSPA of 50 000 frames x 10", ratio, "x one thread", 1.6)


def two_threads(call):
    """How many times sooner with two threads than with one, in turn."""
    before = trackmetrics.threads()
    times = {1: [], 2: []}
    for _ in range(15):
        for count, found in times.items():
            trackmetrics.set_threads(count)
            start = time.perf_counter()
            call()
            found.append(time.perf_counter() - start)
    trackmetrics.set_threads(before)
    return float(np.median(times[1]) / np.median(times[2]))


def driving(bench, runs=200):
    """Against a bare loop, in processor time, so that other work does not count."""

    def loop():
        for run in range(runs):
            simulate(np.random.default_rng(np.random.SeedSequence(1, spawn_key=(run,))))

    def swept():
        sweep(simulate, runs, seed=1, progress=False)

    times = {loop: [], swept: []}
    for _ in range(5):
        for call, found in times.items():
            start = time.process_time()
            call()
            found.append(time.process_time() - start)
    cost = np.median(times[swept]) / np.median(times[loop]) - 1
    bench.report("driver's cost, runs of 5 ms", 100 * float(cost), "% (at most 5)")


def executors(bench, runs=600):
    from distributed import Client, LocalCluster

    times = {"processes": [], "dask": []}
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
        Client(cluster) as client,
    ):
        for _ in range(3):
            for name, executor in (("processes", "processes"), ("dask", client)):
                start = time.perf_counter()
                sweep(simulate, runs, seed=1, progress=False, executor=executor, workers=2)
                times[name].append(time.perf_counter() - start)
    ratio = float(np.median(times["dask"]) / np.median(times["processes"]))
    bench.report("Dask on one machine", ratio, "x the time of processes")


if __name__ == "__main__":
    bench = Bench("monte_carlo")
    statistics(bench)
    threads(bench)
    driving(bench)
    executors(bench)
    bench.finish()
