"""The command line: ``trackmetrics COMMAND ...``.

Each command is a module of this package with a ``HELP`` line, ``add_arguments(parser)`` and
``run(arguments)``, which returns the exit status. It is imported only when it is called for.
Bad input ends with one line on standard error and exit status 2.
"""

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module

from trackmetrics._version import __version__

COMMANDS: dict[str, str] = {
    "demo": "simulate, track and judge: three ships and their filter, or targets and their scores",
    "diagnose": "say whether a filter is honest, since when, and which state fails",
    "score": "score the boxes of a tracker against the truth (MOTChallenge files)",
    "sweep": "run a simulation many times over a grid of settings, and judge its filter",
    "vessel": "run the vessel estimator over a recording of AIS, and diagnose it",
}
"""Each command and what it does."""

EXTRAS = {
    "jinja2": "report",
    "matplotlib": "report",
    "plotly": "report",
    "pyais": "ais",
    "pyarrow": "parquet",
}
"""The extra that a library comes with."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(
        prog="trackmetrics",
        description="Metrics and consistency diagnostics for tracking and state estimation.",
    )
    parser.add_argument("--version", action="version", version=f"trackmetrics {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, meaning in COMMANDS.items():
        command = commands.add_parser(name, help=meaning, description=f"{meaning.capitalize()}.")
        if name in words[:1]:
            import_module(f"{__name__}.{name}").add_arguments(command)
    parsed = parser.parse_args(words)
    try:
        return int(import_module(f"{__name__}.{parsed.command}").run(parsed))
    except (ValueError, TypeError, OSError, ImportError) as error:
        print(f"trackmetrics {parsed.command}: {_words(error)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _words(error: Exception) -> str:
    """What went wrong; of a file that cannot be used, which one and why; of a library that is not
    installed, what installs it."""
    if isinstance(error, ModuleNotFoundError) and (error.name or "") in EXTRAS:
        extra = EXTRAS[error.name or ""]
        return f"needs {error.name}, from the extra {extra} (pip install 'trackmetrics[{extra}]')"
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return str(error)
