"""Short texts for messages: never more of a value than a reader can take in."""

from collections.abc import Iterable
from typing import Any

MAX_NAMES = 12
MAX_VALUE = 60


def shown(names: Iterable[str]) -> str:
    """Names in a row, the first dozen of them."""
    listed = list(names)
    text = ", ".join(listed[:MAX_NAMES])[:90]
    return text + (f", ... ({len(listed)} in all)" if len(listed) > MAX_NAMES else "")


def value(given: Any, longest: int = MAX_VALUE) -> str:
    """A value as Python writes it, shortened."""
    text = repr(given)
    return text if len(text) <= longest else text[: longest - 3] + "..."
