"""The findings of a diagnosis in plain English, a sentence or two each, with their numbers."""

from trackmetrics.diagnostics.records import (
    Bias,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
)
from trackmetrics.diagnostics.timeline import Timeline

MEANINGS = {
    "angle_wrap_bug": "its angles are not wrapped",
    "late_divergence": "honest at first, then wrong to the end",
    "startup_then_consistent": "a bad start, honest afterwards",
    "startup_then_pessimistic": "a bad start, then a covariance that is too large",
    "biased": "the mean of its errors is not zero",
    "optimistic": "its covariance is too small",
    "transient": "it fails for a while and recovers",
    "pessimistic": "its covariance is too large",
    "partly_pessimistic": "its covariance is too large in part of the track",
    "outliers": "honest apart from them",
    "non_white": "its innovations are correlated in time",
    "consistent": "its errors are as large as its covariance says",
    "insufficient": "there is too little to judge it by",
}


def number(value: float) -> str:
    """Three digits, without an exponent where that reads well."""
    if value != value or value in (float("inf"), float("-inf")):
        return str(value)
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
        return text
    return f"{value:.1e}"


def outliers_first(outliers: tuple[Outlier, ...], timeline: Timeline) -> str:
    """How many outliers, and when."""
    if not outliers:
        return ""
    shown = ", ".join(timeline.at(o.time) for o in outliers[:3])
    more = f" and {len(outliers) - 3} more" if len(outliers) > 3 else ""
    many = "outliers" if len(outliers) > 1 else "outlier"
    return f"{len(outliers)} {many} (at {shown}{more})."


def quantity(verdict: QuantityVerdict, timeline: Timeline) -> str:
    """A sentence or two on the NIS or the NEES."""
    name = verdict.quantity.upper()
    if verdict.verdict == "insufficient":
        return f"{name}: {verdict.updates} values are too few to judge." if verdict.updates else ""
    text = f"{name}: " + "; ".join(_segment(s, timeline) for s in verdict.segments)
    if verdict.onset_time is not None:
        text += f"; the fault begins at {timeline.at(verdict.onset_time)}"
    if verdict.settle_time is not None:
        text += f"; settled from {timeline.at(verdict.settle_time)}"
    if verdict.alarm_time is not None:
        text += f"; an online monitor would have called at {timeline.at(verdict.alarm_time)}"
    return text + "."


_SIDES = {"high": "too large", "low": "too small", "consistent": "as claimed"}


def _p_value(p: float) -> str:
    """A probability; below the smallest float there is only a bound."""
    return f"p = {number(p)}" if p > 0 else "p < 1e-300"


def _segment(segment: Segment, timeline: Timeline) -> str:
    low, high = segment.interval
    begin = timeline.count(segment.start_time)
    return (
        f"{begin} to {timeline.at(segment.stop_time)} {_SIDES[segment.label]} "
        f"(scale {number(segment.scale)} [{number(low)}, {number(high)}], "
        f"{_p_value(segment.p_value)})"
    )


def advice(settled: QuantityVerdict) -> str:
    """What to multiply the covariance by, where the settled part is off."""
    if not any(s.label != "consistent" for s in settled.segments):
        return ""
    low, high = settled.interval
    if low <= 1.0 <= high:
        return ""
    what = "S" if settled.quantity == "nis" else "P"
    return (
        f"In the settled part the claimed {what} should be multiplied by "
        f"{number(settled.scale)} [{number(low)}, {number(high)}]."
    )


def bias(found: Bias) -> str:
    """One offset."""
    where = f"{found.measurement_type} " if found.measurement_type else ""
    what = "innovation" if found.kind == "innovation" else "error"
    value = f"{number(found.value)} {found.unit}".strip()
    return f"The mean {what} of {where}{found.component} is {value} (z = {number(found.z)})."


def weakest_state(name: str | None, states: tuple[StateDiagnosis, ...]) -> str:
    """The weakest state and why."""
    if name is None:
        return ""
    state = next((s for s in states if s.state == name), None)
    if state is None:
        return f"The weakest state is {name}."
    if state.share == state.share:
        return f"The weakest state is {name}: {state.share:.0%} of the NEES where it fails."
    if state.supported is False:
        return f"The weakest state is {name}: no update supports it."
    growth = number(state.peak_growth)
    return f"The weakest state is {name}: its claimed deviation grew {growth} times."


def coverage(
    updates: int, tentative: int, repeated: int, gap: tuple[float, float] | None, timeline: Timeline
) -> str:
    """How many updates, and the longest gap: how long, from when."""
    text = f"{updates} update{'s' * (updates != 1)}"
    extra = [f"{tentative} without a NIS"] if tentative else []
    if repeated:
        extra.append(f"{repeated} repeated rows dropped")
    if extra:
        text += f" ({', '.join(extra)})"
    if gap is not None:
        text += f"; longest gap {timeline.lasting(gap[0])}, from {timeline.at(gap[1])}"
    return text + "."


SCALED = ("startup_then_pessimistic", "optimistic", "pessimistic", "partly_pessimistic")
"""Verdicts that a factor on the covariance answers."""
