"""Names of columns as people write them, matched with the names that a reader knows."""

import difflib
from collections.abc import Iterable, Sequence

from trackmetrics._tables.errors import shown


def clean(names: Sequence[str], file: str) -> list[str]:
    """Headings without ``#``, blanks and quotes; an empty or repeated one is an error."""
    cleaned = [name.strip().strip("\"'").strip() for name in names]
    if cleaned:
        cleaned[0] = cleaned[0].lstrip("#%").strip().strip("\"'")
    # R's write.csv leaves the heading of its row names empty.
    if len(cleaned) > 1 and cleaned[0] == "":
        cleaned[0] = "row names"
    for place, name in enumerate(cleaned):
        if not name:
            raise ValueError(f"{file}: heading {place + 1} of {len(cleaned)} is empty")
        if name in cleaned[:place]:
            raise ValueError(f"{file}: heading {name!r} appears twice")
    return cleaned


def match(names: Sequence[str], known: Iterable[str]) -> dict[str, str]:
    """Which headings are known names in other capitals, as ``{heading: known name}``."""
    by_lower: dict[str, list[str]] = {}
    for name in known:
        by_lower.setdefault(name.lower(), []).append(name)
    found = {}
    for name in names:
        base, bracket, rest = name.partition("[")
        candidates = by_lower.get(base.strip().lower(), [])
        exact = base in candidates
        if not exact and len(candidates) == 1:
            found[name] = candidates[0] + bracket + rest
    return found


def nearest(wanted: str, names: Sequence[str]) -> str:
    """What to say of a heading that is missing: those there are, and the most similar."""
    close = difflib.get_close_matches(wanted, names, 1, 0.6)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"the headings are {shown(names)}{hint}"
