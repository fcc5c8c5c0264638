"""How long a diagnosis takes: a fleet of tracks, against the NumPy reference; parts alone.

python benches/bench_diagnostics.py            # prints a table
python benches/bench_diagnostics.py --save     # and writes benches/results/diagnostics.json
"""

import numpy as np

import plants
from harness import Bench
from trackmetrics import _native, _numpy, use_backend
from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog


def fleet(tracks: int, updates: int) -> EstimatorLog:
    """NIS and NEES of many tracks, a tenth of which diverge late."""
    rng = np.random.default_rng(0)
    nis, nees = (rng.chisquare(dof, (tracks, updates)) for dof in (2, 4))
    for values in (nis, nees):
        values[::10, int(0.7 * updates) :] *= 6
    return EstimatorLog.from_columns(
        track=np.repeat([f"track {i}" for i in range(tracks)], updates),
        nis=nis.ravel(),
        nis_dof=2.0,
        nees=nees.ravel(),
        state_dim=4,
    )


def with_reference(log: EstimatorLog) -> None:
    """The same with the NumPy references of the kernels."""
    with use_backend("numpy"):
        diagnose(log)


def check(log: EstimatorLog) -> None:
    """A tenth late, the rest consistent but for some false alarms; the same on the reference."""
    found = diagnose(log)
    verdicts = [track.verdict for track in found.values()]
    late = [v == "late_divergence" for v in verdicts]
    assert sum(late[::10]) >= 0.95 * len(late[::10])
    assert verdicts.count("consistent") >= 0.85 * len(verdicts)
    with use_backend("numpy"):
        assert [track.verdict for track in diagnose(log).values()] == verdicts


def main() -> None:
    bench = Bench("diagnostics")
    small = fleet(20, 200)
    check(small)
    bench.compare(
        "20 tracks of 200 updates, NIS and NEES",
        lambda: diagnose(small),
        {"NumPy reference": lambda: with_reference(small)},
    )
    large = fleet(1000, 200)
    seconds = min(_time(lambda: diagnose(large)) for _ in range(3))
    bench.report("1000 tracks of 200 updates, NIS and NEES", 1e3 * seconds / 1000, "ms a track")
    full = plants.simulate(plants.two_sensors(), "late manoeuvre", 200, 50, 0)
    assert all(track.verdict == "late_divergence" for track in diagnose(full).values())
    seconds = min(_time(lambda: diagnose(full)) for _ in range(3))
    bench.report("50 tracks of 200 updates, full rows", 1e3 * seconds / 50, "ms a track")
    _parts(bench)
    bench.finish()


def _time(call):  # type: ignore[no-untyped-def]
    import time

    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def _parts(bench: Bench) -> None:
    """The kernels against their references."""
    rng = np.random.default_rng(1)
    values, dof, starts = rng.chisquare(2, 4000), np.full(4000, 2.0), np.arange(0, 4001, 200)
    draws = rng.chisquare(2, (4000, 200))
    root = rng.normal(size=(200, 6, 6))
    errors, covariances = rng.normal(size=(200, 6)), root @ root.swapaxes(1, 2) + np.eye(6)
    for name, arguments in (
        ("scale_partitions", (values, dof, starts, 2, 4)),
        ("best_split_gains", (draws, dof[:200], 2)),
        ("shapley_shares", (errors, covariances)),
    ):
        ours, reference = getattr(_native, name), getattr(_numpy, name)
        first = np.asarray(ours(*arguments)[0])
        np.testing.assert_allclose(first, np.asarray(reference(*arguments)[0]), rtol=1e-9)
        bench.compare(
            name,
            lambda f=ours, a=arguments: f(*a),
            {"NumPy reference": lambda f=reference, a=arguments: f(*a)},
        )


if __name__ == "__main__":
    main()
