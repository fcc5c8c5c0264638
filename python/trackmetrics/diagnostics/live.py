"""A monitor of the NIS of one track, one update at a time, by two cumulative sums."""

from dataclasses import dataclass
from math import inf, log

from trackmetrics import _deprecated
from trackmetrics._check import number
from trackmetrics.diagnostics.cusum import rise
from trackmetrics.diagnostics.thresholds import CUSUM_ALPHA, CUSUM_SCALE_HIGH, CUSUM_SCALE_LOW
from trackmetrics.results import Result


@dataclass(frozen=True)
class LiveStatus(Result):
    """The state of a monitor after an update."""

    updates: int
    """How many updates it has seen."""
    cusum_high: float
    """Cumulative sum for "NIS too large", at least 0; an alarm above ``threshold``."""
    cusum_low: float
    """Cumulative sum for "NIS too small", at least 0; an alarm above ``threshold``."""
    threshold: float
    """Value of a sum above which an alarm is raised."""
    alarm: str | None
    """``"optimistic"`` (NIS too large) or ``"pessimistic"`` (too small) while the sum is above."""
    onset: float | None
    """Time, or number of the update, at which that sum began to rise; None without an alarm."""

    too_large = _deprecated.attribute("cusum_high")
    too_small = _deprecated.attribute("cusum_low")


class LiveMonitor:
    """Monitors the NIS of one track online: one sum for too large values, one for too small ones.

    A sum rises by the log-likelihood ratio of ``scale_high`` (``scale_low``) against a scale of 1,
    never below 0. Memory is constant and an update costs a few operations. Within ``horizon``
    updates of a consistent filter the probability of any alarm is at most ``alpha``; the monitor
    goes on after them.

    Parameters
    ----------
    horizon
        Number of updates for which ``alpha`` holds, at least 1.
    alpha
        Probability of a false alarm within the horizon, between 0 and 1.
    scale_high, scale_low
        The scales of the NIS to detect: above 1 and below 1.

    Raises
    ------
    ValueError
        If a parameter is outside its range.
    TypeError
        If a parameter is no number.

    Notes
    -----
    The threshold is ln(2 horizon / alpha): half of alpha for each side.

    References
    ----------
    E. S. Page, Continuous inspection schemes, Biometrika 41 (1954), doi:10.1093/biomet/41.1-2.100.

    Examples
    --------
    >>> monitor = LiveMonitor(horizon=100)
    >>> for nis in [1.2, 3.0, 0.4, 24.0, 11.0, 17.0]:
    ...     status = monitor.update(nis, dof=2)
    >>> status.alarm, status.onset
    ('optimistic', 3.0)
    """

    @_deprecated.parameters(chance="alpha", too_large="scale_high", too_small="scale_low")
    def __init__(
        self,
        *,
        horizon: int,
        alpha: float = CUSUM_ALPHA,
        scale_high: float = CUSUM_SCALE_HIGH,
        scale_low: float = CUSUM_SCALE_LOW,
    ) -> None:
        horizon_ = _number_in("horizon", horizon, 1, inf, "at least 1 and finite")
        alpha_ = _number_in("alpha", alpha, 0, 1, "between 0 and 1", open_low=True)
        high = _number_in("scale_high", scale_high, 1, inf, "above 1 and finite", open_low=True)
        low = _number_in("scale_low", scale_low, 0, 1, "between 0 and 1", open_low=True)
        self.threshold = log(2 * horizon_ / alpha_)
        """Value of a sum above which an alarm is raised."""
        self._scales = (high, low)
        self.reset()

    def reset(self) -> None:
        """Start again, for instance after the filter was reset."""
        self._updates = 0
        self._sums = [0.0, 0.0]
        self._onsets: list[float] = [0.0, 0.0]

    def update(self, nis: float, dof: float, time: float | None = None) -> LiveStatus:
        """Add the NIS of one update with its degrees of freedom, and return the status.

        Raises
        ------
        ValueError
            If ``nis`` is negative or not finite, or ``dof`` not positive.
        """
        nis = _number_in("nis", nis, 0, inf, "finite and at least 0")
        dof = _number_in("dof", dof, 0, inf, "finite and positive", open_low=True)
        when = float(self._updates if time is None else time)
        for side, scale in enumerate(self._scales):
            if self._sums[side] <= 0:
                self._onsets[side] = when
            self._sums[side] = max(0.0, self._sums[side] + rise(nis, dof, scale))
        self._updates += 1
        return self.status

    @property
    def status(self) -> LiveStatus:
        """The status after the last update."""
        large, small = self._sums
        alarm, onset = None, None
        if large > self.threshold:
            alarm, onset = "optimistic", self._onsets[0]
        elif small > self.threshold:
            alarm, onset = "pessimistic", self._onsets[1]
        return LiveStatus(self._updates, large, small, self.threshold, alarm, onset)


def _number_in(
    name: str, value: float, low: float, high: float, requirement: str, open_low: bool = False
) -> float:
    """A number in ``[low, high)``, or in ``(low, high)``."""
    found = number(name, value)
    if not ((low < found if open_low else low <= found) and found < high):
        raise ValueError(f"{name} must be {requirement}, got {value!r}")
    return found
