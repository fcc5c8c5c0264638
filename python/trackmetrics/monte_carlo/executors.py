"""Where jobs are worked on: this process, threads, processes, or a cluster."""

import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from trackmetrics import _backend
from trackmetrics.monte_carlo.jobs import Job, JobResult, work


def _cannot_restart() -> bool:
    return False


@dataclass(frozen=True)
class Workers:
    """Takes jobs."""

    submit: Callable[[Job], "Future[JobResult]"]
    in_flight: int
    """The most jobs that may be given and not yet taken back."""
    abandon: Callable[[], None]
    """Stops at once, whatever is lost."""
    restart: Callable[[], bool] = _cannot_restart
    """Starts new workers where one has died; whether that can be done."""


@contextmanager
def open_workers(
    executor: Any, count: int | None, simulate: Callable[..., Any], threads: int, grid: Any
) -> Iterator[Workers]:
    """The workers that ``executor`` names or is; those that are made here end with the block."""
    if executor is None:
        yield Workers(_run_inline, 1, _nothing)
    elif executor == "threads":
        with _threads(count or os.cpu_count() or 1, threads) as found:
            yield found
    elif executor == "processes":
        with _processes(count or os.cpu_count() or 1, simulate, grid) as found:
            yield found
    elif isinstance(executor, Executor):
        given = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
        yield Workers(lambda job: executor.submit(work, job), 2 * given, _nothing)
    elif _is_dask(executor):
        pool = executor.get_executor(pure=False)
        cores = sum(executor.nthreads().values())
        yield Workers(lambda job: pool.submit(work, job), 2 * max(cores, 1), _nothing)
    else:
        raise TypeError(
            "executor must be None, 'threads', 'processes', a concurrent.futures.Executor or a "
            f"distributed.Client, got {executor!r}"
        )


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Keeps Ctrl-C waiting to the end of the block, so that nothing stays half done."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.default_int_handler)
        if came:
            signal.raise_signal(signal.SIGINT)


def _nothing() -> None:
    """What is not ours is not ended by us."""


def _run_inline(job: Job) -> "Future[JobResult]":
    """Works on a job in this thread."""
    future: Future[JobResult] = Future()
    try:
        future.set_result(work(job))
    except Exception as error:
        future.set_exception(error)
    return future


@contextmanager
def _threads(count: int, kernel_threads: int) -> Iterator[Workers]:
    """Threads of this process: for a ``simulate`` that lets go of the interpreter.

    A thread cannot be killed: it is asked to stop after the run that it is in.
    """
    stopped = threading.Event()
    pool = ThreadPoolExecutor(count, thread_name_prefix="sweep")
    before = _backend.threads()
    _backend.set_threads(kernel_threads)
    try:
        yield Workers(lambda job: pool.submit(work, job, stopped), 2 * count, stopped.set)
    finally:
        stopped.set()
        pool.shutdown(wait=False, cancel_futures=True)
        _backend.set_threads(before)


@contextmanager
def _processes(count: int, simulate: Callable[..., Any], grid: Any) -> Iterator[Workers]:
    """Processes of this machine, which end with this one."""
    _require_pickle("simulate", simulate)
    _require_pickle("a value of grid", grid)
    pool = ProcessPoolExecutor(count, initializer=_begin)
    ended = False

    def abandon() -> None:
        nonlocal ended
        ended = True
        processes = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()

    def restart() -> bool:
        nonlocal pool
        pool.shutdown(wait=True, cancel_futures=True)
        pool = ProcessPoolExecutor(count, initializer=_begin)
        return True

    try:
        yield Workers(lambda job: pool.submit(work, job), 2 * count, abandon, restart)
    finally:
        if not ended:
            pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """A worker leaves Ctrl-C to its parent, and does not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True, name="end-with-parent").start()


def _end_with_parent() -> None:
    from multiprocessing import connection, parent_process

    if parent := parent_process():
        connection.wait([parent.sentinel])
        os._exit(1)


def _require_pickle(name: str, value: Any) -> None:
    try:
        pickle.dumps(value)
    except Exception as error:
        raise TypeError(
            f"{name} cannot be sent to other processes ({error}): define it at the top of a "
            "module, or use executor='threads'"
        ) from None


def _is_dask(executor: Any) -> bool:
    return hasattr(executor, "get_executor") and hasattr(executor, "nthreads")
