"""Old names of options: still accepted, with a warning on standard error."""

import sys

from trackmetrics import _deprecated

OPTIONS: dict[str, dict[str, str]] = {
    "diagnose": {"--column": "--rename", "--check": "--fail-on-inconsistent"},
    "sweep": {"--collect": "--keep-going", "--best": "--rank-by", "--chunk": "--chunk-size"},
    "vessel": {
        "--decimate": "--thin",
        "--least": "--min-reports",
        "--moving": "--min-speed",
        "--settings": "--preset",
    },
}
"""For each command its old options and their new names."""

VALUES: dict[str, dict[str, dict[str, str]]] = {
    "demo": {"--noise": _deprecated.RENAMED_NOISE},
    "vessel": {"--preset": {"sea": "open-sea"}},
}
"""For each command and option its old values and their new names."""


def with_new_names(command: str, arguments: list[str]) -> list[str]:
    """The arguments of a command with old options and values replaced by the new ones."""
    options, values = OPTIONS.get(command, {}), VALUES.get(command, {})
    renamed: list[str] = []
    previous = ""
    for argument in arguments:
        option, equals, value = argument.partition("=")
        if option in options:
            _warn(command, option, options[option])
            option = options[option]
        if equals:
            value = _new_value(command, option, value, values)
            renamed.append(f"{option}={value}")
        else:
            renamed.append(_new_value(command, previous, option, values))
        previous = option
    return renamed


def _new_value(command: str, option: str, value: str, values: dict[str, dict[str, str]]) -> str:
    new = values.get(option, {}).get(value, value)
    if new != value:
        _warn(command, f"{option} {value}", f"{option} {new}")
    return new


def _warn(command: str, old: str, new: str) -> None:
    print(f"trackmetrics {command}: {old} is now {new}", file=sys.stderr)
