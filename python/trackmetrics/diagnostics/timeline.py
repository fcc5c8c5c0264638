"""Times in words: since the start of the log, whose own moment is said once."""

from dataclasses import dataclass
from datetime import UTC, datetime

_PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_FROM, _TO = (datetime(year, 1, 1, tzinfo=UTC).timestamp() for year in (1990, 2100))
"""Times between these look like seconds since 1970."""


@dataclass(frozen=True)
class Timeline:
    """The times of a log in words."""

    start: float
    """Time of the first update of any track."""
    unit: str
    """Unit of the times."""

    def at(self, time: float) -> str:
        """A moment, since the start of the log."""
        return self.lasting(time - self.start)

    def count(self, time: float) -> str:
        """The same without its unit."""
        return _digits(time - self.start)

    def lasting(self, span: float) -> str:
        """How long."""
        return f"{_digits(span)} {self.unit}".strip()

    @property
    def moment(self) -> str | None:
        """When the log starts, in UTC, where its times look like those of the Unix epoch."""
        seconds = self.start / _PER_SECOND.get(self.unit, float("inf"))
        if not _FROM <= seconds < _TO:
            return None
        return f"{datetime.fromtimestamp(seconds, UTC):%Y-%m-%d %H:%M:%S} UTC"

    @property
    def note(self) -> str:
        """From when the times in words count; nothing to say where the log starts at 0."""
        if self.start == 0:
            return ""
        moment = self.moment or f"at {self.lasting(self.start)}"
        return f"Times count from the start of the log, {moment}."


def _digits(time: float) -> str:
    # Differences of times since 1970 have digits that nobody measured.
    rounded = round(time, 3) if abs(time) >= 1 else float(f"{time:.3g}")
    return f"{rounded:.0f}" if rounded.is_integer() else f"{rounded:.10g}"
