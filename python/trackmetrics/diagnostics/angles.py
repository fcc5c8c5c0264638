"""Angles that were not wrapped, and courses in radians that are declared in degrees.

A logged innovation of an angle beyond half its period may be a bug of the filter or of the logging.
It is a bug of the filter if the logged NIS is that of the unwrapped innovation; of the logging if
the NIS is that of the wrapped one; without NIS or S it is suspected. Innovations that were computed
here prove nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics._angles import wrap
from trackmetrics._covariances import quadratic_forms
from trackmetrics.diagnostics.thresholds import MIN_STEPS_FOR_COURSE, NIS_MATCH_TOLERANCE
from trackmetrics.logs.columns import Columns, Floats
from trackmetrics.logs.log import EstimatorLog


@dataclass(frozen=True)
class WrappingCheck:
    """Logged innovations beyond half a period: which rows of the log, by what they prove."""

    proven: NDArray[np.bool_]
    """The logged NIS is that of the unwrapped residual."""
    harmless: NDArray[np.bool_]
    """The logged NIS is that of the wrapped one."""
    suspected: NDArray[np.bool_]
    """There is no NIS or no S to tell by, or the NIS is neither."""

    def of(self, rows: slice) -> "WrappingCheck":
        """The check of some rows."""
        return WrappingCheck(self.proven[rows], self.harmless[rows], self.suspected[rows])


def check_wrapping(log: EstimatorLog, periods: Floats | None) -> WrappingCheck | None:
    """Checks the innovations of every row against their periods; None if none is beyond half."""
    columns = log.columns
    if columns.innovation is None or periods is None:
        return None
    beyond = np.abs(columns.innovation) > periods / 2 * (1 + 1e-9)
    rows = beyond.any(axis=1) & log.was_logged("innovation")
    if not rows.any():
        return None
    none = np.zeros(len(log), bool)
    if columns.S is None or columns.nis is None:
        return WrappingCheck(none, none, rows)
    telling = rows & log.was_logged("nis")
    raw = quadratic_forms(columns.innovation, columns.S)
    proper = quadratic_forms(wrap(columns.innovation, periods), columns.S)
    proven = telling & _close(columns.nis, raw) & ~_close(columns.nis, proper)
    harmless = telling & _close(columns.nis, proper)
    return WrappingCheck(proven, harmless, rows & ~proven & ~harmless)


def _close(a: Floats, b: Floats) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        close: NDArray[np.bool_] = np.abs(a - b) <= NIS_MATCH_TOLERANCE * np.maximum(1.0, np.abs(b))
    return close


_POSITIONS = (
    ({"lat", "latitude"}, {"lon", "lng", "long", "longitude"}),
    ({"north", "n", "northing"}, {"east", "e", "easting"}),
    ({"y", "py", "pos_y", "y_pos"}, {"x", "px", "pos_x", "x_pos"}),
)


def find_radian_headings(log: EstimatorLog) -> tuple[str, ...]:
    """Warnings for courses that are declared in degrees and logged in radians.

    Only where all values lie within 2 pi of 0, and the course over the positions agrees with them
    as radians and not as degrees.
    """
    place = _positions([name.lower() for name in log.state_names])
    if place is None or log.columns.x is None:
        return ()
    warnings = []
    for i, state in enumerate(log.states):
        if state.period == 360.0 and i not in place:
            courses = log.columns.x[:, i]
            small = np.nanmax(np.abs(courses), initial=0.0) <= 2 * np.pi
            if small and _agrees(log, i, place):
                warnings.append(
                    f"{state.name} is declared in degrees, but its values look like radians: "
                    "they agree with the course over the positions as radians only."
                )
    return tuple(warnings)


def _positions(names: Sequence[str]) -> tuple[int, int] | None:
    """The states that hold north and east."""
    for north, east in _POSITIONS:
        found = [[i for i, name in enumerate(names) if name in words] for words in (north, east)]
        if found[0] and found[1]:
            return found[0][0], found[1][0]
    return None


def _agrees(log: EstimatorLog, course: int, place: tuple[int, int]) -> bool:
    over_ground, logged = _courses(log, course, place)
    if len(logged) < MIN_STEPS_FOR_COURSE:
        return False
    # A course may count from north clockwise or from east the other way.
    for reference in (over_ground, np.pi / 2 - over_ground):
        as_radians = np.cos(reference - logged).mean()
        as_degrees = np.cos(reference - np.radians(logged)).mean()
        if as_radians > np.cos(np.radians(20)) and as_degrees < np.cos(np.radians(45)):
            return True
    return False


def _courses(log: EstimatorLog, course: int, place: tuple[int, int]) -> tuple[Floats, Floats]:
    """Course over ground in radians from north between updates, and the course logged there."""
    over_ground, logged = [], []
    latitude = log.state_names[place[0]].lower().startswith("lat")
    for track in log.tracks:
        x = _complete(log[track], [*place, course])
        north, east = np.diff(x[:, place[0]]), np.diff(x[:, place[1]])
        if latitude:
            east = east * np.cos(np.radians(x[1:, place[0]]))
        moved = np.hypot(north, east) > 0
        over_ground.append(np.arctan2(east, north)[moved])
        logged.append(x[1:, course][moved])
    return np.concatenate(over_ground), np.concatenate(logged)


def _complete(columns: Columns, states: Sequence[int]) -> Floats:
    """The rows in which these states are known."""
    x = columns.x
    assert x is not None
    complete: Floats = x[~np.isnan(x[:, states]).any(axis=1)]
    return complete
