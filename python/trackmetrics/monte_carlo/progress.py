"""How far a sweep is."""

from collections.abc import Callable
from types import TracebackType
from typing import Any, Self


class Progress:
    """A bar by `tqdm`, where it is wanted and installed; or a function that is told."""

    def __init__(self, wanted: bool | Callable[[int, int], None], total: int, done: int) -> None:
        self.done, self.total = done, total
        self._tell = wanted if callable(wanted) else None
        self._bar = _bar(total, done) if wanted is True else None

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


def _bar(total: int, done: int) -> Any:
    """Runs per second and remaining time; nothing where nobody watches."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    return tqdm(total=total, initial=done, unit="run", disable=None, mininterval=0.2)
