"""What a log says once, for all rows: its states, their units and angles."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

SCHEMA = "trackmetrics-log/1"
"""Name of the form of a log in a file."""


@dataclass(frozen=True)
class State:
    """A state of the estimator, by name."""

    name: str
    """Its name."""
    unit: str = ""
    """Its unit; empty where nobody said."""
    period: float | None = None
    """The period of an angle in that unit (360 for degrees), None for what is not an angle."""


@dataclass(frozen=True)
class Header:
    """What a log says once, for all rows."""

    states: Sequence[State | str] | None = None
    state_dim: int | None = None
    angles: Mapping[str | int, float] | None = None
    measurement_angles: Mapping[str, Mapping[int, float]] | None = None
    time_unit: str = "s"
