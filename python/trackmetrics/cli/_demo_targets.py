"""The multi-target scene of the demo: Monte Carlo runs, scored with the documented functions."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import trackmetrics as tm
from trackmetrics.cli._demo_simulation import Floats, Scene, simulate
from trackmetrics.cli._output import Output
from trackmetrics.cli._table import Column, Table

CUTOFF = 50.0  # metres: cutoff of OSPA, and largest distance of a pair

COLUMNS = (
    Column("score", lambda s: s.name),
    Column("value", lambda s: s.value, text=lambda s: _text(s.value), right=True),
    Column(
        "milliseconds", lambda s: 1e3 * s.seconds, "ms", lambda s: f"{1e3 * s.seconds:.3f}", 2, True
    ),
    Column("meaning", lambda s: s.meaning, rank=1),
)


def run_targets(output: Output, runs: int, targets: int, scans: int, seed: int) -> None:
    """Simulate, track, score, and print the table."""
    for name, value in (("runs", runs), ("targets", targets), ("scans", scans)):
        if value < 1:
            raise ValueError(f"--{name} must be at least 1, got {value}")
    start = time.perf_counter()
    generators = np.random.default_rng(seed).spawn(runs)
    scenes = [simulate(rng, targets, scans) for rng in generators]
    output.message(
        f"{runs} runs of {scans} scans with {targets} targets, simulated and tracked in "
        f"{time.perf_counter() - start:.1f} s"
    )
    tm.consistency_test([1.0], df=1)  # imports SciPy first, so that it is not timed
    scores = score_scenes(scenes)
    output.write(Table(COLUMNS, scores))
    total = 1e3 * sum(score.seconds for score in scores)
    output.message(f"scored by the {tm.backend()!r} backend in {total:.1f} ms")


def _text(value: Any) -> str:
    return f"{value:.4f}" if isinstance(value, float) else str(value)


@dataclass
class TimedScore:
    """One row of the table."""

    name: str
    value: Any
    meaning: str
    seconds: float


def score_scenes(scenes: list[Scene]) -> list[TimedScore]:
    """The documented functions over all runs."""
    truth = [frame for scene in scenes for frame in scene.truth]
    reports = [frame for scene in scenes for frame in scene.reports]
    targets = max((max(s.true_labels, default=0) for s in scenes), default=0) + 1
    tracks = max((max(s.track_labels, default=0) for s in scenes), default=0) + 1
    run = np.repeat(np.arange(len(scenes)), [len(s.true_labels) for s in scenes])
    true_labels = np.concatenate([np.array(s.true_labels, int) for s in scenes]) + run * targets
    track_labels = np.concatenate([np.array(s.track_labels, int) for s in scenes]) + run * tracks
    x, xhat, p, nu, s = (
        np.array([row for scene in scenes for row in getattr(scene, name)])
        for name in (
            "true_states",
            "estimated_states",
            "covariances",
            "innovations",
            "innovation_covariances",
        )
    )
    return [
        _timed("OSPA", lambda: tm.ospa_over_time(truth, reports, c=CUTOFF).mean(), "m, 0 is best"),
        _timed("misses", lambda: _mot(truth, reports).num_misses, "targets without a track"),
        _timed("false alarms", lambda: _mot(truth, reports).num_false_positives, "extra tracks"),
        _timed("MOTP", lambda: _mot(truth, reports).motp, "m, mean distance of matches"),
        _timed("purity", lambda: tm.track_purity(true_labels, track_labels), "1 is best"),
        _timed(
            "fragmentations",
            lambda: tm.track_fragmentation(true_labels, track_labels),
            "changes of track, per target summed",
        ),
        _timed(
            "identity switches",
            lambda: tm.identity_switches(true_labels, track_labels),
            "changes of target, per track summed",
        ),
        _timed("position RMSE", lambda: tm.position_rmse(x, xhat, [0, 2]), "m per coordinate"),
        _timed("velocity RMSE", lambda: tm.velocity_rmse(x, xhat, [1, 3]), "m/s per coordinate"),
        _timed("mean NEES", lambda: tm.nees_sequence(x, xhat, p).mean(), "4 if consistent"),
        _timed("mean NIS", lambda: tm.nis_sequence(nu, s).mean(), "2 if consistent"),
        _timed(
            "NIS consistent",
            lambda: _consistent(tm.consistency_test(tm.nis_sequence(nu, s), df=2)),
            "mean inside its 95 % bounds",
        ),
        _timed(
            "credible at 95 %",
            lambda: tm.credibility_interval(x - xhat, p),
            "fraction of errors inside, 0.95 if consistent",
        ),
    ]


def _mot(truth: list[Floats], reports: list[Floats]) -> tm.MOTMetrics:
    return tm.mot_metrics(truth, reports, threshold=CUTOFF)


def _consistent(result: tm.ConsistencyResult) -> str:
    verdict = "yes" if result.is_consistent else "no"
    return f"{verdict} [{result.lower_bound:.3f}, {result.upper_bound:.3f}]"


def _timed(name: str, compute: Callable[[], Any], meaning: str) -> TimedScore:
    start = time.perf_counter()
    value = compute()
    seconds = time.perf_counter() - start
    return TimedScore(name, value, meaning, seconds)
