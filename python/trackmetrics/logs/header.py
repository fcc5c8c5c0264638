"""What a log says once, for all rows: its states, their units and angles, the unit of its times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypedDict

from trackmetrics._tables.errors import value

LOG_SCHEMA = "trackmetrics-log/1"
"""Name of the form of a log in a file."""

COVARIANCES_WRITTEN = "upper triangles up to the last component"
"""How files hold covariances; said in their header."""

MeasurementAngles = Mapping[str, Mapping[int, float]]


@dataclass(frozen=True)
class State:
    """A state of the estimator, by name."""

    name: str
    """Its name."""
    unit: str = ""
    """Its unit; empty if unknown."""
    period: float | None = None
    """The period of an angle in that unit (360 for degrees), None for what is not an angle."""


class HeaderArguments(TypedDict, total=False):
    """The keyword arguments of every way to make a log; see :meth:`EstimatorLog.from_columns`."""

    states: Sequence[State | str] | None
    state_dim: int | None
    angles: Mapping[str | int, float] | None
    measurement_angles: MeasurementAngles | None
    time_unit: str | None
    time: str | None
    date_order: str | None
    covariance_forms: Mapping[str, str] | None
    on_repeats: str
    nis_scale: float


@dataclass(frozen=True)
class LogHeader:
    """What a log says once, for all rows; see :meth:`EstimatorLog.from_columns`."""

    states: Sequence[State | str] | None = None
    state_dim: int | None = None
    angles: Mapping[str | int, float] | None = None
    measurement_angles: MeasurementAngles | None = None
    time_unit: str | None = None
    time: str | None = None
    date_order: str | None = None
    covariance_forms: Mapping[str, str] | None = None
    on_repeats: str = "drop"
    nis_scale: float = 1.0
    epoch: str | None = None
    """Moment of time 0 in ISO 8601, where it is known."""
    missing_ends_cut: bool = False
    """Whether covariances come without the missing components at their ends, as we write them."""

    def over(self, found: "LogHeader") -> "LogHeader":
        """This header, and where it says nothing what was ``found`` in a file."""
        names = (
            "states",
            "state_dim",
            "measurement_angles",
            "time_unit",
            "covariance_forms",
            "epoch",
        )
        missing = {n: getattr(found, n) for n in names if getattr(self, n) is None}
        return replace(self, **missing, missing_ends_cut=found.missing_ends_cut)


def to_record(
    states: Sequence[State],
    measurement_angles: MeasurementAngles,
    time_unit: str,
    epoch: str | None,
) -> dict[str, Any]:
    """The header of a file."""
    record: dict[str, Any] = {
        "schema": LOG_SCHEMA,
        "states": [{"name": s.name, "unit": s.unit, "period": s.period} for s in states],
        "measurement_angles": {
            kind: {str(i): period for i, period in angles.items()}
            for kind, angles in measurement_angles.items()
        },
        "time_unit": time_unit,
        "covariances": COVARIANCES_WRITTEN,
    }
    return record | ({"epoch": epoch} if epoch else {})


def is_record(record: Mapping[str, Any]) -> bool:
    """Whether the first record of a file is its header."""
    return "schema" in record and "states" in record


def from_record(record: Mapping[str, Any], file: str) -> LogHeader:
    """The header in a file; covariances in such a file are upper triangles."""
    if record["schema"] != LOG_SCHEMA:
        raise ValueError(f"{file}: schema {value(record['schema'])}, expected {LOG_SCHEMA!r}")
    states = [State(s["name"], s.get("unit", ""), s.get("period")) for s in record["states"]]
    angles = {
        kind: {int(i): float(period) for i, period in of_kind.items()}
        for kind, of_kind in record.get("measurement_angles", {}).items()
    }
    return LogHeader(
        states=states or None,
        measurement_angles=angles,
        time_unit=record.get("time_unit", "s"),
        covariance_forms=dict.fromkeys(("P_pred", "P", "S", "R"), "upper"),
        epoch=record.get("epoch"),
        missing_ends_cut=record.get("covariances") == COVARIANCES_WRITTEN,
    )
