"""How far a sweep is."""

from collections.abc import Callable
from types import TracebackType
from typing import Self

from trackmetrics._progress import bar


class Progress:
    """A progress bar (if `rich` is installed), or a function that is called instead."""

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
        """So many runs are done."""
        self.done += runs
        if self._bar is not None:
            self._bar.update(runs)
        if self._tell is not None:
            self._tell(self.done, self.total)
