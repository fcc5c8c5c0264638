"""What a diagnosis says of each track and of all of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from trackmetrics.diagnostics import text
from trackmetrics.diagnostics.records import (
    VERDICTS,
    Bias,
    Outlier,
    QuantityVerdict,
    Record,
    StateDiagnosis,
    Whiteness,
)
from trackmetrics.diagnostics.timeline import Timeline


@dataclass(frozen=True)
class TrackDiagnosis(Record):
    """What a log says about one track."""

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
    large"`` or ``"measurement noise too large"`` where the innovations tell, else None."""
    weakest_state: str | None
    """The state that fails first or most; None where nothing fails or nothing can be told."""
    states: tuple[StateDiagnosis, ...]
    """Every state, in the order of the log; empty where the log has no states."""
    biases: tuple[Bias, ...]
    """Significant constant offsets."""
    whiteness: Whiteness | None
    """Correlation of the innovations in the settled part; None without them."""
    outliers: tuple[Outlier, ...]
    """Single NIS that are far too large, whatever the verdict."""
    updates: int
    """How many updates the track has, without repeated rows."""
    tentative: int
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
    """When that gap begins."""
    observed: Mapping[str, tuple[str, ...]]
    """The states that each measurement type observes."""
    notes: tuple[str, ...]
    """Suspicions and remarks that do not change the verdict."""
    time_unit: str = "s"
    """Unit of all times."""
    log_start: float = 0.0
    """Time of the first update of any track of the log."""

    @property
    def timeline(self) -> Timeline:
        """Times in words."""
        return Timeline(self.log_start, self.time_unit)

    @property
    def text(self) -> str:
        """One paragraph of plain English with the numbers, times since the start of the log."""
        return " ".join(s for s in (self.findings, self.timeline.note) if s)

    @property
    def findings(self) -> str:
        """The same without the moment from which the times count."""
        return " ".join(s for s in [*self._sentences(), *self.notes] if s)

    def _sentences(self) -> Iterator[str]:
        """Outliers first, then what the quantities say, then why."""
        timeline = self.timeline
        yield f"{self.track}: {self.verdict.replace('_', ' ')}, {text.MEANINGS[self.verdict]}."
        yield text.outliers_first(self.outliers, timeline)
        yield from (text.quantity(q, timeline) for q in (self.nis, self.nees) if q is not None)
        if self.verdict in text.SCALED:
            yield text.advice(self.nees or self.nis)
        if self.cause:
            yield f"Probable cause: {self.cause}."
        yield from map(text.bias, self.biases)
        yield text.weakest_state(self.weakest_state, self.states)
        began = self.longest_gap_time
        gap = None if began is None else (self.longest_gap, began)
        yield text.coverage(self.updates, self.tentative, self.repeated, gap, timeline)

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
        """What is suspicious about the log as a whole."""

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
        """How many tracks."""
        return len(self._tracks)

    @property
    def consistent(self) -> bool:
        """Whether every track is."""
        return all(track.consistent for track in self.values())

    @property
    def text(self) -> str:
        """A paragraph for each track, the most severe first."""
        tracks = self.by_severity()
        notes = dict.fromkeys(track.timeline.note for track in tracks)
        parts = [*self.warnings, *(track.findings for track in tracks), *notes]
        return "\n\n".join(part for part in parts if part)

    def by_severity(self) -> tuple[TrackDiagnosis, ...]:
        """The tracks, the most severe verdict first."""
        return tuple(sorted(self.values(), key=lambda track: VERDICTS.index(track.verdict)))

    def to_dict(self) -> dict[str, Any]:
        """Everything as dictionaries, lists, strings and numbers."""
        tracks = {name: track.to_dict() for name, track in self.items()}
        return {"warnings": list(self.warnings), "tracks": tracks}

    def __repr__(self) -> str:
        """The verdict of each track."""
        verdicts = ", ".join(f"{name!r}: {track.verdict!r}" for name, track in self.items())
        return f"Diagnosis({{{verdicts}}})"

    def __str__(self) -> str:
        """The paragraphs."""
        return self.text
