"""Description of a figure: panels with drawing primitives, in pixels and data units.

Both backends draw the same :class:`Scene`. Colours are roles of :mod:`trackmetrics.report.theme`.
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
    """Its label, for the hover text and for the legend of a panel that has one."""
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
    rows: NDArray[np.bool_] | None = None
    """Which of the points are drawn; None for all. So groups of points share their arrays."""

    def drawn(self) -> tuple[Floats, Floats]:
        """The coordinates of the points that are drawn."""
        return (self.x, self.y) if self.rows is None else (self.x[self.rows], self.y[self.rows])


@dataclass(frozen=True)
class Band:
    """A band between two lines."""

    x: Floats
    low: Floats
    high: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True)
class StdBand:
    """A band of ``factor`` times ``std`` on both sides of a line, on a linear axis."""

    x: Floats
    centre: Floats
    std: Floats
    factor: float
    colour: str
    name: str = ""

    @property
    def low(self) -> Floats:
        """The lower side."""
        return self.centre - self.factor * self.std

    @property
    def high(self) -> Floats:
        """The upper side."""
        return self.centre + self.factor * self.std


@dataclass(frozen=True)
class ErrorBars:
    """A vertical interval at each point."""

    x: Floats
    low: Floats
    high: Floats
    colour: str
    width: float = 4.0
    name: str = ""


@dataclass(frozen=True)
class Rects:
    """Rectangles from ``left`` to ``right`` and ``low`` to ``high``."""

    left: Floats
    right: Floats
    low: Floats
    high: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True)
class HLine:
    """A line across the panel at one value, or a band to a second one."""

    y: float
    colour: str
    top: float | None = None
    dash: str = "solid"


@dataclass(frozen=True)
class Event:
    """An event: a vertical line with a label at its top."""

    x: float
    label: str
    colour: str
    dash: str = "dot"
    row: int = 0
    """How many text lines below the top its label is placed, so that labels do not overlap."""
    left: bool = False
    """Whether its label is placed left of the line."""


@dataclass(frozen=True)
class Text:
    """A text at a point."""

    x: float
    y: float
    text: str
    colour: str
    anchor: str = "left"
    """``"left"``, ``"center"`` or ``"right"``: the part of the text that is placed at ``x``."""
    above: bool = False
    """Whether the text is placed above the point instead of beside it."""
    bold: bool = False


Primitive = Line | Points | Band | StdBand | ErrorBars | Rects | HLine | Event | Text


@dataclass(frozen=True)
class Bounds:
    """A bounds in a figure, in pixels from its upper left corner."""

    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    bounds: Bounds
    primitives: tuple[Primitive, ...]
    title: str = ""
    x_label: str = ""
    y_label: str = ""
    log: bool = False
    """Whether the y axis is logarithmic."""
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] | None = None
    """Values of the y axis with their labels; None chooses them."""
    x_ticks: tuple[tuple[float, str], ...] | None = None
    """The same for the x axis."""
    legend: bool = False
    """Whether the named lines and bands are listed."""
    linked: bool = True
    """Whether its x axis moves with those of the other panels."""
    x_unit: str = "min"
    """Unit of the x axis, for hover texts."""


@dataclass(frozen=True)
class Heading:
    """A text above a column of panels."""

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
