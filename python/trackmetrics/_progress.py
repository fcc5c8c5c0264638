"""Progress bars on standard error, where it is a terminal and the work takes a while.

They need ``rich`` (the extra ``progress`` or ``cli``); without it, or where standard error is no
terminal, there are none.
"""

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import IO, Any, Self, TypeVar

Item = TypeVar("Item")
DELAY = 1.0
"""A bar appears if the work takes longer than this, in seconds."""
_REFRESH = 0.1
"""Seconds between two refreshes of a bar."""

enabled = True
"""Whether bars are drawn at all; the command line's ``--quiet`` clears it."""


class Bar:
    """A progress bar; ``update`` counts, ``close`` removes it."""

    def __init__(self, total: int, description: str, unit: str, done: int = 0) -> None:
        self._total, self._description, self._unit = total, description, unit
        self._done = done
        self._next = time.monotonic() + DELAY
        self._progress: Any = None
        self._task: Any = None

    def update(self, amount: int = 1) -> None:
        """Adds to what is done; draws the bar after ``DELAY`` seconds, then now and then."""
        self._done += amount
        if time.monotonic() < self._next:
            return
        if self._progress is None:
            self._start()
        self._progress.update(self._task, completed=self._done)
        self._progress.refresh()
        self._next = time.monotonic() + _REFRESH

    def close(self) -> None:
        """Removes the bar."""
        if self._progress is not None:
            self._progress.stop()

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
        from rich.progress import TimeRemainingColumn as Remaining

        # No refreshing thread: sweeps fork.
        self._progress = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn(self._unit, markup=False),
            Remaining(),
            console=Console(file=sys.stderr),
            auto_refresh=False,
            transient=True,
        )
        self._task = self._progress.add_task(self._description, total=self._total)
        self._progress.start()


def bar(total: int, unit: str, *, desc: str = "", initial: int = 0) -> Bar | None:
    """A bar, or None if it would not be seen."""
    if not enabled or not sys.stderr.isatty():
        return None
    try:
        import rich.progress  # noqa: F401
    except ImportError:
        return None
    return Bar(total, desc, unit, initial)


class RunProgress:
    """How far a sweep is: a bar (if `rich` is installed), or a function that is called instead."""

    def __init__(self, wanted: bool | Callable[[int, int], None], total: int, done: int) -> None:
        self.done, self.total = done, total
        self._tell = wanted if callable(wanted) else None
        self._bar = bar(total, "run", initial=done) if wanted is True else None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.close()

    def add(self, runs: int) -> None:
        """Counts so many more runs as done."""
        self.done += runs
        if self._bar is not None:
            self._bar.update(runs)
        if self._tell is not None:
            self._tell(self.done, self.total)


def with_progress(items: Iterable[Item], description: str, total: int, unit: str) -> Iterator[Item]:
    """The items, counted by a bar."""
    return _counted(items, description, total, unit.strip(), lambda _: 1)


def lines_with_progress(file: IO[str], description: str) -> Iterator[str]:
    """The lines of a file; the bar counts the characters read, of the bytes of the file."""
    return _counted(file, description, os.fstat(file.fileno()).st_size, "", len)


def _counted(items: Iterable[Any], what: str, total: int, unit: str, size: Any) -> Iterator[Any]:
    shown = bar(total, unit, desc=what)
    if shown is None:
        yield from items
        return
    try:
        for item in items:
            yield item
            shown.update(size(item))
    finally:
        shown.close()
