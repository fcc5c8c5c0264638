"""Many runs over a grid of settings."""

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from trackmetrics import _backend, _check
from trackmetrics._progress import RunProgress
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.scores import block_level_for
from trackmetrics.monte_carlo.checkpoint import Checkpoint
from trackmetrics.monte_carlo.driver import run_jobs
from trackmetrics.monte_carlo.identity import identity
from trackmetrics.monte_carlo.jobs import Job
from trackmetrics.monte_carlo.results import SweepResult
from trackmetrics.monte_carlo.setting_state import SettingState
from trackmetrics.monte_carlo.sweep_state import SweepState


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C; ``result`` holds what was done until then."""

    def __init__(self, result: SweepResult) -> None:
        super().__init__(
            f"after {sum(result.completed_runs)} of {result.runs * len(result.grid)} runs"
        )
        self.result = result


def sweep(
    simulate: Callable[..., Mapping[str, Any]],
    runs: int,
    *,
    seed: int | Sequence[int],
    grid: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]] | None = None,
    executor: Any = None,
    workers: int | None = None,
    chunk: int | None = None,
    progress: bool | Callable[[int, int], None] = True,
    checkpoint: str | os.PathLike[str] | None = None,
    version: Any = None,
    on_error: Literal["raise", "collect"] = "raise",
    angles: Mapping[int, float] | None = None,
    innovation_angles: Mapping[int, float] | None = None,
    worker_threads: int = 1,
) -> SweepResult:
    """Run a simulation many times for every setting of a grid, and accumulate the statistics.

    A run's random numbers are ``default_rng(SeedSequence(seed, spawn_key=(run,)))``, the same for
    every setting. So settings are compared on the same noise, and a result depends on the seed
    alone, not on the executor, the chunks, their order, or interruptions.

    Parameters
    ----------
    simulate : callable
        ``simulate(rng, **settings)`` is one run. It returns a mapping with any of ``truth`` and
        ``estimates`` (steps, n) with ``covariances`` (steps, n, n); ``innovations`` (steps, m) with
        ``innovation_covariances`` (steps, m, m), NaN where nothing was measured; numbers, which
        are scores of the run under their names; accumulators that hold the run as run 0.
    runs : int
        Runs of each setting.
    seed : int or sequence of int
        Decides every random number.
    grid : mapping of str to sequence, or sequence of mappings
        Values of each parameter, all combinations of which are settings, the last parameter
        fastest; or the settings themselves. None for one setting without parameters.
    executor : None, "threads", "processes", concurrent.futures.Executor or distributed.Client
        Where the runs are worked on: in this process; in ``workers`` threads or processes; or where
        the given executor does. A Dask client spreads them over a cluster.
    workers : int
        How many threads or processes, where they are made here; by default as many as processors.
    chunk : int
        Runs of a job; by default as many as take about half a second.
    progress : bool or callable
        Whether to show a bar (needs the extra ``progress``); or ``progress(done, total)``.
    checkpoint : path
        A folder to keep finished chunks in. A sweep that finds its own goes on from there; with
        more ``runs`` than before it adds those.
    version : Any
        Of ``simulate``: a checkpoint of another version is refused. Without it the source of
        ``simulate`` and of its module are compared.
    on_error : "raise" or "collect"
        What a run that fails does: end the sweep, or be listed in ``failures``. A run fails that
        raises (``sys.exit`` too), that returns other names or shapes than earlier runs of its
        setting, or whose result cannot be sent back. A run whose worker process dies is done again
        once, then it has failed.
    angles, innovation_angles : mapping of int to float
        As for :class:`ConsistencyAccumulator`.
    worker_threads : int
        Threads of a kernel in a worker.

    Returns
    -------
    SweepResult
        Statistics of every setting and step.

    Raises
    ------
    SweepInterrupted
        On Ctrl-C, within a second; a ``KeyboardInterrupt`` with the ``result`` so far. What runs in
        processes that were made here is lost, finished chunks are kept.
    ValueError
        For a wrong argument, and for a checkpoint of another sweep, with what differs.

    Notes
    -----
    Memory does not grow with the number of runs but by its logarithm. At most twice as many chunks
    are under way as there are workers.

    Examples
    --------
    >>> import numpy as np
    >>> def simulate(rng, claimed):
    ...     errors = rng.normal(size=(20, 2))
    ...     return {"truth": np.zeros((20, 2)), "estimates": errors,
    ...             "covariances": np.broadcast_to(claimed * np.eye(2), (20, 2, 2))}
    >>> result = sweep(simulate, 400, seed=1, grid={"claimed": [0.5, 1.0, 2.0]}, progress=False)
    >>> result.best().settings
    {'claimed': 1.0}
    >>> result.anees.mean(axis=1).round(1).tolist()
    [2.0, 1.0, 0.5]
    """
    settings = expand(grid)
    runs, worker_threads = _count("runs", runs), _count("worker_threads", worker_threads)
    chunk = None if chunk is None else _count("chunk", chunk)
    workers = None if workers is None else _count("workers", workers)
    _check_others(simulate, seed, checkpoint, on_error, progress)
    options = {"angles": angles, "innovation_angles": innovation_angles}
    # Refuses what are no angles, before the first run.
    ConsistencyAccumulator(angles=angles, innovation_angles=innovation_angles)
    store = None
    setting_states = [SettingState() for _ in settings]
    if checkpoint is not None:
        kept = {name: dict(value) if value else None for name, value in options.items()}
        store = Checkpoint(checkpoint, identity(simulate, seed, settings, version, **kept))
        setting_states = store.read(len(settings))
    template = Job(
        simulate, 0, {}, 0, 0, seed, on_error == "collect", block_level_for(runs), options,
        _backend.backend(), worker_threads,
    )  # fmt: skip
    state = SweepState(runs, settings, setting_states, store, template, chunk)
    with RunProgress(progress, runs * len(settings), state.done()) as bar:
        try:
            run_jobs(state, executor, workers, bar)
        except KeyboardInterrupt:
            raise SweepInterrupted(_result(state)) from None
    return _result(state)


def _result(state: SweepState) -> SweepResult:
    """What is known now."""
    return SweepResult(state.runs, state.template.seed, state.settings, state.setting_states)


def expand(
    grid: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]] | None,
) -> list[dict[str, Any]]:
    """The settings of a grid."""
    if grid is None:
        return [{}]
    if not isinstance(grid, Mapping):
        if not isinstance(grid, Sequence) or not all(isinstance(s, Mapping) for s in grid):
            raise TypeError(f"grid must be a mapping of names to values, or settings, got {grid!r}")
        settings = [dict(setting) for setting in grid]
        if not settings or any(setting.keys() != settings[0].keys() for setting in settings):
            raise ValueError("grid must hold at least one setting, all with the same parameters")
        return settings
    for name, values in grid.items():
        if isinstance(values, str) or not hasattr(values, "__iter__"):
            raise TypeError(f"grid[{name!r}] must be a sequence of values, got {values!r}")
        if not isinstance(name, str):
            raise TypeError(f"grid must name parameters by text, got {name!r}")
    columns = [[_plain(value) for value in values] for values in grid.values()]
    if not all(columns):
        empty = next(name for name, values in zip(grid, columns, strict=True) if not values)
        raise ValueError(f"grid[{empty!r}] is empty")
    return [dict(zip(grid, values, strict=True)) for values in itertools.product(*columns)]


def _plain(value: Any) -> Any:
    """NumPy scalars as Python numbers."""
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value


def _count(argument: str, value: Any) -> int:
    """A whole number, at least 1; a boolean is none."""
    if isinstance(value, bool | np.bool_):
        raise TypeError(f"{argument} must be a whole number, at least 1, got {value!r}")
    _check.count(argument, value, 1)
    return int(value)


def _check_others(simulate: Any, seed: Any, checkpoint: Any, on_error: str, progress: Any) -> None:
    if not callable(simulate):
        raise TypeError(f"simulate must be a function, got {type(simulate).__name__}")
    try:
        # None would be another seed in every run.
        seeded = seed is not None and not isinstance(seed, bool | np.bool_) and np.size(seed) > 0
        seeded = seeded and np.random.SeedSequence(seed) is not None
    except (TypeError, ValueError):
        seeded = False
    if not seeded:
        raise ValueError(f"seed must be a whole number, at least 0, or several, got {seed!r}")
    if checkpoint is not None and not isinstance(checkpoint, str | os.PathLike):
        raise TypeError(f"checkpoint must be a path, got {checkpoint!r}")
    if not callable(progress) and not isinstance(progress, bool | np.bool_):
        raise TypeError(f"progress must be True, False or a function, got {progress!r}")
    if on_error not in ("raise", "collect"):
        raise ValueError(f"on_error must be 'raise' or 'collect', got {on_error!r}")
