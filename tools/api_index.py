"""Writes docs/api.md: every public name, its package and the first sentence of its documentation.

python tools/api_index.py [--check]
"""

import inspect
import sys
from importlib import import_module
from pathlib import Path

from trackmetrics._deprecated import RENAMED

PAGE = Path(__file__).resolve().parents[1] / "docs/api.md"
PACKAGES = ("", "consistency", "point_sets", "trajectories", "tracking", "tracks", "logs")
PACKAGES += ("diagnostics", "monte_carlo", "vessel", "report")
HEAD = """# Every public name

Made from the documentation of the code by `python tools/api_index.py`; `help(name)` shows more.
Names of the top level are not repeated below it.
"""


def first_sentence(value):
    """The first sentence of an object's documentation."""
    text = " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split())
    return text.replace("|", "\\|")


def section(package, seen):
    """The table of a package's names."""
    module = import_module(".".join(filter(None, ("trackmetrics", package))))
    rows = []
    for name in module.__all__:
        if f"{module.__name__}.{name}" in RENAMED:
            continue
        value = getattr(module, name)
        if name.startswith("_") or id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, (tuple, dict, str)):
            rows.append(f"| `{name}` | constant |")
        else:
            rows.append(f"| `{name}` | {first_sentence(value)} |")
    if not rows:
        return ""
    return (
        f"\n## `{module.__name__}`\n\n| name | what it is |\n| --- | --- |\n"
        + "\n".join(rows)
        + "\n"
    )


def page():
    """The text of the page."""
    seen = set()
    return HEAD + "".join(section(package, seen) for package in PACKAGES)


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(0 if PAGE.read_text(encoding="utf-8") == page() else "docs/api.md is out of date")
    PAGE.write_text(page(), encoding="utf-8")
