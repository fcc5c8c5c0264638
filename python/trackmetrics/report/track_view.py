"""One track prepared for drawing: its rows, states, time axis, colour and symbols."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from trackmetrics.diagnostics import Diagnosis, QuantityVerdict, Segment, TrackDiagnosis
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.logs import EstimatorLog, State
from trackmetrics.logs.columns import Columns, rows_missing_components
from trackmetrics.report.scene import Floats, floats
from trackmetrics.report.theme import TrackStyle, track_styles

SYMBOLS = (
    "square",
    "circle",
    "diamond",
    "triangle-up",
    "cross",
    "triangle-down",
    "pentagon",
    "star",
)
_MINUTE = {"s": 60.0, "ms": 6e4, "us": 6e7, "ns": 6e10, "min": 1.0, "h": 1 / 60, "d": 1 / 1440}


@dataclass(frozen=True)
class Clock:
    """Turns the times of a log into minutes since its first update; an unknown unit stays."""

    origin: float
    """Time of the first update of any track."""
    minute: float
    """How many units of time one minute has."""
    label: str = "minutes since start"
    """Label of the time axis."""
    unit: str = "min"
    """Unit of the times since the start."""

    def __call__(self, times: Any) -> Floats:
        """Minutes since the start."""
        return (floats(times) - self.origin) / self.minute

    def at(self, time: float) -> float:
        """One time in minutes since the start."""
        return float(self(time)[0])


@dataclass(frozen=True)
class TrackView:
    """One track and what its figures need."""

    track: TrackDiagnosis
    style: TrackStyle
    clock: Clock
    span: tuple[float, float]
    """First and last minute of any track: the same axis for all."""
    states: tuple[State, ...] = ()
    rows: Columns | None = None
    symbols: Mapping[str | None, str] | None = None

    @cached_property
    def minutes(self) -> Floats:
        """Times of the updates in minutes since the start."""
        return np.empty(0) if self.rows is None else self.clock(self.rows.time)

    @property
    def x_limits(self) -> tuple[float, float]:
        """Limits of the time axis."""
        margin = 0.03 * (self.span[1] - self.span[0])
        return self.span[0] - margin, self.span[1] + margin

    def quantities(self) -> list[QuantityVerdict]:
        """The verdicts of NIS and NEES of which there are values; NIS if there are none."""
        found = [q for q in (self.track.nis, self.track.nees) if q is not None and q.updates]
        return found or [self.track.nis]

    def segments(self, quantity: str) -> tuple[Segment, ...]:
        """The segments of NIS or NEES."""
        return next((v.segments for v in self.quantities() if v.quantity == quantity), ())

    def per_dof(self, quantity: str) -> tuple[Floats, Floats]:
        """NIS or NEES of each update over its degrees of freedom, and these."""
        return self._per_dof[quantity]

    @cached_property
    def _per_dof(self) -> dict[str, tuple[Floats, Floats]]:
        return {quantity: self._divided(quantity) for quantity in ("nis", "nees")}

    def _divided(self, quantity: str) -> tuple[Floats, Floats]:
        values = self.column(quantity)
        if values is None:
            missing = np.full(len(self.minutes), np.nan)
            return missing, missing
        own = self.column(f"{quantity}_dof")
        dof = np.full(len(values), np.nan) if own is None else own
        dof = np.where(np.isfinite(values), dof, np.nan)
        return values / dof, dof

    def column(self, name: str) -> Floats | None:
        """A column of the log, None where it is absent or holds nothing."""
        if name not in self._columns:
            values = None if self.rows is None else getattr(self.rows, name)
            known = values is not None and bool(np.isfinite(values).any())
            self._columns[name] = values if known else None
        return self._columns[name]

    def state_column(self, name: str, state: int) -> Floats | None:
        """One state's column of the log, None where it is absent or holds nothing."""
        key = f"{name} {state}"
        if key not in self._columns:
            values = self.column(name)
            of_state = None if values is None else floats(values[:, state])
            known = of_state is not None and bool(np.isfinite(of_state).any())
            self._columns[key] = of_state if known else None
        return self._columns[key]

    @cached_property
    def _columns(self) -> dict[str, Floats | None]:
        """The columns that were asked for."""
        return {}

    def by_measurement_type(self) -> list[tuple[str, str, bool, Any]]:
        """Groups of rows by type and status: name, symbol, whether tentative, mask of rows."""
        return self._groups

    def groups_of(self, values: Floats) -> list[tuple[str, str, bool, Any]]:
        """As :meth:`by_measurement_type`, restricted to the rows in which ``values`` are finite."""
        known = np.isfinite(values)
        if known.all():
            return self._groups
        found = [(*group, rows & known) for *group, rows in self._groups]
        return [(kind, symbol, hollow, rows) for kind, symbol, hollow, rows in found if rows.any()]

    @cached_property
    def _groups(self) -> list[tuple[str, str, bool, Any]]:
        if self.rows is None:
            return []
        kinds, tentative = _strings(self.rows.measurement_type, len(self.rows)), self._tentative()
        groups = []
        for kind, symbol in (self.symbols or {}).items():
            of_kind = kinds == kind
            for hollow in (False, True):
                chosen = of_kind & (tentative == hollow)
                if chosen.any():
                    groups.append((kind or "update", symbol, hollow, chosen))
        return groups

    def incomplete(self) -> Any:
        """Which updates lack a component of their measurement."""
        return self._incomplete

    @cached_property
    def _incomplete(self) -> Any:
        if self.rows is None or self.rows.innovation is None:
            return np.zeros(len(self.minutes), bool)
        return rows_missing_components(self.rows.innovation, self.rows.measurement_type)

    def _tentative(self) -> Any:
        assert self.rows is not None
        status = _strings(self.rows.status, len(self.rows))
        return status == "tentative"


def track_views(diagnosis: Diagnosis, log: EstimatorLog | None) -> list[TrackView]:
    """The tracks of a diagnosis, the most severe first."""
    styles = track_styles(diagnosis)
    clock = _clock(diagnosis)
    span = (0.0, max((clock.at(t.stop_time) for t in diagnosis.values()), default=1.0) or 1.0)
    symbols = _symbols(log)
    return [
        TrackView(
            track,
            styles[track.track],
            clock,
            span,
            () if log is None else log.states,
            log[track.track] if log is not None and track.track in log else None,
            symbols,
        )
        for track in diagnosis.by_severity()
    ]


def _clock(diagnosis: Diagnosis) -> Clock:
    timeline = next((t.timeline for t in diagnosis.values()), Timeline(0.0, "s"))
    origin, unit = timeline.start, timeline.unit
    moment = f", {timeline.start_utc}" if timeline.start_utc else ""
    if unit in _MINUTE:
        return Clock(origin, _MINUTE[unit], f"minutes since start{moment}")
    return Clock(origin, 1.0, f"time since start ({unit})", unit)


def _symbols(log: EstimatorLog | None) -> dict[str | None, str]:
    """A symbol for each measurement type, in the order in which the types appear."""
    if log is None:
        return {}
    kinds = dict.fromkeys(_strings(log.columns.measurement_type, len(log)))
    return {kind: SYMBOLS[i % len(SYMBOLS)] for i, kind in enumerate(kinds)}


def _strings(column: Any, rows: int) -> Any:
    return np.full(rows, None, object) if column is None else column
