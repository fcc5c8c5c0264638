"""The sentences of a diagnosis, with their numbers."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from trackmetrics._format import number, p_value
from trackmetrics.diagnostics.angles import WrappingCheck
from trackmetrics.diagnostics.results import (
    Bias,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
)
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.logs.columns import Columns, Floats, rows_missing_components

MEANINGS = {
    "angle_wrap_bug": "innovations of an angle are not wrapped",
    "biased": "the mean error is not zero",
    "pessimistic": "the covariance is too large",
    "partly_pessimistic": "the covariance is too large in part of the track",
    "outliers": "consistent apart from isolated outliers",
    "non_white": "the innovations are correlated in time",
    "consistent": "the errors are as large as the covariance says",
    "insufficient": "too few updates to decide",
}
"""Meaning of the verdicts that do not depend on the order of the segments."""

DECISIONS = {
    "start test": "the test of the first updates finds them too large",
    "end test": "the test of the last updates finds them too large",
    "correlation": "decided by the size of innovations that are correlated in time",
    "size and correlation": "decided by size and correlation of the innovations jointly, neither "
    "being significant alone",
    "nis": "decided together with the NIS",
    "nees": "decided together with the NEES",
}
"""How a verdict was decided if not by the segments; bias and angles have their own sentences."""


def headline(track: str, verdict: str, nis: QuantityVerdict, nees: QuantityVerdict | None) -> str:
    """The verdict on the track and what it means."""
    meaning = MEANINGS.get(verdict)
    if meaning is None:
        given = [q for q in (nis, nees) if q is not None]
        deciding = next((q for q in given if q.verdict == verdict), None)
        meaning = _combined_meaning() if deciding is None else _meaning(verdict, deciding)
    return f"{track}: {verdict.replace('_', ' ')}, {meaning}."


def _combined_meaning() -> str:
    """Of a start-up seen by one quantity and a covariance that is too large by the other."""
    return "optimistic during start-up by one quantity, pessimistic by the other"


def _meaning(verdict: str, quantity: QuantityVerdict) -> str:
    """The meaning of a verdict, in agreement with the segments of the quantity that decides it."""
    labels = [s.label for s in quantity.segments]
    if verdict == "late_divergence":
        return _late(labels)
    if verdict == "optimistic":
        is_throughout = "consistent" not in labels and "pessimistic" not in labels
        everywhere = is_throughout or quantity.decided_by != "segments"
        return "the covariance is too small" + ("" if everywhere else " in most of the track")
    if verdict == "transient":
        until_end = labels[-1:] == ["optimistic"]
        return "temporarily optimistic" + (", recovering at the end" if until_end else "")
    rest = [label for i, label in enumerate(labels) if "optimistic" in labels[:i]]
    if "pessimistic" not in rest:
        return "optimistic during start-up only"
    if "consistent" not in rest:
        return "optimistic during start-up, then pessimistic"
    return "optimistic during start-up, then pessimistic in part of the track"


def _late(labels: Sequence[str]) -> str:
    """The labels of the segments in their order, each run of equal ones once."""
    runs = [label for label, _ in groupby(labels)]
    if runs == ["optimistic"]:
        return "optimistic from the start, and much more so until the end"
    if len(runs) < 2:
        return "optimistic until the end"
    first = f"{runs[0]} at first" if len(runs) == 2 else runs[0]
    return ", then ".join([first, *runs[1:]]) + " until the end"


def outliers_first(outliers: tuple[Outlier, ...], timeline: Timeline) -> str:
    """How many outliers there are, and their times."""
    if not outliers:
        return ""
    shown = ", ".join(timeline.at(o.time) for o in outliers[:3])
    more = f" and {len(outliers) - 3} more" if len(outliers) > 3 else ""
    many = "outliers" if len(outliers) > 1 else "outlier"
    return f"{len(outliers)} {many} (at {shown}{more})."


def quantity(verdict: QuantityVerdict, timeline: Timeline) -> str:
    """The segments, times and verdict of the NIS or the NEES."""
    name = verdict.quantity.upper()
    if verdict.verdict == "insufficient":
        return f"{name}: {verdict.updates} values are too few to judge." if verdict.updates else ""
    text = f"{name}: " + "; ".join(_segment(s, timeline) for s in verdict.segments)
    if verdict.decided_by in DECISIONS:
        text += f"; {verdict.verdict.replace('_', ' ')}: {DECISIONS[verdict.decided_by]}"
    if verdict.onset_time is not None:
        text += f"; the fault begins at {timeline.at(verdict.onset_time)}"
    if verdict.settling_time is not None:
        text += f"; settled from {timeline.at(verdict.settling_time)}"
    if verdict.alarm_time is not None:
        alarm = timeline.at(verdict.alarm_time)
        text += f"; an online CUSUM would have raised an alarm at {alarm}"
    return text + "."


def _segment(segment: Segment, timeline: Timeline) -> str:
    low, high = segment.interval
    begin = timeline.value(segment.start_time)
    but = " apart from one outlier" if segment.has_spike else ""
    return (
        f"{begin} to {timeline.at(segment.stop_time)} {segment.label}{but} "
        f"(scale {number(segment.scale)} [{number(low)}, {number(high)}], "
        f"{_equals(p_value(segment.p_value))})"
    )


def _equals(p: str) -> str:
    return f"p {p}" if p.startswith("<") else f"p = {p}"


def advice(settled: QuantityVerdict) -> str:
    """The factor by which to multiply the covariance, if the settled part is inconsistent."""
    if not any(s.label != "consistent" for s in settled.segments):
        return ""
    low, high = settled.interval
    if low <= 1.0 <= high:
        return ""
    what = "S" if settled.quantity == "nis" else "P"
    return (
        f"In the settled part (its longest segment that is not optimistic, else the longest) "
        f"{what} should be multiplied by "
        f"{number(settled.scale)} [{number(low)}, {number(high)}]."
    )


def cause(name: str | None) -> str:
    """The probable cause."""
    return f"Probable cause: {name}." if name else ""


def bias(found: Bias) -> str:
    """One bias."""
    where = f"{found.measurement_type} " if found.measurement_type else ""
    what = "innovation" if found.kind == "innovation" else "error"
    value = f"{number(found.value)} {found.unit}".strip()
    return f"The mean {what} of {where}{found.component} is {value} (z = {number(found.z)})."


def weakest_state(name: str | None, states: tuple[StateDiagnosis, ...]) -> str:
    """The weakest state and why it is."""
    if name is None:
        return ""
    state = next((s for s in states if s.state == name), None)
    if state is None:
        return f"The weakest state is {name}."
    if state.nees_share == state.nees_share:
        return f"The weakest state is {name}: {state.nees_share:.0%} of the NEES where it fails."
    if state.is_observed is False:
        return f"The weakest state is {name}: no update observes it."
    growth = number(state.peak_growth)
    return f"The weakest state is {name}: its claimed standard deviation grew {growth} times."


def updates(
    count: int, without_nis: int, repeated: int, gap: tuple[float, float | None], timeline: Timeline
) -> str:
    """The number of updates, and the longest gap with the time of its begin."""
    text = f"{count} update{'s' * (count != 1)}"
    extra = [f"{without_nis} without a NIS"] if without_nis else []
    if repeated:
        extra.append(f"{repeated} repeated rows dropped")
    if extra:
        text += f" ({', '.join(extra)})"
    if gap[1] is not None:
        text += f"; longest gap {timeline.duration(gap[0])}, from {timeline.at(gap[1])}"
    return text + "."


# -- notes


def incomplete_vectors(columns: Columns) -> list[str]:
    """How many vectors lack components that others of their kind have."""
    found = []
    for vectors, kinds, what in (
        (columns.innovation, columns.measurement_type, "innovation"),
        (columns.error, "state", "error"),
    ):
        if vectors is None or not np.isnan(vectors).any():
            continue
        lacking = int(rows_missing_components(vectors, kinds).sum())
        if lacking:
            some = f"{lacking} {what}s lack" if lacking > 1 else f"1 {what} lacks"
            found.append(f"{some} components; the others count, with their own degrees of freedom.")
    return found


def wrapping(check: WrappingCheck, times: Floats, timeline: Timeline) -> list[str]:
    """The updates whose logged innovations exceed half the period of an angle."""
    notes = []
    for rows, text in (
        (check.proven, "the logged NIS is that of an innovation that was not wrapped"),
        (
            check.harmless,
            "an innovation is logged unwrapped, but the NIS is that of the wrapped one",
        ),
        (
            check.suspected,
            "an innovation exceeds half the period of its angle: probably not wrapped",
        ),
    ):
        if rows.any():
            count, first = int(rows.sum()), timeline.at(float(times[rows][0]))
            notes.append(f"At {count} update{'s' * (count > 1)} (first at {first}) {text}.")
    return notes
