"""Simulations that workers can import, and what the sweep tests run in fresh interpreters."""

import json
import multiprocessing
import os
import random
import resource
import sys
import time
from pathlib import Path

import numpy as np

from trackmetrics.monte_carlo import sweep
from trackmetrics.monte_carlo.setting_state import SettingState

GRID = {"claimed": [0.5, 1.0, 2.0]}


def consistent(rng, claimed=1.0, steps=6, seconds=0.0):
    """Errors of unit variance that claim ``claimed``; every third innovation is missing."""
    if seconds:
        time.sleep(seconds)
    errors = rng.normal(size=(steps, 2))
    innovations = rng.normal(size=(steps, 1))
    innovations[::3] = np.nan
    return {
        "truth": np.ones((steps, 2)),
        "estimates": np.ones((steps, 2)) - errors,
        "covariances": np.broadcast_to(claimed * np.eye(2), (steps, 2, 2)),
        "innovations": innovations,
        "innovation_covariances": np.full((steps, 1, 1), claimed),
        "distance": float(np.abs(errors).sum()),
    }


def scaled(rng, claimed=1.0, steps=6):
    """As ``consistent``, always of six steps: ``steps`` scales nothing that is judged."""
    return consistent(rng, claimed) | {"steps": steps}


def failing(rng, claimed=1.0):
    """Fails in about one run of ten."""
    output = consistent(rng, claimed)
    if rng.random() < 0.1:
        raise ArithmeticError("the filter diverged")
    if rng.random() < 0.1:
        output["covariances"] = -output["covariances"]
    return output


def slow(rng, claimed=1.0):
    """A run of two milliseconds."""
    return consistent(rng, claimed, seconds=0.002)


def once_deadly(rng, folder, pid):
    """Kills the worker that runs it, the first time."""
    mark = Path(folder) / "killed"
    if rng.random() < 0.05 and os.getpid() != pid and not mark.exists():
        mark.touch()
        os._exit(9)
    return consistent(rng)


def cheap(rng):
    """A run of almost nothing."""
    return {"distance": rng.random(), **_CHEAP}


_CHEAP = {"truth": np.zeros((4, 2)), "estimates": np.ones((4, 2)), "covariances": [np.eye(2)] * 4}


def kill_at_random_moments(folder, kills):
    """Kills a sweep ``kills`` times, reads its checkpoint each time, and lets it end."""
    fork, moments = multiprocessing.get_context("fork"), random.Random(1)
    arguments = (folder, 300)
    done = []
    sweep(consistent, 2, seed=1, progress=False)  # imports what the children need
    for _ in range(int(kills)):
        child = fork.Process(target=_one_sweep, args=arguments)
        child.start()
        time.sleep(moments.uniform(0.0, 0.15))
        child.kill()
        child.join()
        files = sorted(Path(folder).glob("*.tally"))
        done.append(sum(len(SettingState.from_bytes(file.read_bytes())) for file in files))
    result = _one_sweep(*arguments)
    never_killed = sweep(slow, 300, seed=3, grid=GRID, progress=False)
    print(json.dumps([done, result.to_bytes() == never_killed.to_bytes()]))


def _one_sweep(folder, runs):
    return sweep(slow, runs, seed=3, grid=GRID, chunk=7, checkpoint=folder, progress=False)


def memory(runs):
    """The most memory that a sweep of this many runs took, in bytes."""
    sweep(cheap, 1000, seed=1, progress=False)
    sweep(cheap, int(runs), seed=1, progress=False)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)


def interrupted(executor):
    """A sweep that says when it is under way, and what it keeps on Ctrl-C."""
    from trackmetrics.monte_carlo import SweepInterrupted

    def tell(done, total):
        if done > 20:
            print("under way", flush=True)

    executor = None if executor == "None" else executor
    try:
        sweep(slow, 10**6, seed=3, executor=executor, workers=2, chunk=5, progress=tell)
    except SweepInterrupted as stop:
        print("kept", sum(stop.result.completed_runs), stop.result.anees.shape, flush=True)
        sys.stdout.flush()
        os._exit(0)


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
