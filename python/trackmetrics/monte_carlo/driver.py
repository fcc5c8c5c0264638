"""Gives the jobs of a sweep to workers, takes what comes of them, and does again what was lost."""

from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from typing import Any

from trackmetrics._progress import RunProgress
from trackmetrics.monte_carlo.executors import Workers, open_workers, uninterrupted
from trackmetrics.monte_carlo.jobs import Job, JobResult, describe_run
from trackmetrics.monte_carlo.sweep_state import SweepState, halves

_DIED = "its worker process died, twice: killed, out of memory, or ended by its own code"

Pending = dict["Future[JobResult]", Job]


def run_jobs(state: SweepState, executor: Any, count: int | None, bar: RunProgress) -> None:
    """Works on all jobs; on an error, keeps what has finished and gives up the rest."""
    template = state.template
    simulate, threads = template.simulate, template.threads
    with open_workers(executor, count, simulate, threads, state.settings) as workers:
        pending: Pending = {}
        try:
            while True:
                for job in state.jobs(workers.in_flight):
                    _submit(state, workers, pending, job, bar)
                    while len(pending) >= workers.in_flight:
                        _collect(state, workers, pending, bar)
                if pending:
                    _collect(state, workers, pending, bar)
                elif not (state.again or any(state.left)):
                    break
        except BaseException:
            _stop(state, workers, pending)
            raise


def _submit(
    state: SweepState, workers: Workers, pending: Pending, job: Job, bar: RunProgress
) -> None:
    try:
        pending[workers.submit(job)] = job
    except BrokenExecutor as error:
        # A worker died since the last look: this job has not begun.
        state.again.appendleft(job)
        _replace_workers(state, workers, pending, error, bar)


def _collect(state: SweepState, workers: Workers, pending: Pending, bar: RunProgress) -> None:
    """Takes what has finished, and waits where nothing has."""
    finished, _ = wait(pending, timeout=0.2, return_when=FIRST_COMPLETED)
    for future in finished:
        error = future.exception()
        if isinstance(error, BrokenExecutor):
            _replace_workers(state, workers, pending, error, bar)
            return
        with uninterrupted():
            bar.add(_take(state, pending.pop(future), future))


def _take(state: SweepState, job: Job, future: "Future[JobResult]") -> int:
    """Adds a finished job; how many runs that were."""
    error = future.exception()
    if error is None:
        return state.take(job, future.result())
    if not (state.collects and isinstance(error, Exception)):
        raise error
    # The runs themselves fail inside the job: what fails here is sending its result.
    if job.stop - job.first > 1:
        state.again.extend(halves(job))
        return 0
    return state.fail(job, f"{type(error).__name__}: {error}")


def _replace_workers(
    state: SweepState, workers: Workers, pending: Pending, error: BaseException, bar: RunProgress
) -> None:
    """After the death of a worker: all jobs that were under way are done again, one at a time.

    A job that kills its worker again is halved, so that the run at fault is found in a few steps.
    """
    wait(pending)
    suspects: list[Job] = []
    for future, job in list(pending.items()):
        del pending[future]
        if isinstance(future.exception(), BrokenExecutor):
            suspects.append(job)
        else:
            bar.add(_take(state, job, future))
    _restart(workers, error)
    suspects.reverse()
    while suspects:
        job = suspects.pop()
        future = workers.submit(job)
        while not future.done():
            wait([future], timeout=0.2)
        error_again = future.exception()
        if not isinstance(error_again, BrokenExecutor):
            bar.add(_take(state, job, future))
            continue
        _restart(workers, error_again)
        if job.stop - job.first > 1:
            suspects.extend(reversed(halves(job)))
        elif state.collects:
            bar.add(state.fail(job, f"RuntimeError: {_DIED}"))
        else:
            raise RuntimeError(f"{describe_run(job, job.first)}: {_DIED}") from error_again


def _restart(workers: Workers, error: BaseException) -> None:
    if not workers.restart():
        raise RuntimeError(
            f"a worker of the given executor died ({error}); with executor='processes' its runs "
            "are done again"
        ) from error


def _stop(state: SweepState, workers: Workers, pending: Pending) -> None:
    """Keeps what has finished, and gives up the rest."""
    for future in pending:
        future.cancel()
    for future, job in pending.items():
        if future.done() and not future.cancelled() and future.exception() is None:
            state.take(job, future.result())
    workers.abandon()
