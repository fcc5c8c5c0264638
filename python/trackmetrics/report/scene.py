"""What a figure shows, before any library draws it: panels with marks, in pixels and data units.

Both backends draw the same :class:`Scene`; so a figure on paper and the page in the browser cannot
tell different stories. Colours are roles of :mod:`trackmetrics.report.theme`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def floats(values: Any) -> Floats:
    """Values as one array of numbers; None is NaN."""
    return np.asarray(values, np.float64).ravel()


@dataclass(frozen=True)
class Line:
    """A line through points; NaN breaks it."""

    x: Floats
    y: Floats
    colour: str
    width: float = 1.6
    dash: str = "solid"
    name: str = ""
    """What it is; shown when one points at it, and in the legend of a panel that has one."""
    steps: bool = False
    """Whether a value holds until the next one."""


@dataclass(frozen=True)
class Points:
    """Points of one symbol."""

    x: Floats
    y: Floats
    colour: str
    symbol: str = "circle"
    hollow: bool = False
    size: float = 6.0
    name: str = ""


@dataclass(frozen=True)
class Band:
    """A band between two lines."""

    x: Floats
    low: Floats
    high: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True)
class Bars:
    """A vertical interval at each point."""

    x: Floats
    low: Floats
    high: Floats
    colour: str
    width: float = 4.0
    name: str = ""


@dataclass(frozen=True)
class Boxes:
    """Rectangles from ``left`` to ``right`` and ``low`` to ``high``."""

    left: Floats
    right: Floats
    low: Floats
    high: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True)
class Level:
    """A line across the panel at one value, or a band to a second one."""

    y: float
    colour: str
    top: float | None = None
    dash: str = "solid"


@dataclass(frozen=True)
class Event:
    """A moment: a vertical line, named at its top."""

    x: float
    label: str
    colour: str
    dash: str = "dot"
    row: int = 0
    """How many lines below the top its name stands, so that names do not collide."""
    left: bool = False
    """Whether its name stands to the left of the line."""


@dataclass(frozen=True)
class Text:
    """A few words at a point."""

    x: float
    y: float
    text: str
    colour: str
    anchor: str = "left"
    """``"left"``, ``"center"`` or ``"right"``: the part of the words that stands at ``x``."""
    above: bool = False
    """Whether the words stand above the point instead of beside it."""
    bold: bool = False


Mark = Line | Points | Band | Bars | Boxes | Level | Event | Text


@dataclass(frozen=True)
class Rectangle:
    """A place in a figure, in pixels from its upper left corner."""

    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    place: Rectangle
    marks: tuple[Mark, ...]
    title: str = ""
    x_label: str = ""
    y_label: str = ""
    log: bool = False
    """Whether the y axis is logarithmic."""
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] | None = None
    """Values of the y axis that have a name, for an axis of names."""
    x_ticks: tuple[tuple[float, str], ...] | None = None
    """The same for the x axis."""
    legend: bool = False
    """Whether the named lines and bands are listed."""
    linked: bool = True
    """Whether its x axis moves with those of the other panels."""
    x_unit: str = "min"
    """Unit of the x axis, for what one points at."""


@dataclass(frozen=True)
class Heading:
    """Words above a column of panels."""

    left: float
    top: float
    text: str


@dataclass(frozen=True)
class Scene:
    """A figure."""

    width: float
    height: float
    panels: tuple[Panel, ...]
    title: str = ""
    subtitle: str = ""
    headings: tuple[Heading, ...] = ()
