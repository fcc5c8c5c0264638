"""The demo, in two scenes.

``ships``: three ships, tracked by the vessel estimator, diagnosed, on one page. ``targets``: a
seeded Monte Carlo run of a small scene, scored with the documented functions; every line of the
table says what was computed, what is good, and how long it took.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import trackmetrics as tm
from trackmetrics.cli._demo_targets import Floats, Scene, simulate

CUTOFF = 50.0  # metres: the price of a missed target, and the gate of a match


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the user may choose."""
    parser.add_argument("--scene", choices=["ships", "targets"], default="ships")
    ships = parser.add_argument_group("ships")
    ships.add_argument("--noise", choices=["honest", "article"], default="honest")
    ships.add_argument("--html", help="the page (demo.html); '' for none")
    targets = parser.add_argument_group("targets")
    targets.add_argument("--runs", type=int, default=20, help="Monte Carlo runs (20)")
    targets.add_argument("--targets", type=int, default=10, help="targets in each run (10)")
    targets.add_argument(
        "--scans", type=int, default=100, help="scans of each run, 1 s apart (100)"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers (1)")


def run(arguments: argparse.Namespace) -> int:
    """Run the scene that was asked for."""
    if arguments.scene == "ships":
        from trackmetrics.cli import _demo_ships

        return _demo_ships.run(arguments)
    return run_targets(arguments)


def run_targets(arguments: argparse.Namespace) -> int:
    """Simulate, track, score, and print the table."""
    for name in ("runs", "targets", "scans"):
        if getattr(arguments, name) < 1:
            raise ValueError(f"--{name} must be at least 1, got {getattr(arguments, name)}")
    start = time.perf_counter()
    generators = np.random.default_rng(arguments.seed).spawn(arguments.runs)
    scenes = [simulate(rng, arguments.targets, arguments.scans) for rng in generators]
    print(
        f"{arguments.runs} runs of {arguments.scans} scans with {arguments.targets} targets, "
        f"simulated and tracked in {time.perf_counter() - start:.1f} s\n"
    )
    tm.consistency_test([1.0], df=1)  # imports SciPy's special functions, which no score owes
    lines = score(scenes)
    for line in lines:
        print(f"{line.name:18} {line.value:>22}  {1e3 * line.seconds:8.3f} ms  {line.meaning}")
    total = 1e3 * sum(line.seconds for line in lines)
    print(f"\nscored by the {tm.backend()!r} backend in {total:.1f} ms")
    return 0


@dataclass
class Score:
    """One line of the table."""

    name: str
    value: str
    meaning: str
    seconds: float


def score(scenes: list[Scene]) -> list[Score]:
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
        _timed("mean NEES", lambda: tm.nees_sequence(x, xhat, p).mean(), "4 for an honest filter"),
        _timed("mean NIS", lambda: tm.nis_sequence(nu, s).mean(), "2 for an honest filter"),
        _timed(
            "NIS consistent",
            lambda: _consistent(tm.consistency_test(tm.nis_sequence(nu, s), df=2)),
            "mean inside its 95 % bounds",
        ),
        _timed(
            "credible at 95 %",
            lambda: tm.credibility_interval(x - xhat, p),
            "share of errors inside, 0.95 is honest",
        ),
    ]


def _mot(truth: list[Floats], reports: list[Floats]) -> tm.MOTMetrics:
    return tm.mot_metrics(truth, reports, threshold=CUTOFF)


def _consistent(result: tm.ConsistencyResult) -> str:
    verdict = "yes" if result.is_consistent else "no"
    return f"{verdict} [{result.lower_bound:.3f}, {result.upper_bound:.3f}]"


def _timed(name: str, compute: Callable[[], Any], meaning: str) -> Score:
    start = time.perf_counter()
    value = compute()
    seconds = time.perf_counter() - start
    return Score(name, f"{value:.4f}" if isinstance(value, float) else str(value), meaning, seconds)
