"""The options of every command that reads a log, and how they become arguments of ``read_log``."""

from collections.abc import Callable
from typing import Any

import click

_OPTIONS = (
    click.option(
        "--rename",
        multiple=True,
        metavar="NAME=COLUMN[,COLUMN...]",
        help="The file's name of a column, or the columns of a vector; may be repeated.",
    ),
    click.option("--states", metavar="NAME,NAME,...", help="Names of the states."),
    click.option(
        "--angle",
        multiple=True,
        metavar="STATE=PERIOD",
        help="A state that is an angle, and its period; may be repeated.",
    ),
    click.option("--time", metavar="row", help="Take row numbers as times."),
    click.option("--time-unit", metavar="UNIT", help="Unit of the times, instead of guessing it."),
    click.option(
        "--date-order", type=click.Choice(["dmy", "mdy"]), help="Order of dates such as 01/02/2024."
    ),
    click.option(
        "--covariance",
        multiple=True,
        metavar="NAME=FORM",
        help="How a covariance is given: diagonal, upper or full; may be repeated.",
    ),
    click.option(
        "--on-repeats",
        type=click.Choice(["drop", "keep", "raise"]),
        default="drop",
        help="What to do with rows that are no updates.",
    ),
    click.option("--nis-scale", type=float, default=1.0, help="Gate, for logs of test ratios."),
)


def log_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds the options; the command passes them to :func:`read_log_with`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_log_with(log: str, options: dict[str, Any]) -> Any:
    """The log, read as the options say."""
    from trackmetrics.logs import read_log

    states, angles = options["states"], options["angle"]
    return read_log(
        log,
        columns={name: _names(value) for name, value in map(_pair, options["rename"])} or None,
        states=states.split(",") if states else None,
        angles={name: float(period) for name, period in map(_pair, angles)} or None,
        time=options["time"],
        time_unit=options["time_unit"],
        date_order=options["date_order"],
        covariance_forms=dict(map(_pair, options["covariance"])) or None,
        on_repeats=options["on_repeats"],
        nis_scale=options["nis_scale"],
    )


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"expected NAME=VALUE, got {text!r}")
    return name, value


def _names(value: str) -> Any:
    return value.split(",") if "," in value else value
