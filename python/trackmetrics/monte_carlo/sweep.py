"""Many runs over a grid of settings."""

import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from trackmetrics import _backend, _check
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator, block_level
from trackmetrics.monte_carlo.checkpoint import Checkpoint, identity
from trackmetrics.monte_carlo.executors import Workers, uninterrupted, workers_of
from trackmetrics.monte_carlo.jobs import Done, Job
from trackmetrics.monte_carlo.progress import Progress
from trackmetrics.monte_carlo.results import SweepResult
from trackmetrics.monte_carlo.setting_state import Tally

_SECONDS = 0.5
"""How long a chunk should take, where its size is not given."""
_MOST = 1 << 16


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C; ``result`` holds what was done until then."""

    def __init__(self, result: SweepResult) -> None:
        super().__init__(f"after {sum(result.done)} of {result.runs * len(result.grid)} runs")
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
    """Runs a simulation many times for every setting of a grid, and keeps the statistics.

    A run's random numbers are ``default_rng(SeedSequence(seed, spawn_key=(run,)))``, the same for
    every setting. So settings are compared on the same noise, and a result depends on the seed
    alone: not on the executor, the chunks, their order, or on having been killed and gone on with.

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
        Of ``simulate``: a checkpoint of another version is refused.
    on_error : "raise" or "collect"
        What a run that raises does: end the sweep, or be listed in ``failures``.
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
    counts = {"runs": runs, "chunk": chunk, "workers": workers, "worker_threads": worker_threads}
    for name, count in counts.items():
        if count is not None:
            _check.count(name, count, 1)
    _check_others(simulate, seed, checkpoint, on_error)
    options = {"angles": angles, "innovation_angles": innovation_angles}
    # Refuses what are no angles, before the first run.
    ConsistencyAccumulator(angles=angles, innovation_angles=innovation_angles)
    store = None
    tallies = [Tally() for _ in settings]
    if checkpoint is not None:
        kept = {name: dict(value) if value else None for name, value in options.items()}
        store = Checkpoint(checkpoint, identity(simulate, seed, settings, version, **kept))
        tallies = store.read(len(settings))
    template = Job(
        simulate, 0, {}, 0, 0, seed, on_error == "collect", block_level(runs), options,
        _backend.backend(), worker_threads,
    )  # fmt: skip
    state = _State(runs, settings, tallies, store, template, chunk)
    with Progress(progress, runs * len(settings), state.done()) as bar:
        _drive(state, executor, workers, bar)
    return state.result()


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
    columns = [[_plain(value) for value in values] for values in grid.values()]
    if not all(columns):
        empty = next(name for name, values in zip(grid, columns, strict=True) if not values)
        raise ValueError(f"grid[{empty!r}] is empty")
    return [dict(zip(grid, values, strict=True)) for values in itertools.product(*columns)]


def _plain(value: Any) -> Any:
    """NumPy scalars as Python numbers."""
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value


def _check_others(simulate: Any, seed: Any, checkpoint: Any, on_error: str) -> None:
    if not callable(simulate):
        raise TypeError(f"simulate must be a function, got {type(simulate).__name__}")
    try:
        # None would be another seed in every run.
        seeded = seed is not None and np.random.SeedSequence(seed) is not None
    except (TypeError, ValueError):
        seeded = False
    if not seeded:
        raise ValueError(f"seed must be a whole number, at least 0, or several, got {seed!r}")
    if checkpoint is not None and not isinstance(checkpoint, str | os.PathLike):
        raise TypeError(f"checkpoint must be a path, got {checkpoint!r}")
    if on_error not in ("raise", "collect"):
        raise ValueError(f"on_error must be 'raise' or 'collect', got {on_error!r}")


@dataclass
class _State:
    """What is done, and what is next."""

    runs: int
    settings: list[dict[str, Any]]
    tallies: list[Tally]
    store: Checkpoint | None
    template: Job
    chunk: int | None
    seconds: float | None = None
    """Of a run, lately."""
    left: list[list[tuple[int, int]]] = field(init=False)
    """For each setting the runs that no job has, as intervals."""

    def __post_init__(self) -> None:
        for tally in self.tallies:
            if tally.covered and tally.covered[-1][1] > self.runs:
                have = tally.covered[-1][1]
                raise ValueError(f"the checkpoint has {have} runs, runs is {self.runs}")
            scores = tally.cells.get("scores")
            if isinstance(scores, ScoreAccumulator):
                scores.coarsen(self.template.block_level)
        self.left = [_complement(tally.covered, self.runs) for tally in self.tallies]

    def done(self) -> int:
        """Runs that are done, over all settings."""
        return sum(len(tally) for tally in self.tallies)

    def jobs(self, in_flight: int) -> Iterator[Job]:
        """The jobs, all settings of the first runs first."""
        while any(self.left):
            for setting, left in enumerate(self.left):
                if left:
                    yield self._job(setting, self._size(in_flight))

    def _size(self, in_flight: int) -> int:
        """Runs of the next job; fewer towards the end, so that all workers end together."""
        if self.chunk is not None:
            return self.chunk
        if self.seconds is None:
            return 1
        left = sum(stop - first for intervals in self.left for first, stop in intervals)
        share = -(-left // in_flight)
        return max(1, min(_MOST, share, int(_SECONDS / max(self.seconds, 1e-9))))

    def _job(self, setting: int, size: int) -> Job:
        first, stop = self.left[setting].pop(0)
        if stop - first > size:
            self.left[setting].insert(0, (first + size, stop))
            stop = first + size
        changes = {"setting": setting, "settings": self.settings[setting]}
        return Job(**{**vars(self.template), **changes, "first": first, "stop": stop})

    def take(self, done: Done) -> int:
        """Adds what came of a job; how many runs that were."""
        tally = self.tallies[done.setting]
        tally.merge(done.tally)
        if self.store:
            self.store.write(done.setting, tally)
        if len(done.tally):
            self.seconds = done.seconds / len(done.tally)
        return len(done.tally)

    def result(self) -> SweepResult:
        """What is known now."""
        return SweepResult(self.runs, self.template.seed, self.settings, self.tallies)


def _drive(state: _State, executor: Any, count: int | None, bar: Progress) -> None:
    simulate, threads = state.template.simulate, state.template.threads
    with workers_of(executor, count, simulate, threads) as found:
        pending: set[Future[Done]] = set()
        try:
            for job in state.jobs(found.in_flight):
                pending.add(found.submit(job))
                while len(pending) >= found.in_flight:
                    _collect(state, pending, bar)
            while pending:
                _collect(state, pending, bar)
        except BaseException as error:
            _stop(state, found, pending)
            if isinstance(error, KeyboardInterrupt):
                raise SweepInterrupted(state.result()) from None
            raise


def _collect(state: _State, pending: set["Future[Done]"], bar: Progress) -> None:
    """Takes what has finished, and waits where nothing has."""
    finished, _ = wait(pending, timeout=0.2, return_when=FIRST_COMPLETED)
    for future in finished:
        with uninterrupted():
            pending.discard(future)
            bar.add(state.take(future.result()))


def _stop(state: _State, found: Workers, pending: set["Future[Done]"]) -> None:
    """Keeps what has finished, and gives up the rest."""
    for future in pending:
        future.cancel()
    for future in pending:
        if future.done() and not future.cancelled() and future.exception() is None:
            state.take(future.result())
    found.abandon()


def _complement(covered: Sequence[tuple[int, int]], runs: int) -> list[tuple[int, int]]:
    """The intervals of ``0 .. runs`` that are not covered."""
    starts = [0, *(stop for _, stop in covered)]
    stops = [*(first for first, _ in covered), runs]
    return [(a, b) for a, b in zip(starts, stops, strict=True) if a < b]
