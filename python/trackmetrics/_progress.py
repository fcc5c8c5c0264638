"""A bar on standard error for what takes a while, where somebody watches.

It needs the extra ``progress``; without it, or where standard error is no terminal, there is none.
"""

import os
from collections.abc import Iterable, Iterator
from typing import IO, Any, TypeVar

Item = TypeVar("Item")
DELAY = 0.5
"""Seconds until a bar appears: several come one after the other."""


def bar(total: int, unit: str, **options: Any) -> Any:
    """A bar with ``update`` and ``close``; None where tqdm is not installed."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    return tqdm(total=total, unit=unit, disable=None, mininterval=0.2, **options)


def watched(items: Iterable[Item], what: str, total: int, unit: str) -> Iterator[Item]:
    """The items, counted on a bar."""
    return _counted(items, what, total, unit, lambda _: 1)


def lines(file: IO[str], what: str) -> Iterator[str]:
    """The lines of a file; the bar counts what is read of it, nearly in bytes."""
    return _counted(file, what, os.fstat(file.fileno()).st_size, "B", len)


def _counted(items: Iterable[Any], what: str, total: int, unit: str, size: Any) -> Iterator[Any]:
    shown = bar(total, unit, desc=what, unit_scale=True, delay=DELAY, leave=False)
    if shown is None or shown.disable:
        yield from items
        return
    with shown:
        for item in items:
            yield item
            shown.update(size(item))
