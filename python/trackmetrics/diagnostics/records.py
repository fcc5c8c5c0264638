"""What a diagnosis says of a part of a track: frozen records of quantities, segments and states.

Times are in the unit of the log, indices count the updates of one track from 0, and a ``scale`` is
the factor by which a squared error exceeds what its covariance promises: 1 is honest, above 1 the
filter is optimistic (its covariance is too small), below 1 it is pessimistic.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

VERDICTS = (
    "angle_wrap_bug",
    "late_divergence",
    "startup_then_consistent",
    "startup_then_pessimistic",
    "biased",
    "optimistic",
    "transient",
    "pessimistic",
    "partly_pessimistic",
    "outliers",
    "non_white",
    "consistent",
    "insufficient",
)
"""Every verdict, the most severe first."""


def _plain(value: Any) -> Any:
    """Records and tuples as dictionaries and lists, for JSON."""
    if isinstance(value, Record):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


class Record:
    """A frozen dataclass that turns into a dictionary."""

    def to_dict(self) -> dict[str, Any]:
        """The fields as a dictionary of numbers, strings, lists and dictionaries."""
        return {f.name: _plain(getattr(self, f.name)) for f in fields(self)}  # type: ignore[arg-type]


@dataclass(frozen=True)
class Segment(Record):
    """A stretch of consecutive updates with one common scale."""

    start: int
    """Its first update."""
    stop: int
    """The update after its last, so that ``start:stop`` is a slice."""
    start_time: float
    """Time of its first update."""
    stop_time: float
    """Time of its last update."""
    dof: float
    """Degrees of freedom of its values together (after division by ``inflation``)."""
    scale: float
    """Mean value per degree of freedom; 1 is honest."""
    interval: tuple[float, float]
    """95 % confidence interval of the scale."""
    p_value: float
    """Two-sided p-value of "the scale is 1", corrected for the number of segments (Holm)."""
    label: str
    """``"high"`` (optimistic), ``"low"`` (pessimistic) or ``"consistent"``."""


@dataclass(frozen=True)
class QuantityVerdict(Record):
    """The verdict of one quantity of a track, its NIS or its NEES."""

    quantity: str
    """``"nis"`` or ``"nees"``."""
    verdict: str
    """One of :data:`VERDICTS`."""
    updates: int
    """How many updates carry the quantity."""
    segments: tuple[Segment, ...]
    """The track cut where the scale changes."""
    scale: float
    """Scale of the settled part (the longest stretch that is not too high); NaN if insufficient."""
    interval: tuple[float, float]
    """95 % confidence interval of ``scale``."""
    onset_index: int | None
    """Update at which the fault begins (late divergence, transient), else None."""
    onset_time: float | None
    """Its time."""
    settle_index: int | None
    """First update after a bad start, else None."""
    settle_time: float | None
    """Its time."""
    alarm_index: int | None
    """Update at which an online CUSUM for "too large" would have raised its alarm, else None."""
    alarm_time: float | None
    """Its time."""
    alarm_onset_time: float | None
    """Time at which that CUSUM began to rise."""
    inflation: float
    """Median factor by which correlation in time widens the quantity's spread; 1 for NIS."""


@dataclass(frozen=True)
class Outlier(Record):
    """An update whose NIS is far too large for the scale of the track."""

    index: int
    """The update."""
    time: float
    """Its time."""
    nis: float
    """Its NIS."""
    dof: float
    """The degrees of freedom of that NIS."""
    p_value: float
    """Chance of so large a NIS under the robust scale of the track."""


@dataclass(frozen=True)
class Bias(Record):
    """A constant offset that is significant."""

    kind: str
    """``"innovation"`` or ``"state"``."""
    measurement_type: str | None
    """The measurement type of an innovation's bias."""
    component: str
    """Name of the state or of the innovation's component."""
    value: float
    """The offset, in ``unit``."""
    unit: str
    """Unit of the value; empty where the log does not say."""
    z: float
    """The offset over its standard deviation."""
    p_value: float
    """Two-sided p-value, corrected for the number of offsets tested (Holm)."""


@dataclass(frozen=True)
class Whiteness(Record):
    """Correlation of each whitened innovation with the next few."""

    lag1: float
    """Correlation with the next; 0 for an honest filter."""
    z: float
    """Weighted over the next few, in standard deviations: positive where innovations pull the same
    way (over three updates), negative where they alternate (over two)."""
    p_value: float
    """Two-sided p-value."""
    pairs: int
    """How many pairs of components with the next went in."""


@dataclass(frozen=True)
class StateDiagnosis(Record):
    """One state of a track: what supports it, how its uncertainty grew, its part in the fault.

    What the log cannot tell is NaN or None.
    """

    state: str
    """Name of the state."""
    unit: str
    """Its unit; empty where the log does not say."""
    observed_by: tuple[str, ...]
    """The measurement types that observe it directly."""
    support: int | None
    """How many updates observe it directly."""
    longest_gap: float
    """Longest time between two of these, or to either end of the track."""
    reference_std: float
    """Claimed standard deviation at the first update."""
    peak_growth: float
    """Largest claimed standard deviation over ``reference_std``."""
    peak_time: float | None
    """When."""
    growth_onset_time: float | None
    """First of two consecutive updates at which the claim has doubled, else None."""
    information_gain: float
    """Mean share of its variance that an update removes: 1 - P+/P-; 0 is no support."""
    supported: bool | None
    """Whether any update has cut its variance by half; None without P or std."""
    share: float
    """Its part of the NEES in the failing segment (Shapley); all states add up to 1."""
    nees: float
    """The same as a mean value, 1 expected of each state."""
    marginal: float
    """Mean squared error over claimed variance in the failing segment; 1 expected."""
    unique: float
    """Mean NEES that vanishes when the state is left out; 1 expected."""
