"""The results of a diagnosis for the parts of a track: quantities, segments, outliers, states.

Times are in the unit of the log and indices count the updates of one track from 0. A ``scale`` is
the mean of a squared error over its expectation from the covariance: 1 if consistent, above 1
optimistic (the covariance is too small), below 1 pessimistic (the covariance is too large).
"""

from dataclasses import dataclass

from trackmetrics import _deprecated
from trackmetrics.results import Result

NAN = float("nan")

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

FAILING_VERDICTS = VERDICTS[: VERDICTS.index("transient") + 1]
"""Verdicts that say that errors are larger than the covariance says."""


@dataclass(frozen=True)
class Segment(Result):
    """Consecutive updates with one common scale."""

    start: int
    """Its first update."""
    stop: int
    """The update after its last, so that ``start:stop`` is a slice."""
    start_time: float
    """Time of its first update."""
    stop_time: float
    """Time of its last update."""
    dof: float
    """Degrees of freedom of its values together (divided by ``autocorrelation_time``)."""
    scale: float
    """Mean value per degree of freedom; 1 if consistent."""
    interval: tuple[float, float]
    """95 % confidence interval of the scale."""
    p_value: float
    """Two-sided p-value of "the scale is 1", corrected for the number of segments (Holm)."""
    label: str
    """``"optimistic"`` (too large), ``"pessimistic"`` (too small) or ``"consistent"``."""
    has_spike: bool = False
    """Whether it is too large by one value alone, an outlier; it then counts as consistent."""


@dataclass(frozen=True)
class QuantityVerdict(Result):
    """The verdict of one quantity of a track, its NIS or its NEES."""

    quantity: str
    """``"nis"`` or ``"nees"``."""
    verdict: str
    """One of :data:`VERDICTS`."""
    updates: int
    """How many updates carry the quantity."""
    segments: tuple[Segment, ...]
    """The track, cut where the scale changes."""
    scale: float
    """Scale of the settled part (the longest segment that is not optimistic, else the longest);
    NaN if insufficient."""
    interval: tuple[float, float]
    """95 % confidence interval of ``scale``."""
    onset_index: int | None
    """Update at which the fault begins (late divergence, transient), else None."""
    onset_time: float | None
    """Its time."""
    settling_index: int | None
    """First update after a bad start, else None."""
    settling_time: float | None
    """Its time."""
    alarm_index: int | None
    """Update at which an online CUSUM for "too large" would have raised an alarm, else None; where
    there is an onset, the first alarm from the onset on."""
    alarm_time: float | None
    """Its time."""
    alarm_onset_time: float | None
    """Time at which that CUSUM began to rise."""
    autocorrelation_time: float
    """Median factor by which correlation in time widens the quantity's spread; 1 for NIS."""
    decided_by: str = "segments"
    """What the verdict follows from: ``"segments"``, ``"start test"`` or ``"end test"`` (the first
    or last few updates), ``"bias"``, ``"correlation"`` (size of innovations that are correlated),
    ``"size and correlation"`` (significant together only), ``"angles"``, ``"nis"`` or ``"nees"``
    (the other quantity)."""

    settle_index = _deprecated.attribute("settling_index")
    settle_time = _deprecated.attribute("settling_time")
    inflation = _deprecated.attribute("autocorrelation_time")


@dataclass(frozen=True)
class Outlier(Result):
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
    """Probability of a NIS at least as large under the robust scale of the track."""


@dataclass(frozen=True)
class Bias(Result):
    """A significant bias: the mean innovation of a component, or the mean error of a state.

    Errors are estimate minus truth, innovations measurement minus prediction.
    """

    kind: str
    """``"innovation"`` or ``"state"``."""
    measurement_type: str | None
    """The measurement type of an innovation's bias."""
    component: str
    """Name of the state or of the innovation's component."""
    value: float
    """The bias, in ``unit``."""
    unit: str
    """Unit of the value; empty if unknown."""
    z: float
    """The bias over its standard deviation."""
    p_value: float
    """Two-sided p-value, corrected for the number of biases tested (Holm)."""
    index: int = 0
    """Index of the component in the innovation, or of the state."""


@dataclass(frozen=True)
class InnovationCorrelation(Result):
    """Correlation of each whitened innovation with the next few."""

    lag1: float
    """Correlation with the next innovation, in [-1, 1]; 0 for a consistent filter."""
    z: float
    """Weighted sum over the next few lags, in standard deviations: positive for positive
    autocorrelation (over three lags), negative for negative autocorrelation (over two)."""
    p_value: float
    """Two-sided p-value."""
    pairs: int
    """How many pairs of components the first lag is estimated from."""
    second_half_z: float = NAN
    """The same sum as ``z`` over the second half alone."""
    second_half_scale: float = NAN
    """Mean square of the whitened innovations of the second half; 1 if consistent."""


@dataclass(frozen=True)
class StateDiagnosis(Result):
    """One state of a track: what observes it, how its uncertainty grew, its part in a fault.

    What the log does not contain is NaN or None.
    """

    state: str
    """Name of the state."""
    unit: str
    """Its unit; empty if unknown."""
    observed_by: tuple[str, ...]
    """The measurement types that observe it directly."""
    num_direct_updates: int | None
    """How many updates observe it directly."""
    longest_gap: float
    """Longest time between two of these, or to either end of the track."""
    reference_std: float
    """Claimed standard deviation at the first update."""
    peak_growth: float
    """Largest claimed standard deviation over ``reference_std``."""
    peak_time: float | None
    """Time of the largest."""
    growth_onset_time: float | None
    """First of two consecutive updates at which the claimed deviation has doubled, else None."""
    information_gain: float
    """Mean share of its variance that an update removes, 1 - P+/P-; 0 if unobserved."""
    is_observed: bool | None
    """Whether any update has removed half of its variance; None without P or std."""
    nees_share: float
    """Its share of the NEES in the failing segment (Shapley); the shares of all states sum to 1."""
    shapley_nees: float
    """The same as a mean value; 1 is expected for each state."""
    marginal_nees: float
    """Mean squared error over claimed variance in the failing segment; 1 expected."""
    conditional_nees: float
    """Mean decrease of the NEES when the state is left out; 1 expected."""

    support = _deprecated.attribute("num_direct_updates")
    supported = _deprecated.attribute("is_observed")
    share = _deprecated.attribute("nees_share")
    nees = _deprecated.attribute("shapley_nees")
    marginal = _deprecated.attribute("marginal_nees")
    unique = _deprecated.attribute("conditional_nees")
