"""The command line: ``trackmetrics COMMAND ...``.

Each command is a module of this package with a click command named ``command``; it is imported
only when it is called. The command line needs the extra ``cli`` (click and rich).

Exit statuses: 0, done; 1, a check that was asked for failed; 2, bad input; 130, interrupted.
"""

import sys
from collections.abc import Sequence

from trackmetrics.cli._commands import EXTRAS, missing_library

__all__ = ["main"]


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
