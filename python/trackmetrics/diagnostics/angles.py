"""Angles that were not wrapped, and degrees that are radians: what counts as evidence.

A residual of a course beyond 180 degrees in the log may be a bug of the filter or of the logging.
It is a bug where the logged NIS is that of the unwrapped residual; where the NIS is that of the
wrapped one only the log is at fault; without NIS or S there is a suspicion. Innovations that were
computed here are no evidence of anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs.columns import Columns, Floats
from trackmetrics.logs.derived import quadratic_forms, wrapped
from trackmetrics.logs.log import EstimatorLog

MATCH = 1e-6
LEAST_STEPS = 5


@dataclass(frozen=True)
class Unwrapped:
    """Logged innovations beyond half a period: rows of the log by what they prove."""

    proven: NDArray[np.bool_]
    """The logged NIS is that of the unwrapped residual."""
    harmless: NDArray[np.bool_]
    """The logged NIS is that of the wrapped one."""
    suspected: NDArray[np.bool_]
    """There is no NIS or no S to tell by, or the NIS is neither."""

    def of(self, rows: slice) -> "Unwrapped":
        """Those of some rows."""
        return Unwrapped(self.proven[rows], self.harmless[rows], self.suspected[rows])


def unwrapped(log: EstimatorLog, periods: Floats | None) -> Unwrapped | None:
    """Every row of the log, held against its innovation's periods; None if no row is beyond."""
    columns = log.columns
    if columns.innovation is None or periods is None:
        return None
    beyond = np.abs(columns.innovation) > periods / 2 * (1 + 1e-9)
    rows = beyond.any(axis=1) & log.was_logged("innovation")
    if not rows.any():
        return None
    none = np.zeros(len(log), bool)
    if columns.S is None or columns.nis is None:
        return Unwrapped(none, none, rows)
    telling = rows & log.was_logged("nis")
    raw = quadratic_forms(columns.innovation, columns.S)
    proper = quadratic_forms(wrapped(columns.innovation, periods), columns.S)
    proven = telling & _close(columns.nis, raw) & ~_close(columns.nis, proper)
    harmless = telling & _close(columns.nis, proper)
    return Unwrapped(proven, harmless, rows & ~proven & ~harmless)


def _close(a: Floats, b: Floats) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        close: NDArray[np.bool_] = np.abs(a - b) <= MATCH * np.maximum(1.0, np.abs(b))
    return close


_POSITIONS = (
    ({"lat", "latitude"}, {"lon", "lng", "long", "longitude"}),
    ({"north", "n", "northing"}, {"east", "e", "easting"}),
    ({"y", "py", "pos_y", "y_pos"}, {"x", "px", "pos_x", "x_pos"}),
)


def radians_in_degrees(log: EstimatorLog) -> tuple[str, ...]:
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
    over_ground, said = _courses(log, course, place)
    if len(said) < LEAST_STEPS:
        return False
    # A course may count from north clockwise or from east the other way.
    for reference in (over_ground, np.pi / 2 - over_ground):
        as_radians = np.cos(reference - said).mean()
        as_degrees = np.cos(reference - np.radians(said)).mean()
        if as_radians > np.cos(np.radians(20)) and as_degrees < np.cos(np.radians(45)):
            return True
    return False


def _courses(log: EstimatorLog, course: int, place: tuple[int, int]) -> tuple[Floats, Floats]:
    """Course over ground in radians from north between updates, and the course logged there."""
    over_ground, said = [], []
    latitude = log.state_names[place[0]].lower().startswith("lat")
    for track in log.tracks:
        x = _complete(log[track], [*place, course])
        north, east = np.diff(x[:, place[0]]), np.diff(x[:, place[1]])
        if latitude:
            east = east * np.cos(np.radians(x[1:, place[0]]))
        moved = np.hypot(north, east) > 0
        over_ground.append(np.arctan2(east, north)[moved])
        said.append(x[1:, course][moved])
    return np.concatenate(over_ground), np.concatenate(said)


def _complete(columns: Columns, states: Sequence[int]) -> Floats:
    """The rows in which these states are known."""
    x = columns.x
    assert x is not None
    complete: Floats = x[~np.isnan(x[:, states]).any(axis=1)]
    return complete
