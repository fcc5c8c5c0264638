"""Times as text, counted from the start of the log."""

from dataclasses import dataclass
from datetime import UTC, datetime

_PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_FROM, _TO = (datetime(year, 1, 1, tzinfo=UTC).timestamp() for year in (1990, 2100))
"""Times between these look like seconds since 1970."""


@dataclass(frozen=True)
class Timeline:
    """The times of a log as text."""

    start: float
    """Time of the first update of any track."""
    unit: str
    """Unit of the times."""

    def at(self, time: float) -> str:
        """A time with its unit, counted from the start of the log."""
        return self.duration(time - self.start)

    def value(self, time: float) -> str:
        """The same without its unit."""
        return _digits(time - self.start)

    def duration(self, span: float) -> str:
        """A duration with its unit."""
        return f"{_digits(span)} {self.unit}".strip()

    @property
    def start_utc(self) -> str | None:
        """The start of the log in UTC, if its times look like Unix time; else None."""
        seconds = self.start / _PER_SECOND.get(self.unit, float("inf"))
        if not _FROM <= seconds < _TO:
            return None
        return f"{datetime.fromtimestamp(seconds, UTC):%Y-%m-%d %H:%M:%S} UTC"

    @property
    def origin_note(self) -> str:
        """A sentence that says from when times count; empty if the log starts at 0."""
        if self.start == 0:
            return ""
        start = self.start_utc or f"at {self.duration(self.start)}"
        return f"Times count from the start of the log, {start}."


def _digits(time: float) -> str:
    # Differences of Unix times have digits that are rounding errors.
    rounded = round(time, 3) if abs(time) >= 1 else float(f"{time:.3g}")
    return f"{rounded:.0f}" if rounded.is_integer() else f"{rounded:.10g}"
