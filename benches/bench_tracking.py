"""Scores over identities, against pytcl.

python benches/bench_tracking.py [--save]
"""

import numpy as np
from pytcl.performance_evaluation import track_metrics as pytcl

import trackmetrics
from harness import Bench

LABELS = ("track_purity", "track_fragmentation", "identity_switches")


def all_labels(module, true, estimated):
    return [getattr(module, name)(true, estimated) for name in LABELS]


def bench_labels(bench: Bench) -> None:
    rng = np.random.default_rng(1)
    for k in (10, 100, 1000):
        true = rng.integers(0, k, 1_000_000)
        estimated = np.where(rng.random(true.size) < 0.9, true, rng.integers(0, k, true.size))
        assert all_labels(trackmetrics, true, estimated) == all_labels(pytcl, true, estimated)
        bench.compare(
            f"three label metrics, 1e6 labels, ids 0..{k - 1}",
            lambda t=true, e=estimated: all_labels(trackmetrics, t, e),
            {"pytcl": lambda t=true, e=estimated: all_labels(pytcl, t, e)},
            target=100 if k == 1000 else None,
            seconds=10,
            rounds=3,
        )
    ids = rng.integers(-(2**63), 2**63 - 1, 1000)
    wide, also = ids[true], ids[estimated]
    assert all_labels(trackmetrics, wide, also) == all_labels(trackmetrics, true, estimated)
    bench.compare(
        "three label metrics, 1e6 labels, 1000 arbitrary int64 ids",
        lambda: all_labels(trackmetrics, wide, also),
        {"pytcl": lambda: all_labels(pytcl, wide, also)},
        seconds=10,
        rounds=3,
    )


def scene(frames, n, rng):
    """Targets in a box of 1000, each found within some metres, and in another order each time."""
    truth = [list(rng.uniform(0, 1000, (n, 2))) for _ in range(frames)]
    found = [[x[i] + rng.normal(0, 5, 2) for i in rng.permutation(n)] for x in truth]
    return truth, found


def bench_mot_metrics(bench: Bench) -> None:
    rng = np.random.default_rng(2)
    for n in (5, 10, 20, 50):
        truth, found = scene(1000, n, rng)
        unrelated, _ = scene(1000, n, rng)
        assert_close(truth, found)
        assert_close(truth, unrelated)
        for what, other in {"tracked": found, "unrelated": unrelated}.items():
            bench.compare(
                f"mot_metrics, lists, 1000 frames x {n}, {what}",
                lambda x=truth, y=other: trackmetrics.mot_metrics(x, y),
                {"pytcl": lambda x=truth, y=other: pytcl.mot_metrics(x, y)},
                target=200 if n == 10 and what == "tracked" else None,
                seconds=4,
                rounds=5,
            )
    packed = np.array(truth), np.array(found)
    bench.compare(
        "mot_metrics, (T, n, d) arrays, 1000 frames x 50",
        lambda: trackmetrics.mot_metrics(*packed),
        {"mot_metrics, lists": lambda: trackmetrics.mot_metrics(truth, found)},
    )


def assert_close(truth, found):
    ours, theirs = trackmetrics.mot_metrics(truth, found), pytcl.mot_metrics(truth, found)
    assert ours[2:] == theirs[2:]
    assert np.allclose(ours, theirs, rtol=1e-12)


if __name__ == "__main__":
    bench = Bench("tracking")
    bench_mot_metrics(bench)
    bench_labels(bench)
    bench.finish()
