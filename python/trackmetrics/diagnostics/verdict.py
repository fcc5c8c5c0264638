"""From the labels of stretches, in their order, to one word for the whole track."""

from dataclasses import dataclass

from trackmetrics import _distributions
from trackmetrics.diagnostics.trace import LEAST_SEGMENT, MATERIAL, Stretch, Trace
from trackmetrics.logs.columns import Floats

STARTUP = 0.5
"""A bad start is over within this share of the track."""
LATE = 0.4
"""A late fault begins after this share, where the track before it is too large as well."""
MOSTLY = 0.5
"""Share of the updates that must be low for "pessimistic", else "partly pessimistic"."""
NEARLY_ALL = 0.6
"""Share of the updates that must be high for "optimistic" although something is not."""
STEP = 0.6
"""A late fault that follows a bad start comes after a stretch with less than this of its scale."""
FADING = 0.2
"""A last stretch with less than this share of the largest scale is the tail of what is over."""
GROWTH = 5.0
"""Factor by which the last stretch must exceed one that is too large already, to be late."""
DOUBTFUL = 0.001
"""A beginning whose chance is below this is not honest enough for a fault to be late."""


@dataclass(frozen=True)
class Word:
    """The verdict on a trace; onset and settling count its values, outliers included."""

    verdict: str
    onset: int | None = None
    settle: int | None = None
    by_end: bool = False
    """Whether only a short beginning or end says so, not the stretches."""


def describe(trace: Trace, level: float) -> Word:
    """The verdict on a trace that has been cut."""
    if not trace.sufficient:
        return Word("insufficient")
    word = _from_ends(trace, _from_stretches(trace), level)
    word = _recovered(trace, word)
    verdict = word.verdict
    if trace.outliers and verdict == "consistent":
        verdict = "outliers"
    return Word(verdict, _place(trace, word.onset), _place(trace, word.settle), word.by_end)


def _place(trace: Trace, kept: int | None) -> int | None:
    return None if kept is None else int(trace.kept[kept])


def _count(stretches: tuple[Stretch, ...], label: str) -> int:
    return sum(len(s) for s in stretches if s.label == label)


def _from_stretches(trace: Trace) -> Word:
    stretches, n = trace.stretches, len(trace.kept)
    labels = {s.label for s in stretches}
    if labels == {"consistent"}:
        return Word("consistent")
    if "high" not in labels:
        low = _count(stretches, "low") >= MOSTLY * n
        return Word("pessimistic" if low else "partly_pessimistic")
    if len(stretches) == 1:
        return Word("optimistic")
    if stretches[-1].label == "high":
        return _high_to_the_end(stretches, n)
    return _high_before(stretches, n)


def _high_to_the_end(stretches: tuple[Stretch, ...], n: int) -> Word:
    """Late, unless the track was too large from the start."""
    last = stretches[-1]
    first = next(i for i, s in enumerate(stretches) if s.label == "high")
    beginning = stretches[:first] or stretches[:1]
    if first and not _too_large(beginning):
        return _high_after_honest(stretches, first)
    if len(stretches) == 2 or all(s.label == "high" for s in stretches):
        grown = last.scale > GROWTH * max(s.scale for s in stretches[:-1])
        return Word("late_divergence", onset=last.start) if grown else Word("optimistic")
    fell = any(s.scale < STEP * last.scale and len(s) >= LEAST_SEGMENT for s in stretches[:-1])
    if fell and last.start >= LATE * n:
        return Word("late_divergence", onset=last.start)
    return Word("optimistic")


def _high_after_honest(stretches: tuple[Stretch, ...], first: int) -> Word:
    """Late from the last time on that it became too large; over, if it has nearly faded."""
    last = stretches[-1]
    if last.scale < FADING * max(s.scale for s in stretches):
        return Word("transient", onset=stretches[first].start)
    onset = last.start
    for stretch in reversed(stretches):
        if stretch.label != "high":
            break
        onset = stretch.start
    return Word("late_divergence", onset=onset)


def _too_large(stretches: tuple[Stretch, ...]) -> bool:
    """Whether these stretches together are materially too large, if only doubtfully so."""
    return _exceeds(sum(s.sum for s in stretches), sum(s.dof for s in stretches))


def _exceeds(total: float, dof: float) -> bool:
    return total > MATERIAL * dof and bool(_distributions.chi2_sf(total, dof) < DOUBTFUL)


def _high_before(stretches: tuple[Stretch, ...], n: int) -> Word:
    high = [i for i, s in enumerate(stretches) if s.label == "high"]
    leading = high == list(range(len(high)))
    settle = stretches[high[-1]].stop
    if leading and settle <= STARTUP * n:
        rest = stretches[high[-1] + 1 :]
        low = _count(rest, "low") >= MOSTLY * (n - settle) and _count(rest, "low") > 0
        return Word("startup_then_pessimistic" if low else "startup_then_consistent", settle=settle)
    if _count(stretches, "high") >= NEARLY_ALL * n:
        return Word("optimistic")
    return Word("transient", onset=stretches[high[0]].start)


def _from_ends(trace: Trace, word: Word, level: float) -> Word:
    """What a short beginning or end says where the stretches say nothing of a time.

    A track that is too large as a whole may owe it to its ends.
    """
    if len(trace.stretches) > 1 and "high" in {s.label for s in trace.stretches}:
        return word
    if word.verdict not in ("consistent", "pessimistic", "partly_pessimistic", "optimistic"):
        return word
    n, values = len(trace.kept), trace.kept_values()
    high = word.verdict == "optimistic"
    if trace.end_p < level and trace.end_length >= LEAST_SEGMENT:
        onset = n - trace.end_length
        if not (high and _rest_too_large(*values, slice(onset))):
            return Word("late_divergence", onset=onset, by_end=True)
    elif trace.start_p < level and not (
        high and _rest_too_large(*values, slice(trace.start_length, None))
    ):
        then = "pessimistic" if "pessimistic" in word.verdict else "consistent"
        return Word(f"startup_then_{then}", settle=trace.start_length, by_end=True)
    if word.verdict == "consistent" and any(s.spike for s in trace.stretches):
        return Word("outliers")
    return word


def _rest_too_large(values: Floats, dof: Floats, rest: slice) -> bool:
    return _exceeds(float(values[rest].sum()), float(dof[rest].sum()))


def _recovered(trace: Trace, word: Word) -> Word:
    """A late fault must last to the very end; otherwise it was transient."""
    if word.verdict != "late_divergence" or word.onset is None:
        return word
    values, dof = trace.kept_values()
    length = len(values) - word.onset
    end = max(2, min(5, length // 3))
    if length > end and _distributions.chi2_sf(values[-end:].sum(), dof[-end:].sum()) > 0.05:
        return Word("transient", onset=word.onset, by_end=word.by_end)
    return word
