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


if __name__ == "__main__":
    bench = Bench("tracking")
    bench_labels(bench)
    bench.finish()
