"""The commands, and the extras that install the libraries that they need."""

COMMANDS: dict[str, str] = {
    "demo": "simulate, track and diagnose three ships",
    "diagnose": "test whether an estimator is consistent",
    "tune": "estimate what the noises of an estimator should be",
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
    "pandas": "pandas",
    "plotly": "report",
    "polars": "files",
    "pyais": "ais",
    "pyulog": "px4",
    "rich": "cli",
}
"""The extra that installs a library."""


def missing_library(name: str) -> str:
    """Says which extra installs a library."""
    extra = EXTRAS[name]
    return f"needs {name}, from the extra {extra} (pip install 'trackmetrics[{extra}]')"
