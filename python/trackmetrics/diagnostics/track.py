"""The record of one track, from its judged quantities."""

from dataclasses import dataclass

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics import text as words
from trackmetrics.diagnostics.angles import Unwrapped
from trackmetrics.diagnostics.bias import StateOffset
from trackmetrics.diagnostics.innovations import Offset
from trackmetrics.diagnostics.judging import (
    InnovationFindings,
    Quantity,
    judge_errors,
    judge_innovations,
    reconciled,
)
from trackmetrics.diagnostics.outliers import LEAST_UPDATES, is_suspicious, robust_scale
from trackmetrics.diagnostics.records import (
    VERDICTS,
    Bias,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
    Whiteness,
)
from trackmetrics.diagnostics.results import TrackDiagnosis
from trackmetrics.diagnostics.states import (
    Attribution,
    attribute,
    observed_states,
    state_records,
    weakest,
)
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.diagnostics.trace import Stretch
from trackmetrics.logs.columns import Columns, Floats, components, incomplete
from trackmetrics.logs.log import EstimatorLog

FAILING = VERDICTS[: VERDICTS.index("transient") + 1]
"""Verdicts that say that an error is larger than claimed."""


@dataclass(frozen=True)
class Evidence:
    """What there is to say about one track."""

    log: EstimatorLog
    index: int
    columns: Columns
    innovations: Floats | None
    """Innovations, wrapped."""
    nis: Quantity
    nees: Quantity | None
    angles: Unwrapped | None
    """None where no innovation of the log is beyond half a period."""
    warnings: tuple[str, ...]
    level: float


def assemble(evidence: Evidence) -> TrackDiagnosis:
    """The record of a track."""
    columns, level = evidence.columns, evidence.level
    nis, found = judge_innovations(evidence.nis, columns, evidence.innovations, level)
    if evidence.angles is not None and evidence.angles.proven.any():
        nis = nis.called("angle_wrap_bug")
    nees = evidence.nees
    errors: tuple[StateOffset, ...] = ()
    if nees is not None:
        nees, errors = judge_errors(nees, columns, level)
        nis, nees = reconciled(nis, nees, errors)
    verdict = combined(nis.word.verdict, None if nees is None else nees.word.verdict)
    biases = _innovation_biases(evidence, found.offsets) + _state_biases(evidence.log, errors)
    attribution = None if nees is None else _attribution(nees, columns)
    states = state_records(columns, evidence.log.states, _onset(nis, nees), attribution)
    log, (gap, gap_time) = evidence.log, _longest_gap(columns.time)
    return TrackDiagnosis(
        track=log.tracks[evidence.index],
        verdict=verdict,
        nis=quantity_verdict("nis", nis, columns),
        nees=None if nees is None else quantity_verdict("nees", nees, columns),
        cause=found.cause if verdict in words.SCALED else None,
        weakest_state=_weakest(verdict, nees, states, biases),
        states=states,
        biases=biases,
        whiteness=_whiteness(found),
        outliers=_outliers(nis, columns, level),
        updates=len(columns),
        tentative=len(columns) - len(evidence.nis.rows),
        repeated=log.repeated[evidence.index],
        start_time=float(columns.time[0]),
        stop_time=float(columns.time[-1]),
        longest_gap=gap,
        longest_gap_time=gap_time,
        observed=_observed(columns, log.state_names),
        notes=_notes(evidence),
        time_unit=log.time_unit,
        log_start=log.start_time,
    )


def _longest_gap(time: Floats) -> tuple[float, float | None]:
    """The longest time between two updates, and when it begins."""
    gaps = time[1:] - time[:-1]
    if not len(gaps):
        return float("nan"), None
    longest = int(gaps.argmax())
    return float(gaps[longest]), float(time[longest])


def combined(nis: str, nees: str | None) -> str:
    """The more severe verdict; after a bad start the worse of what follows."""
    if nees is None:
        return nis
    if nis == "insufficient" or nees == "insufficient":
        return nees if nis == "insufficient" else nis
    verdict = min(nis, nees, key=VERDICTS.index)
    if verdict == "startup_then_consistent" and any("pessimistic" in v for v in (nis, nees)):
        return "startup_then_pessimistic"
    return verdict


def quantity_verdict(name: str, quantity: Quantity, columns: Columns) -> QuantityVerdict:
    """The public record of a judged quantity."""
    trace, rows, time = quantity.trace, quantity.rows, columns.time
    settled = quantity.settled()
    alarm = trace.alarm
    nan = float("nan")

    def row(k: int | None) -> int | None:
        return None if k is None else int(rows[k])

    def at(k: int | None) -> float | None:
        return None if k is None else float(time[rows[k]])

    word = quantity.word
    return QuantityVerdict(
        quantity=name,
        verdict=word.verdict,
        updates=len(rows),
        segments=tuple(_segment(s, quantity, time) for s in trace.stretches),
        scale=nan if settled is None else settled.scale,
        interval=(nan, nan) if settled is None else settled.interval,
        onset_index=row(word.onset),
        onset_time=at(word.onset),
        settle_index=row(word.settle),
        settle_time=at(word.settle),
        alarm_index=row(alarm[0] if alarm else None),
        alarm_time=at(alarm[0] if alarm else None),
        alarm_onset_time=at(alarm[1] if alarm else None),
        inflation=quantity.inflation,
    )


def _segment(stretch: Stretch, quantity: Quantity, time: Floats) -> Segment:
    first = int(quantity.rows[quantity.trace.kept[stretch.start]])
    last = int(quantity.rows[quantity.trace.kept[stretch.stop - 1]])
    return Segment(
        start=first,
        stop=last + 1,
        start_time=float(time[first]),
        stop_time=float(time[last]),
        dof=stretch.dof,
        scale=stretch.scale,
        interval=stretch.interval,
        p_value=stretch.p_value,
        label=stretch.label,
    )


def _observed(columns: Columns, names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """The states that each measurement type observes."""
    mask = observed_states(columns, len(names))
    if mask is None or columns.measurement_type is None:
        return {}
    seen: dict[str, tuple[str, ...]] = {}
    for kind in dict.fromkeys(columns.measurement_type):
        if kind is not None:
            states = mask[columns.measurement_type == kind].any(axis=0)
            seen[kind] = tuple(names[i] for i in np.flatnonzero(states))
    return seen


def _onset(nis: Quantity, nees: Quantity | None) -> int | None:
    """The update at which the fault begins, of the quantity that says so first."""
    found = [int(q.rows[q.word.onset]) for q in (nis, nees) if q and q.word.onset is not None]
    return min(found, default=None)


def _attribution(nees: Quantity, columns: Columns) -> Attribution | None:
    """The split of the NEES over the states in the last stretch that is too high, else in all."""
    if nees.word.verdict not in FAILING or columns.error is None or columns.P is None:
        return None
    stretches = [s for s in nees.trace.stretches if s.label == "high"]
    kept = nees.rows[nees.trace.kept]
    rows = kept[stretches[-1].start : stretches[-1].stop] if stretches else kept
    rows = rows[components(columns.error[rows], columns.P[rows]).any(axis=1)]
    return attribute(columns.error[rows], columns.P[rows]) if len(rows) else None


def _weakest(
    verdict: str,
    nees: Quantity | None,
    states: tuple[StateDiagnosis, ...],
    biases: tuple[Bias, ...],
) -> str | None:
    """The weakest state of a track that fails; a bias without truth names its component."""
    if verdict not in FAILING:
        return None
    if nees is not None and nees.word.verdict in FAILING:
        return weakest(states)
    if verdict.startswith("startup"):
        return None
    if verdict == "biased":
        return max(biases, key=lambda b: abs(b.z)).component if biases else None
    return weakest(states)


def _incomplete(columns: Columns) -> list[str]:
    """How many vectors lack components that others of their kind have."""
    found = []
    for vectors, kinds, what in (
        (columns.innovation, columns.measurement_type, "innovation"),
        (columns.error, "state", "error"),
    ):
        if vectors is None or not np.isnan(vectors).any():
            continue
        lacking = int(incomplete(vectors, kinds).sum())
        if lacking:
            some = f"{lacking} {what}s lack" if lacking > 1 else f"1 {what} lacks"
            found.append(f"{some} components; what is left counts with its degrees of freedom.")
    return found


def _innovation_biases(evidence: Evidence, offsets: tuple[Offset, ...]) -> tuple[Bias, ...]:
    return tuple(
        Bias("innovation", o.type or None, *_component(evidence, o), o.z, o.p_value)
        for o in offsets
    )


def _component(evidence: Evidence, offset: Offset) -> tuple[str, float, str]:
    """Name, value and unit of a component: those of the state that it observes."""
    observed, types = evidence.columns.observed, evidence.columns.measurement_type
    if observed is not None:
        rows = np.arange(len(observed)) if types is None else np.flatnonzero(types == offset.type)
        seen = set(observed[rows, offset.component].tolist()) - {-1}
        if len(seen) == 1:
            state = evidence.log.states[seen.pop()]
            return state.name, offset.value, state.unit
    return f"z[{offset.component}]", offset.value, ""


def _state_biases(log: EstimatorLog, offsets: tuple[StateOffset, ...]) -> tuple[Bias, ...]:
    return tuple(
        Bias(
            "state",
            None,
            log.states[o.state].name,
            o.value,
            log.states[o.state].unit,
            o.z,
            o.p_value,
        )
        for o in offsets
    )


def _whiteness(found: InnovationFindings) -> Whiteness | None:
    c = found.correlation
    return None if c is None else Whiteness(c.lag1, c.z, c.p_value, c.pairs)


def _outliers(nis: Quantity, columns: Columns, level: float) -> tuple[Outlier, ...]:
    """Values set aside; and of a track without a change those that are extreme all the same."""
    trace = nis.trace
    if not trace.sufficient:
        return ()
    if not trace.outliers and not is_suspicious(trace, level):
        return ()
    values, dof = trace.kept_values()
    scale = robust_scale(values, dof)
    p_values = np.asarray(_distributions.chi2_sf(trace.values / scale, trace.dof))
    found = set(trace.outliers)
    if len(trace.stretches) == 1 and len(values) >= LEAST_UPDATES:
        found |= set(np.flatnonzero(p_values < level / len(values)).tolist())
    return tuple(
        Outlier(
            int(nis.rows[k]),
            float(columns.time[nis.rows[k]]),
            float(trace.values[k]),
            float(trace.dof[k]),
            float(p_values[k]),
        )
        for k in sorted(found)
    )


def _notes(evidence: Evidence) -> tuple[str, ...]:
    """Suspicions about the log, about angles, and which vectors lack components."""
    angles = [] if evidence.angles is None else _about_angles(evidence, evidence.angles)
    return (*evidence.warnings, *_incomplete(evidence.columns), *angles)


def _about_angles(evidence: Evidence, angles: Unwrapped) -> list[str]:
    time, notes = evidence.columns.time, []
    timeline = Timeline(evidence.log.start_time, evidence.log.time_unit)
    for rows, text in (
        (angles.proven, "the logged NIS is that of an innovation that was not wrapped"),
        (
            angles.harmless,
            "an innovation is logged unwrapped, but the NIS is that of the wrapped one",
        ),
        (
            angles.suspected,
            "an innovation exceeds half the period of its angle: probably not wrapped",
        ),
    ):
        if rows.any():
            count, first = int(rows.sum()), timeline.at(float(time[rows][0]))
            notes.append(f"At {count} update{'s' * (count > 1)} (first at {first}) {text}.")
    return notes
