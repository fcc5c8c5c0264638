"""Page's cumulative sum test for a change of scale, over a whole sequence or one value at a time.

The log-likelihood ratio of scale s against 1 of a chi-square value c with m degrees of freedom is
l = -(m / 2) ln s + (c / 2) (1 - 1 / s). The sum g rises by l, never below 0, and an alarm is raised
above h = ln(n / chance): by Ville's inequality each excursion from 0 passes h with probability
chance / n at most, so that within n values a false alarm has at most that ``chance``.
Page (1954), doi:10.1093/biomet/41.1-2.100.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from trackmetrics import _backend
from trackmetrics.diagnostics.records import Record
from trackmetrics.logs.columns import Floats

TOO_LARGE = 2.5
TOO_SMALL = 0.4
CHANCE = 0.01


def first_alarms(
    pairs: Sequence[tuple[Floats, Floats]], chance: float = CHANCE
) -> list[tuple[int, int] | None]:
    """Where the sum for "too large" of each sequence first passes its threshold, and where it
    began to rise."""
    if not pairs:
        return []
    starts = np.concatenate([[0], np.cumsum([len(values) for values, _ in pairs])])
    values, dof = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    alarms = _backend.kernels.first_alarms(values, dof, starts.astype(np.int64), TOO_LARGE, chance)
    return [(alarm, onset) if alarm >= 0 else None for alarm, onset in alarms.tolist()]


@dataclass(frozen=True)
class LiveStatus(Record):
    """What a monitor knows after an update."""

    updates: int
    """How many updates it has seen."""
    too_large: float
    """Sum for "NIS too large"; an alarm above ``threshold``."""
    too_small: float
    """Sum for "NIS too small"; an alarm above ``threshold``."""
    threshold: float
    """Where an alarm is raised."""
    alarm: str | None
    """``"optimistic"`` (NIS too large) or ``"pessimistic"`` (too small) while the sum is above."""
    onset: float | None
    """Time, or number of the update, at which that sum began to rise; None without an alarm."""


class LiveMonitor:
    """Watches the NIS of one track as it comes: two sums, one for too large and one for too small.

    Memory is bounded and an update costs a few operations. Within ``horizon`` updates of an honest
    filter the chance of any alarm is at most ``chance``; after that the monitor goes on.

    Parameters
    ----------
    horizon
        Number of updates for which ``chance`` holds, at least 1.
    chance
        Chance of a false alarm within the horizon, between 0 and 1.
    too_large, too_small
        The scales looked for: above 1 and below 1.

    Raises
    ------
    ValueError
        If a parameter is outside its range.

    Notes
    -----
    The threshold is ln(2 horizon / chance): half of the chance for each side.

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

    def __init__(
        self,
        *,
        horizon: int,
        chance: float = CHANCE,
        too_large: float = TOO_LARGE,
        too_small: float = TOO_SMALL,
    ) -> None:
        _require("horizon", horizon, horizon >= 1, "at least 1")
        _require("chance", chance, 0 < chance < 1, "between 0 and 1")
        _require("too_large", too_large, 1 < too_large < np.inf, "above 1")
        _require("too_small", too_small, 0 < too_small < 1, "between 0 and 1")
        self.threshold = log(2 * horizon / chance)
        """Where a sum raises its alarm."""
        self._scales = (float(too_large), float(too_small))
        self.reset()

    def reset(self) -> None:
        """Start again, as after the track or the filter was reset."""
        self._updates = 0
        self._sums = [0.0, 0.0]
        self._onsets: list[float] = [0.0, 0.0]

    def update(self, nis: float, dof: float, time: float | None = None) -> LiveStatus:
        """Take in the NIS of one update with its degrees of freedom; what is known now.

        Raises
        ------
        ValueError
            If ``nis`` is negative or not finite, or ``dof`` not positive.
        """
        _require("nis", nis, 0 <= nis < np.inf, "finite and at least 0")
        _require("dof", dof, 0 < dof < np.inf, "positive")
        when = float(self._updates if time is None else time)
        for side, scale in enumerate(self._scales):
            if self._sums[side] <= 0:
                self._onsets[side] = when
            rise = -(dof / 2) * log(scale) + (nis / 2) * (1 - 1 / scale)
            self._sums[side] = max(0.0, self._sums[side] + rise)
        self._updates += 1
        return self.status

    @property
    def status(self) -> LiveStatus:
        """What is known after the last update."""
        large, small = self._sums
        alarm, onset = None, None
        if large > self.threshold:
            alarm, onset = "optimistic", self._onsets[0]
        elif small > self.threshold:
            alarm, onset = "pessimistic", self._onsets[1]
        return LiveStatus(self._updates, large, small, self.threshold, alarm, onset)


def _require(name: str, value: float, holds: bool, requirement: str) -> None:
    if not holds:
        raise ValueError(f"{name} must be {requirement}, got {value!r}")
