"""Finds and runs a command; turns its errors into one line on standard error and a status."""

import os
import sys
from importlib import import_module
from typing import Any

import click

from trackmetrics._version import __version__
from trackmetrics.cli._commands import COMMANDS, EXTRAS, missing_library
from trackmetrics.cli._renamed_options import with_new_names

_STATUSES = """\b
Exit statuses:
  0    done
  1    a check that was asked for failed (--fail-on-inconsistent)
  2    bad input: one line on standard error says what is wrong
  130  interrupted (Ctrl-C)
"""


class Commands(click.Group):
    """The commands, each imported only when it is called."""

    def list_commands(self, context: click.Context) -> list[str]:
        """The names of the commands."""
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        """The command of this name."""
        if name not in COMMANDS:
            return None
        command: click.Command = import_module(f"trackmetrics.cli.{name}").command
        command.short_help = COMMANDS[name]
        return command

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """The list of the commands, without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(
    cls=Commands,
    epilog=_STATUSES,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="trackmetrics %(version)s")
def trackmetrics() -> None:
    """Metrics and consistency diagnostics for tracking and state estimation.

    `trackmetrics COMMAND --help` describes a command and shows examples.
    """


def run(arguments: list[str]) -> int:
    """Run the command that the arguments name, and return its exit status."""
    command = next((word for word in arguments if word in COMMANDS), "")
    name = f"trackmetrics {command}".strip()
    debug = {"-v", "--verbose"} & set(arguments)
    try:
        words = with_new_names(command, arguments)
        status = trackmetrics.main(words, prog_name="trackmetrics", standalone_mode=False)
        return status if isinstance(status, int) else 0
    except click.ClickException as error:
        return _fail(name, error.format_message())
    except (KeyboardInterrupt, click.Abort):
        print(f"{name}: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of a pipe has closed it (`| head`); keep Python from complaining at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, TypeError, OSError, ImportError, KeyError) as error:
        if debug:
            import traceback

            traceback.print_exc()
        return _fail(name, _message(error))


def _fail(name: str, message: str) -> int:
    print(f"{name}: {message}", file=sys.stderr)
    return 2


def _message(error: Exception) -> Any:
    """What is wrong: for a file its name, for a missing library the extra that installs it."""
    if isinstance(error, ModuleNotFoundError) and (error.name or "") in EXTRAS:
        return missing_library(error.name or "")
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, KeyError) and error.args:
        return error.args[0]
    return str(error) or type(error).__name__
