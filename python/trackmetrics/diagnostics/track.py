"""The diagnosis of a track, and that of all tracks of a log."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from trackmetrics import _deprecated
from trackmetrics.diagnostics import text
from trackmetrics.diagnostics.cause import CAUSE_VERDICTS
from trackmetrics.diagnostics.results import (
    VERDICTS,
    Bias,
    InnovationCorrelation,
    Outlier,
    QuantityVerdict,
    StateDiagnosis,
)
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.results import Result


@dataclass(frozen=True)
class TrackDiagnosis(Result):
    """The diagnosis of one track."""

    track: str
    """Its name."""
    verdict: str
    """The more severe of the verdicts of NIS and NEES; one of :data:`VERDICTS`."""
    nis: QuantityVerdict
    """The verdict of the NIS (``"insufficient"`` without one)."""
    nees: QuantityVerdict | None
    """The verdict of the NEES; None without truth."""
    cause: str | None
    """``"process noise too small"``, ``"measurement noise too small"``, ``"process noise too
    large"`` or ``"measurement noise too large"`` if the innovations show it, else None."""
    weakest_state: str | None
    """The state that fails first or most; None if none fails or it cannot be determined."""
    states: tuple[StateDiagnosis, ...]
    """Every state, in the order of the log; empty where the log has no states."""
    biases: tuple[Bias, ...]
    """Significant biases of innovations and of states (estimate minus truth)."""
    whiteness: InnovationCorrelation | None
    """Correlation of the innovations in the settled part; None without them."""
    outliers: tuple[Outlier, ...]
    """Isolated NIS that are far too large, whatever the verdict."""
    updates: int
    """How many updates the track has, without repeated rows."""
    updates_without_nis: int
    """How many of them carry no NIS."""
    repeated: int
    """How many repeated rows were dropped."""
    start_time: float
    """Time of the first update."""
    stop_time: float
    """Time of the last update."""
    longest_gap: float
    """Longest time between two updates (NaN with one)."""
    longest_gap_time: float | None
    """Time at which that gap begins."""
    observed: Mapping[str, tuple[str, ...]]
    """The states that each measurement type observes."""
    notes: tuple[str, ...]
    """Suspicions and remarks that do not change the verdict."""
    time_unit: str = "s"
    """Unit of all times."""
    log_start: float = 0.0
    """Time of the first update of any track of the log."""

    tentative = _deprecated.attribute("updates_without_nis")

    @property
    def onset_time(self) -> float | None:
        """Time at which the fault begins, by the quantity that shows it first; None without one."""
        return self._first("onset_time")

    @property
    def settling_time(self) -> float | None:
        """Time at which a bad start is over, by both quantities; None without one."""
        found = [q.settling_time for q in self._quantities() if q.settling_time is not None]
        return max(found, default=None)

    def _first(self, name: str) -> float | None:
        found = [getattr(q, name) for q in self._quantities()]
        return min((time for time in found if time is not None), default=None)

    def _quantities(self) -> list[QuantityVerdict]:
        return [q for q in (self.nis, self.nees) if q is not None]

    @property
    def timeline(self) -> Timeline:
        """Times as text."""
        return Timeline(self.log_start, self.time_unit)

    @property
    def text(self) -> str:
        """One paragraph with the findings and their numbers, times from the start of the log."""
        return " ".join(s for s in (self.findings, self.timeline.origin_note) if s)

    @property
    def findings(self) -> str:
        """The same without the sentence that says from when times count."""
        return " ".join(s for s in [*self._sentences(), *self.notes] if s)

    def _sentences(self) -> Iterator[str]:
        timeline = self.timeline
        yield text.headline(self.track, self.verdict, self.nis, self.nees)
        yield text.outliers_first(self.outliers, timeline)
        yield from (text.quantity(q, timeline) for q in self._quantities())
        if self.verdict in CAUSE_VERDICTS:
            yield text.advice(self.nees or self.nis)
        yield text.cause(self.cause)
        yield from map(text.bias, self.biases)
        yield text.weakest_state(self.weakest_state, self.states)
        gap = self.longest_gap, self.longest_gap_time
        yield text.updates(self.updates, self.updates_without_nis, self.repeated, gap, timeline)

    def to_dict(self) -> dict[str, Any]:
        """The fields and the paragraph as dictionaries, lists, numbers and strings."""
        return {**super().to_dict(), "text": self.text}

    @property
    def consistent(self) -> bool:
        """Whether the verdict is ``"consistent"``."""
        return self.verdict == "consistent"

    def __repr__(self) -> str:
        """The verdicts, not every number."""
        nees = "" if self.nees is None else f", nees={self.nees.verdict!r}"
        return (
            f"TrackDiagnosis({self.track!r}, {self.verdict!r}, nis={self.nis.verdict!r}{nees}, "
            f"updates={self.updates})"
        )

    def __str__(self) -> str:
        """The paragraph."""
        return self.text


class Diagnosis(Mapping[str, TrackDiagnosis]):
    """The diagnosis of every track of a log, by name, in the order of the log."""

    def __init__(self, tracks: tuple[TrackDiagnosis, ...], warnings: tuple[str, ...] = ()) -> None:
        self._tracks = {track.track: track for track in tracks}
        self.warnings = warnings
        """Warnings about the log as a whole."""

    def __getitem__(self, track: str) -> TrackDiagnosis:
        """The diagnosis of the track of this name."""
        try:
            return self._tracks[track]
        except KeyError:
            known = ", ".join(map(repr, self._tracks))
            raise KeyError(f"no track {track!r}; the log has {known}") from None

    def __iter__(self) -> Iterator[str]:
        """The names of the tracks."""
        return iter(self._tracks)

    def __len__(self) -> int:
        """The number of tracks."""
        return len(self._tracks)

    @property
    def consistent(self) -> bool:
        """Whether the verdict of every track is ``"consistent"``."""
        return all(track.consistent for track in self.values())

    @property
    def text(self) -> str:
        """A paragraph for each track, the most severe first."""
        tracks = self.by_severity()
        notes = dict.fromkeys(track.timeline.origin_note for track in tracks)
        parts = [*self.warnings, *(track.findings for track in tracks), *notes]
        return "\n\n".join(part for part in parts if part)

    def by_severity(self) -> tuple[TrackDiagnosis, ...]:
        """The tracks, the most severe verdict first."""
        return tuple(sorted(self.values(), key=lambda track: VERDICTS.index(track.verdict)))

    def to_dict(self) -> dict[str, Any]:
        """All results as dictionaries, lists, strings and numbers."""
        tracks = {name: track.to_dict() for name, track in self.items()}
        return {"warnings": list(self.warnings), "tracks": tracks}

    def __repr__(self) -> str:
        """The verdict of each track."""
        verdicts = ", ".join(f"{name!r}: {track.verdict!r}" for name, track in self.items())
        return f"Diagnosis({{{verdicts}}})"

    def __str__(self) -> str:
        """The paragraphs."""
        return self.text
