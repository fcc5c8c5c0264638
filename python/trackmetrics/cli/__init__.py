"""The command line: ``trackmetrics COMMAND ...``.

Each command is a module of this package with a click command named ``command``; it is imported
only when it is called. The command line needs the extra ``cli`` (click and rich).

Exit statuses: 0, done; 1, a check that was asked for failed; 2, bad input; 130, interrupted.
"""

import sys
from collections.abc import Sequence

COMMANDS: dict[str, str] = {
    "demo": "simulate, track and diagnose three ships",
    "diagnose": "test whether an estimator is consistent",
    "score": "score the boxes of a tracker against the truth",
    "sweep": "run a Monte Carlo sweep, and test its filter",
    "vessel": "track the vessels of a recording of AIS, and diagnose",
    "completion": "print the completion script of a shell",
}
"""Each command and what it does."""

EXTRAS = {
    "click": "cli",
    "jinja2": "report",
    "matplotlib": "report",
    "narwhals": "frames",
    "plotly": "report",
    "polars": "frames",
    "pyais": "ais",
    "pyarrow": "parquet",
    "rich": "cli",
}
"""The extra that installs a library."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        from trackmetrics.cli._main import run
    except ModuleNotFoundError as error:
        if error.name not in EXTRAS:
            raise
        print(f"trackmetrics: {missing_library(error.name)}", file=sys.stderr)
        return 2
    return run(given)


def missing_library(name: str) -> str:
    """Says which extra installs a library."""
    extra = EXTRAS[name]
    return f"needs {name}, from the extra {extra} (pip install 'trackmetrics[{extra}]')"
