"""Names of columns as people write them, matched with the names that a reader knows."""

import difflib
import re
from collections.abc import Iterable, Sequence

from trackmetrics._tables.errors import shown, value


def clean(names: Sequence[str], file: str) -> list[str]:
    """Headings without ``#``, blanks and quotes; an empty or repeated one is an error."""
    cleaned = [name.strip().strip("\"'").strip() for name in names]
    if cleaned:
        cleaned[0] = cleaned[0].lstrip("#%").strip().strip("\"'")
    # R's write.csv leaves the heading of its row names empty.
    if len(cleaned) > 1 and cleaned[0] == "":
        cleaned[0] = "row names"
    if cleaned and all(re.fullmatch(r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?", n) for n in cleaned):
        raise ValueError(
            f"{file} has no headings (its first row is {shown(cleaned)}): expected names such as "
            "time, nis, nis_dof"
        )
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
    targets: dict[str, str] = {}
    for name in names:
        other = targets.setdefault(found.get(name, name), name)
        if other != name:
            raise ValueError(f"headings {other!r} and {name!r} name one column")
    return found


def unmatched(names: Sequence[str], known: Iterable[str]) -> list[str]:
    """The headings that are no known name in any capitals, nor an element of one."""
    lower = {name.lower() for name in known}
    return [n for n in names if n.partition("[")[0].strip().lower() not in lower]


def closest(name: str, known: Iterable[str]) -> str | None:
    """The known name that a heading with a typing error most likely means; None if none is near."""
    base = re.sub(r"\[.*", "", name)
    close = difflib.get_close_matches(base, [k for k in known if len(k) > 2], 1, 0.75)
    return close[0] if len(base) > 2 and close and close[0] != base else None


def nearest(wanted: str, names: Sequence[str]) -> str:
    """What to say of a heading that is missing: those there are, and the most similar."""
    by_plain = {re.sub(r"[\[({].*|[^a-z0-9]", "", name.lower()): name for name in names}
    plain = re.sub("[^a-z0-9]", "", wanted.lower())
    close = difflib.get_close_matches(plain, by_plain, 1, 0.6)
    hint = f"; did you mean {value(by_plain[close[0]])}?" if close else ""
    return f"the headings are {shown(names)}{hint}"
