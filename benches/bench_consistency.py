"""NEES and NIS of 100 000 covariances, the chi-square test and the RMSE family, against peers.

``--simd avx2`` forces the narrower vectors, ``--threads 2`` allows a second thread. How near this
comes to the time of reading the same bytes is measured without Python:
``cargo bench -p trackmetrics-core --bench nees_stream``.
"""

import numpy as np
from pytcl import performance_evaluation as pytcl

import trackmetrics
from harness import Bench

COUNT = 100_000


def batched_solve(e, p):
    """What a skilled NumPy user writes."""
    return np.einsum("ni,ni->n", e, np.linalg.solve(p, e[..., None])[..., 0])


def covariances(rng, count, d):
    root = rng.standard_normal((count, d, d))
    p = root @ root.swapaxes(-1, -2) + d * np.eye(d)
    return (p + p.swapaxes(-1, -2)) / 2


def bench_forms(bench, rng):
    for d in range(1, 10):
        p = covariances(rng, COUNT, d)
        x, y = rng.standard_normal((2, COUNT, d))
        expected = batched_solve(x - y, p)
        np.testing.assert_allclose(trackmetrics.nees_sequence(x, y, p), expected, rtol=1e-9)
        bench.compare(
            f"nees_sequence, {COUNT} x {d}",
            lambda x=x, y=y, p=p: trackmetrics.nees_sequence(x, y, p),
            {"np.linalg.solve": lambda x=x, y=y, p=p: batched_solve(x - y, p)},
            target=15 if d <= 6 else 9,
        )
        np.testing.assert_allclose(trackmetrics.nis_sequence(x, p), batched_solve(x, p), rtol=1e-9)
        bench.compare(
            f"nis_sequence, {COUNT} x {d}",
            lambda x=x, p=p: trackmetrics.nis_sequence(x, p),
            {"np.linalg.solve": lambda x=x, p=p: batched_solve(x, p)},
            target=15 if d <= 6 else 9,
        )


def bench_pytcl(bench, rng):
    for d in (2, 4, 9):
        p = covariances(rng, 5000, d)
        x, y = rng.standard_normal((2, 5000, d))
        expected = pytcl.nees_sequence(x, y, p)
        np.testing.assert_allclose(trackmetrics.nees_sequence(x, y, p), expected, rtol=1e-9)
        bench.compare(
            f"nees_sequence, 5000 x {d}",
            lambda x=x, y=y, p=p: trackmetrics.nees_sequence(x, y, p),
            {"pytcl": lambda x=x, y=y, p=p: pytcl.nees_sequence(x, y, p)},
        )
    x, y, p = rng.standard_normal(4), rng.standard_normal(4), covariances(rng, 1, 4)[0]
    np.testing.assert_allclose(trackmetrics.nees(x, y, p), pytcl.nees(x, y, p), rtol=1e-9)
    bench.compare(
        "nees, one of 4",
        lambda: trackmetrics.nees(x, y, p),
        {"pytcl": lambda: pytcl.nees(x, y, p)},
    )
    values = rng.chisquare(4, 100)
    ours, theirs = trackmetrics.consistency_test(values, 4), pytcl.consistency_test(values, 4)
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    bench.compare(
        "consistency_test, N = 100",
        lambda: trackmetrics.consistency_test(values, 4),
        {"pytcl": lambda: pytcl.consistency_test(values, 4)},
        target=15,
    )


def bench_rmse(bench, rng):
    x, y = rng.standard_normal((2, COUNT, 4))
    for axis in (None, 0, 1):
        expected = pytcl.rmse(x, y, axis)
        np.testing.assert_allclose(trackmetrics.rmse(x, y, axis), expected, rtol=1e-12)
        bench.compare(
            f"rmse, {COUNT} x 4, axis={axis}",
            lambda axis=axis: trackmetrics.rmse(x, y, axis),
            {"pytcl": lambda axis=axis: pytcl.rmse(x, y, axis)},
        )


def bench_threads(bench, rng):
    """One thread against two on 100 MB and more."""
    d = 6
    p = covariances(rng, 400_000, d)
    x = rng.standard_normal((400_000, d))

    def on(threads):
        trackmetrics.set_threads(threads)
        return trackmetrics.nis_sequence(x, p)

    assert on(1).tobytes() == on(2).tobytes()
    bench.compare(
        "nis_sequence, 115 MB, two threads",
        lambda: on(2),
        {"one thread": lambda: on(1)},
        target=1.4,
    )
    trackmetrics.set_threads(bench.options.threads)


def main():
    bench = Bench("consistency")
    rng = np.random.default_rng(0)
    bench_forms(bench, rng)
    bench_pytcl(bench, rng)
    bench_rmse(bench, rng)
    bench_threads(bench, rng)
    bench.finish()


if __name__ == "__main__":
    main()
