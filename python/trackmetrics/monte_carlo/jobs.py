"""Some runs of one setting, wherever they are worked on: the part of a sweep that travels."""

import os
import pickle
import signal
import threading
import time
import traceback
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackmetrics import _backend
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.setting_state import RunMismatchError, SettingState

ARRAYS = ("truth", "estimates", "covariances", "innovations", "innovation_covariances")
BATCH_RUNS = 64
"""Runs whose arrays are kept until they are reduced together."""
BATCH_BYTES = 8 << 20
"""Bytes of arrays after which they are reduced earlier."""
_TOKEN = uuid.uuid4().hex


def process_token() -> tuple[str, int]:
    """This process: a token of the import, and the number, since children inherit the token."""
    return _TOKEN, os.getpid()


@dataclass(frozen=True)
class Job:
    """Some runs of one setting."""

    simulate: Callable[..., Any]
    setting: int
    settings: Mapping[str, Any]
    first: int
    stop: int
    seed: Any
    collect: bool
    """Whether a run that fails is recorded, and does not stop the sweep."""
    block_level: int
    consistency: Mapping[str, Any]
    backend: str
    threads: int
    origin: tuple[str, int] = field(default_factory=process_token)


@dataclass(frozen=True)
class JobResult:
    """The result of a job."""

    setting: int
    state: SettingState
    seconds: float


def generator(seed: Any, run: int) -> np.random.Generator:
    """The random numbers of a run: they depend on the seed and on the run's number alone."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(run,)))


def work(job: Job, stopped: threading.Event | None = None) -> JobResult:
    """Simulates the runs of a job and reduces them; ends early, whole, where it is ``stopped``."""
    start = time.perf_counter()
    with _as_asked(job):
        reducer = _Reducer(job)
        for run in range(job.first, job.stop):
            if stopped is not None and stopped.is_set():
                break
            reducer.simulate(run)
        reducer.reduce()
    return JobResult(job.setting, reducer.state, time.perf_counter() - start)


def _is_interrupted_by_user(job: Job) -> bool:
    """Ctrl-C arrives in the main thread of the process of the sweep; elsewhere a run raised it."""
    in_main_thread = threading.current_thread() is threading.main_thread()
    return in_main_thread and job.origin == process_token()


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """In a worker process: leaves Ctrl-C to the process of the sweep."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)


@contextmanager
def _as_asked(job: Job) -> Iterator[None]:
    """In a process of its own, a job brings its backend and its number of kernel threads."""
    if job.origin == process_token():
        yield
        return
    before = _backend.threads()
    with _backend.use_backend(job.backend), _without_interrupts():
        _backend.set_threads(job.threads)
        try:
            yield
        finally:
            _backend.set_threads(before)


class _Reducer:
    """Collects runs and reduces them together."""

    def __init__(self, job: Job) -> None:
        self.job, self.state = job, SettingState()
        self.outputs: list[Mapping[str, Any]] = []
        self.first = job.first
        self.bytes = 0

    def simulate(self, run: int) -> None:
        """One run; its arrays wait to be reduced with those of its neighbours."""
        try:
            output = _checked(self._simulated(run))
        except Exception as error:
            self.reduce()
            self._fail(run, error)
            self.first = run + 1
            return
        self.outputs.append(output)
        self.bytes += sum(x.nbytes for x in output.values() if isinstance(x, np.ndarray))
        if len(self.outputs) == BATCH_RUNS or self.bytes > BATCH_BYTES:
            self.reduce()

    def _simulated(self, run: int) -> Any:
        """What the run returns; one that wants to end the program fails instead."""
        try:
            return self.job.simulate(generator(self.job.seed, run), **self.job.settings)
        except SystemExit as error:
            raise RuntimeError(f"simulate called sys.exit({error.code!r})") from error
        except KeyboardInterrupt as error:
            if _is_interrupted_by_user(self.job):
                raise
            raise RuntimeError("simulate raised KeyboardInterrupt") from error

    def reduce(self) -> None:
        """Reduces what waits; where that fails, run by run, to find the one at fault."""
        outputs, first = self.outputs, self.first
        self.outputs, self.bytes, self.first = [], 0, first + len(self.outputs)
        if not outputs:
            return
        try:
            self.state.merge(_reduced(self.job, outputs, first))
        except Exception as error:
            if len(outputs) == 1:
                self._fail(first, error)
                return
            for i, output in enumerate(outputs):
                self.outputs, self.first = [output], first + i
                self.reduce()
            self.first = first + len(outputs)

    def _fail(self, run: int, error: Exception) -> None:
        if not self.job.collect:
            error.add_note(f"in {describe_run(self.job, run)}")
            raise error if self.job.origin == process_token() else _travelling(error)
        if isinstance(error, RunMismatchError):
            self.state.fail(run, *mismatch(error))
            return
        text = traceback.format_exception_only(error)[0].strip()
        self.state.fail(run, text, "".join(traceback.format_exception(error)))


def describe_run(job: Job, run: int) -> str:
    """The run of a job, for messages."""
    given = ", ".join(f"{name}={value!r}" for name, value in job.settings.items())
    return f"run {run} of seed {job.seed}{given and f' with {given}'}"


def mismatch(error: RunMismatchError) -> tuple[str, str]:
    """Error and traceback of such a run: the same in whatever job it was."""
    return f"ValueError: {error}", ""


def _travelling(error: Exception) -> Exception:
    """The exception, or its text where it cannot be sent to another process."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        text = RuntimeError(traceback.format_exception_only(error)[0].strip())
        text.add_note(error.__notes__[-1])
        return text
    return error


def _checked(output: Any) -> dict[str, Any]:
    """Arrays as they are, scores as floats."""
    if not isinstance(output, Mapping):
        raise TypeError(f"simulate must return a mapping of names, got {type(output).__name__}")
    checked: dict[str, Any] = {}
    for name, value in output.items():
        if isinstance(value, Accumulator):
            checked[name] = value
        elif name in ARRAYS:
            checked[name] = np.asarray(value)
        else:
            checked[name] = _score(name, value)
    if not checked:
        raise ValueError("simulate returned nothing")
    return checked


def _score(name: str, value: Any) -> float:
    if np.ndim(value) or np.asarray(value).dtype.kind not in "biuf":
        raise TypeError(
            f"simulate returned {name!r} of type {type(value).__name__}: expected one of "
            f"{', '.join(ARRAYS)}, a number, or an accumulator"
        )
    return float(value)


def _reduced(job: Job, outputs: list[Mapping[str, Any]], first: int) -> SettingState:
    """The runs from ``first`` on, reduced."""
    names = list(outputs[0])
    for i, output in enumerate(outputs):
        if list(output) != names:
            here, there = ", ".join(output), ", ".join(names)
            raise ValueError(f"run {first + i} gave {here}; run {first} gave {there}")
    state, stop = SettingState(), first + len(outputs)
    scores: dict[str, Any] = {}
    batch = {name: _stacked(name, outputs, first) for name in names if name in ARRAYS}
    if batch:
        consistency = ConsistencyAccumulator(**job.consistency)
        scores |= _built_in(consistency.add_runs(batch, first), consistency.shape or {})
        state.add("consistency", consistency, first, stop)
    for name in names:
        values = [output[name] for output in outputs]
        if isinstance(values[0], Accumulator):
            for run, accumulator in enumerate(values, first):
                state.add(name, accumulator.renumbered(run), run, run + 1)
        elif name not in ARRAYS:
            scores[name] = values
    if scores:
        cell = ScoreAccumulator(job.block_level)
        cell.update(scores, first)
        state.add("scores", cell, first, stop)
    state.mark_done(first, stop)
    return state


def _stacked(name: str, outputs: list[Mapping[str, Any]], first: int) -> Any:
    arrays = [output[name] for output in outputs]
    for i, array in enumerate(arrays):
        if array.shape != arrays[0].shape:
            raise ValueError(
                f"{name} of run {first + i} has shape {array.shape}, "
                f"that of run {first} {arrays[0].shape}"
            )
    return np.stack(arrays)


def _built_in(of_runs: Mapping[str, Any], shape: Mapping[str, Any]) -> dict[str, Any]:
    """For each run the mean over its steps of q / n, and of the squared error of each state."""
    scores: dict[str, Any] = {}
    for channel, sums in of_runs.items():
        counted = np.where(sums[:, 0] > 0, sums[:, 0], np.nan)
        name = "nees" if channel == "states" else "nis"
        scores[name] = sums[:, 1] / counted / shape[channel][1]
        if channel == "states":
            for j in range(shape[channel][1]):
                scores[f"squared_error[{j}]"] = sums[:, 2 + j] / counted
    return scores
