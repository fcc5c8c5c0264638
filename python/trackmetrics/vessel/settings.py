"""What the estimator assumes: its states, how well things are measured, how a vessel moves."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, _deprecated, errors
from trackmetrics._tables.errors import value
from trackmetrics.logs import State

Floats = NDArray[np.float64]

STATES = (
    State("lat", "deg"),
    State("lon", "deg", 360.0),
    State("sog", "kt"),
    State("cog", "deg", 360.0),
    State("turn_rate", "deg/s"),
)
"""The five states: latitude, longitude, speed and course over ground, turn rate."""

REPORT_TYPES = ("AIS", "AIS without course", "truncated AIS", "position")
"""The types of report; a report has the index of its type."""
AIS, AIS_WITHOUT_COURSE, TRUNCATED_AIS, POSITION = range(len(REPORT_TYPES))

OBSERVED = np.array([4, 3, 2, 2], np.int64)
"""How many of the leading states each type of report measures."""

MIN_SPEED_FOR_COURSE = 1.0
"""Speed in knots below which a course over ground is not used."""


def _require(name: str, value: Any, requirement: str, *, finite: bool = True) -> None:
    """Refuse what is no number, and numbers outside the range that the requirement names."""
    if isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be a real number, got {value!r}")
    number = _check.number(name, value)
    above = number >= 0 if requirement == "at least 0" else number > 0
    if not above or (finite and number == np.inf):
        raise errors.parameter(name, requirement + " and finite" * finite, number)


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one kind of report."""

    position: float
    """Of the position, in metres, in each direction."""
    speed: float = 1.0
    """Of the speed, in knots; not used where the kind has none."""
    course: float = 5.0
    """Of the course, in degrees; not used where the kind has none."""

    def __post_init__(self) -> None:
        """Refuse what is not positive."""
        for f in fields(self):
            _require(f.name, getattr(self, f.name), "positive")


@_deprecated.parameters_of_class(
    tentative="num_tentative",  # _deprecated.
    placeholders="trust_missing_values",  # _deprecated.
    gate="gate_probability",  # _deprecated.
)
@dataclass(frozen=True)
class Settings:
    """What a filter assumes. The defaults are consistent for a cargo ship at sea with good AIS.

    AIS position accuracy flag 1 stands for better than 10 m; speed comes in steps of 0.1 kt, course
    in steps of 0.1 deg (ITU-R M.1371-5, messages 1 to 3).

    >>> Settings(turn_density=1e-7).motion
    (0.0001, 1e-07, 0.0, inf)
    """

    ais: Noise = Noise(10.0, 0.3, 1.5)
    """Of AIS reports with speed, with or without course."""
    truncated_ais: Noise = Noise(30.0)
    """Of AIS reports of which only the position is used."""
    position: Noise = Noise(60.0)
    """Of positions from another sensor."""
    acceleration_density: float = 1e-4
    """Power spectral density of the acceleration along the track, m^2/s^3."""
    turn_density: float = 2e-9
    """Power spectral density of the turn acceleration, (deg/s)^2/s."""
    course_density: float = 0.0
    """Power spectral density of a random walk of the course, deg^2/s."""
    turn_rate_decay: float = np.inf
    """Time constant with which a turn rate decays, in seconds; infinite: it stays."""
    turn_rate_std: float = 0.02
    """Standard deviation of the turn rate of a new track, deg/s."""
    num_tentative: int = 2
    """Number of first reports during which a track is tentative and has no NIS."""
    trust_missing_values: bool = False
    """Whether a new track takes an unknown speed for 0 kt and an unknown course for 360 deg, with
    the variances of measured ones."""
    coast_after: float = 600.0
    """After how many seconds without a report a track coasts."""
    delete_after: float = 3600.0
    """After how many seconds without a report a track ends."""
    max_speed: float = 60.0
    """Speed in knots that no vessel has."""
    gate_probability: float = 0.999
    """Probability that a position of a track falls into its gate."""

    tentative = _deprecated.attribute("num_tentative")
    placeholders = _deprecated.attribute("trust_missing_values")
    gate = _deprecated.attribute("gate_probability")

    def __post_init__(self) -> None:
        """Refuse what no filter can run with."""
        for name in ("ais", "truncated_ais", "position"):
            if not isinstance(getattr(self, name), Noise):
                raise TypeError(f"{name} must be a Noise, got {value(getattr(self, name))}")
        for name in ("acceleration_density", "turn_density", "course_density"):
            _require(name, getattr(self, name), "at least 0")
        for name in ("turn_rate_decay", "coast_after", "delete_after"):
            _require(name, getattr(self, name), "positive", finite=False)
        for name in ("turn_rate_std", "max_speed", "gate_probability"):
            _require(name, getattr(self, name), "positive")
        if not self.gate_probability < 1:
            raise errors.parameter("gate_probability", "between 0 and 1", self.gate_probability)
        if isinstance(self.num_tentative, bool | np.bool_):
            raise TypeError(f"num_tentative must be a whole number, got {self.num_tentative!r}")
        _check.count("num_tentative", self.num_tentative, 1)
        if not isinstance(self.trust_missing_values, bool | np.bool_):
            given = value(self.trust_missing_values)
            raise TypeError(f"trust_missing_values must be True or False, got {given}")

    @classmethod
    def harbour(cls) -> "Settings":
        """For traffic that manoeuvres: ferries, pilots, yachts.

        Turn rates decay within half a minute. The densities are those with which the median vessel
        under way of an hour of AIS from the Solent, one report a minute, has a NIS as claimed; no
        one setting is consistent for a tanker and for a hovercraft.
        """
        return cls(
            ais=Noise(10.0, 0.3, 3.0),
            acceleration_density=1e-2,
            turn_density=1e-2,
            turn_rate_decay=30.0,
            turn_rate_std=0.1,
        )

    @property
    def motion(self) -> tuple[float, float, float, float]:
        """The motion as kernels take it."""
        along, turn = float(self.acceleration_density), float(self.turn_density)
        return along, turn, float(self.course_density), float(self.turn_rate_decay)

    @property
    def rules(self) -> tuple[int, float, bool, float]:
        """The rules of a track's life as kernels take them."""
        start = (
            int(self.num_tentative),
            float(self.turn_rate_std),
            bool(self.trust_missing_values),
        )
        return (*start, float(self.delete_after))

    @property
    def sigmas(self) -> Floats:
        """``(4, 3)``: position, speed and course deviation of each kind."""
        noises = (self.ais, self.ais, self.truncated_ais, self.position)
        return np.array([[n.position, n.speed, n.course] for n in noises])
