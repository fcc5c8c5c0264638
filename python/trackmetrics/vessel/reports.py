"""Reports of vessels: a table, one row each, whatever they came from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check, errors
from trackmetrics._tables import times
from trackmetrics._tables.errors import value
from trackmetrics.vessel.settings import MIN_SPEED_FOR_COURSE, OBSERVED, REPORT_TYPES, Floats

NO_SPEED = 102.3
"""What AIS sends for "speed not available" (1023 in steps of 0.1 kt)."""
NO_COURSE = 360.0
"""What AIS sends for "course not available"."""

MAX_DEGREES = {"lat": 90.0, "lon": 360.0}
"""Beyond these a number is no position."""


@dataclass(frozen=True)
class Reports:
    """Reports in the order in which they came.

    >>> Reports.from_columns(time=[0, 10], lat=[50.0, 50.1], lon=[-1, -1], sog=[12, 12],
    ...                      cog=[90.0, 360.0], vessel=["235070762", "235070762"]).kinds
    ('AIS', 'truncated AIS')
    """

    time: Floats
    """Seconds."""
    vessel: NDArray[np.object_]
    """Name or MMSI as text, None for a position without identity."""
    kind: NDArray[np.int64]
    """Index into :data:`REPORT_TYPES`."""
    z: Floats
    """``(n, 4)``: latitude, longitude (deg), speed (kt), course (deg); NaN for what is not used."""

    @classmethod
    def from_columns(
        cls, *, time: Any, lat: Any, lon: Any, sog: Any = None, cog: Any = None, vessel: Any = None
    ) -> "Reports":
        """Reports from columns; each kind follows from what is there.

        Parameters
        ----------
        time : array_like, shape (n,)
            Seconds, or ``datetime64``.
        lat, lon : array_like, shape (n,)
            Degrees; latitudes within 90, longitudes within 360.
        sog, cog : array_like, shape (n,), optional
            Knots and degrees; NaN, speeds below 0 or from 102.3 kt on, and courses below 0 or from
            360 deg on stand for "not available", and such a report counts as truncated AIS.
            Below 1 kt the course is not used.
        vessel : sequence of str or None, optional
            Name or MMSI; reports without one are positions without identity.

        Raises
        ------
        ValueError
            Where lengths differ, or a time or position is not finite or out of range.
        TypeError
            Where a column holds what is no number.
        """
        columns = [_column("time", time, None)]
        n = len(columns[0])
        for name, values in (("lat", lat), ("lon", lon), ("sog", sog), ("cog", cog)):
            columns.append(_column(name, values, n))
        names = _names(vessel, n)
        z = np.stack(columns[1:], axis=1)
        kind = _kinds(z[:, 2], z[:, 3], names != None)  # noqa: E711 - element by element
        z[np.arange(4) >= OBSERVED[kind][:, None]] = np.nan
        return cls(columns[0], names, kind, z)

    @classmethod
    def concatenate(cls, parts: Sequence["Reports"]) -> "Reports":
        """Reports of several tables, one after the other."""
        return cls(
            np.concatenate([np.empty(0), *(p.time for p in parts)]),
            np.concatenate([np.empty(0, object), *(p.vessel for p in parts)]),
            np.concatenate([np.empty(0, np.int64), *(p.kind for p in parts)]),
            np.concatenate([np.empty((0, 4)), *(p.z for p in parts)]),
        )

    def take(self, rows: Any) -> "Reports":
        """These reports."""
        return Reports(self.time[rows], self.vessel[rows], self.kind[rows], self.z[rows])

    def rows_by_vessel(self) -> dict[str | None, NDArray[np.int64]]:
        """The rows of every identity, in their order; identities as they first appear."""
        codes: dict[str | None, int] = {}
        code = np.array([codes.setdefault(v, len(codes)) for v in self.vessel], np.int64)
        order = np.argsort(code, kind="stable")
        bounds = np.searchsorted(code[order], np.arange(1, len(codes)))
        return dict(zip(codes, np.split(order, bounds), strict=False))

    def __len__(self) -> int:
        """How many."""
        return len(self.time)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kind of each, by name."""
        return tuple(REPORT_TYPES[k] for k in self.kind)

    @property
    def vessels(self) -> tuple[str, ...]:
        """Every identity, in the order in which they first appear."""
        return tuple(dict.fromkeys(v for v in self.vessel if v is not None))

    def __repr__(self) -> str:
        """How many of what."""
        return f"Reports({len(self)} reports, {len(self.vessels)} identities)"


def thin(reports: Reports, seconds: float) -> NDArray[np.bool_]:
    """Which reports are used where each vessel reports at most once in so many seconds.

    The others can test the predictions of the filter: see :func:`predictive_nis`.

    >>> reports = Reports.from_columns(time=[0, 30, 60, 90], lat=[0] * 4, lon=[0] * 4,
    ...                                vessel=["a"] * 4)
    >>> thin(reports, 60).tolist()
    [True, False, True, False]
    """
    if not _check.number("seconds", seconds) > 0:
        raise errors.parameter("seconds", "positive", seconds)
    last: dict[Any, float] = {}
    used = np.zeros(len(reports), bool)
    moments: Floats = reports.time
    for k in np.argsort(moments, kind="stable"):
        vessel = reports.vessel[k]
        if moments[k] - last.get(vessel, -np.inf) >= seconds:
            last[vessel], used[k] = float(moments[k]), True
    return used


def _column(name: str, values: Any, n: int | None) -> Floats:
    if values is None:
        return np.full(n or 0, np.nan)
    column = _numbers(name, values)
    if column.ndim != 1:
        raise ValueError(f"{name} has shape {column.shape}, expected (n,)")
    if n is not None and len(column) != n:
        raise ValueError(f"{name} has {len(column)} reports, time has {n}")
    valid, requirement = np.isfinite(column), "finite"
    if name in MAX_DEGREES:
        valid &= np.abs(column) <= MAX_DEGREES[name]
        requirement = f"finite and between -{MAX_DEGREES[name]:g} and {MAX_DEGREES[name]:g}"
    elif name != "time":
        valid, requirement = ~np.isinf(column), "finite, or NaN where it is not available"
    if not valid.all():
        k = int(np.argmin(valid))
        raise errors.element(name, (k,), requirement, column[k])
    return column


def _numbers(name: str, values: Any) -> Floats:
    """A column of numbers, a copy; a masked element is NaN, and dates are seconds since 1970."""
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array = np.asarray(values)
    if name == "time" and array.dtype.kind == "M":
        return np.array(times.to_seconds(array, name).seconds)
    if array.size and array.dtype.kind not in "iuf":
        items = array.ravel().tolist()
        wrong = [item for item in items if not _is_number(item)]
        if wrong:
            raise TypeError(f"{name} must hold real numbers, got {value(wrong[0])}")
        array = np.array([np.nan if v is None else v for v in items]).reshape(array.shape)
    return np.array(array, np.float64)


def _is_number(given: Any) -> bool:
    is_real = isinstance(given, int | float | np.integer | np.floating)
    return given is None or (is_real and not isinstance(given, bool))


def _names(vessel: Any, n: int) -> NDArray[np.object_]:
    names = np.empty(n, object)
    if vessel is not None:
        listed = [vessel] if isinstance(vessel, str) else list(vessel)
        if len(listed) != n:
            raise ValueError(f"vessel has {len(listed)} reports, time has {n}")
        names[:] = [None if v is None or v != v or v == "" else str(v) for v in listed]
    return names


def _kinds(sog: Floats, cog: Floats, named: Any) -> NDArray[np.int64]:
    speed = np.isfinite(sog) & (sog < NO_SPEED) & (sog >= 0)
    course = np.isfinite(cog) & (cog < NO_COURSE) & (cog >= 0)
    moving = np.where(sog < MIN_SPEED_FOR_COURSE, 1, 0)
    kind = np.where(speed & course, moving, 2)
    return np.where(named, kind, 3).astype(np.int64)
