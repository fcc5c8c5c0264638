"""What is done of a sweep, and what is next."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.checkpoint import Checkpoint
from trackmetrics.monte_carlo.jobs import Job, JobResult, mismatch
from trackmetrics.monte_carlo.setting_state import RunMismatchError, SettingState

CHUNK_SECONDS = 0.5
"""How long a job should take, where its size is not given."""
MAX_CHUNK = 1 << 16
"""The most runs of a job."""


@dataclass
class SweepState:
    """What is done, and what is next."""

    runs: int
    settings: list[dict[str, Any]]
    setting_states: list[SettingState]
    store: Checkpoint | None
    template: Job
    chunk: int | None
    seconds: float | None = None
    """Of a run, lately."""
    again: deque[Job] = field(default_factory=deque)
    """Jobs that are to be done again, in halves."""
    left: list[list[tuple[int, int]]] = field(init=False)
    """For each setting the runs that no job has, as intervals."""

    def __post_init__(self) -> None:
        for state in self.setting_states:
            if state.intervals and state.intervals[-1][1] > self.runs:
                have = state.intervals[-1][1]
                raise ValueError(
                    f"the checkpoint already holds {have} runs, more than runs={self.runs}"
                )
            scores = state.accumulators.get("scores")
            if isinstance(scores, ScoreAccumulator):
                scores.merge_blocks(self.template.block_level)
        self.waiting: list[dict[int, tuple[Job, JobResult]]] = [{} for _ in self.settings]
        self.left = [_complement(state.intervals, self.runs) for state in self.setting_states]

    def done(self) -> int:
        """Runs that are done, over all settings."""
        return sum(len(state) for state in self.setting_states)

    @property
    def collects(self) -> bool:
        """Whether runs that fail are listed."""
        return self.template.collect

    def jobs(self, in_flight: int) -> Iterator[Job]:
        """The jobs, all settings of the first runs first; those to be done again come first."""
        while any(self.left) or self.again:
            for setting in range(len(self.left)):
                while self.again:
                    yield self.again.popleft()
                if self.left[setting]:
                    yield self._job(setting, self._size(in_flight))

    def _size(self, in_flight: int) -> int:
        """Runs of the next job; fewer towards the end, so that all workers end together."""
        if self.chunk is not None:
            return self.chunk
        if self.seconds is None:
            return 1
        left = sum(stop - first for intervals in self.left for first, stop in intervals)
        share = -(-left // in_flight)
        return max(1, min(MAX_CHUNK, share, int(CHUNK_SECONDS / max(self.seconds, 1e-9))))

    def _job(self, setting: int, size: int) -> Job:
        first, stop = self.left[setting].pop(0)
        if stop - first > size:
            self.left[setting].insert(0, (first + size, stop))
            stop = first + size
        settings = self.settings[setting]
        return replace(self.template, setting=setting, settings=settings, first=first, stop=stop)

    def take(self, job: Job, done: JobResult) -> int:
        """Adds the result of a job; returns how many runs it has.

        Where failures are collected, the first runs that succeed say what the others must return.
        So what comes before them waits: the result does not depend on who was faster.
        """
        setting = done.setting
        if not self.collects or self.setting_states[setting].accumulators:
            return self._merge(job, done)
        self.waiting[setting][job.first] = (job, done)
        return self._merge_waiting(setting)

    def _merge_waiting(self, setting: int) -> int:
        waiting, taken = self.waiting[setting], 0
        while waiting:
            state, first = self.setting_states[setting], min(waiting)
            if not state.accumulators and first != _complement(state.intervals, self.runs)[0][0]:
                break
            taken += self._merge(*waiting.pop(first))
        return taken

    def _merge(self, job: Job, done: JobResult) -> int:
        state = self.setting_states[done.setting]
        try:
            state.merge(done.state)
        except RunMismatchError as error:
            if not self.collects:
                raise
            if job.stop - job.first > 1:
                self.again.extend(halves(job))
                return 0
            state.fail(job.first, *mismatch(error))
        if self.store:
            self.store.write(done.setting, state)
        if len(done.state):
            self.seconds = done.seconds / len(done.state)
        return len(done.state)

    def fail(self, job: Job, error: str) -> int:
        """Lists the one run of a job as failed; how many runs are done by that."""
        state = self.setting_states[job.setting]
        state.fail(job.first, error, "")
        if self.store:
            self.store.write(job.setting, state)
        return 1 + self._merge_waiting(job.setting)


def halves(job: Job) -> list[Job]:
    """A job of several runs as two: in a few steps that leads to the run at fault."""
    middle = (job.first + job.stop) // 2
    return [replace(job, stop=middle), replace(job, first=middle)]


def _complement(covered: Sequence[tuple[int, int]], runs: int) -> list[tuple[int, int]]:
    """The intervals of ``0 .. runs`` that are not covered."""
    starts = [0, *(stop for _, stop in covered)]
    stops = [*(first for first, _ in covered), runs]
    return [(a, b) for a, b in zip(starts, stops, strict=True) if a < b]
