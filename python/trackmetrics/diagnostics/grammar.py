"""From the labels of stretches, in their order, to one word for the whole track."""

from dataclasses import dataclass

from trackmetrics.diagnostics import chisquare
from trackmetrics.diagnostics.series import LEAST_SEGMENT, Stretch, Trace

STARTUP = 0.5
"""A bad start is over within this share of the track."""
LATE = 0.4
"""A late fault begins after this share, where the track before it is too large as well."""
MOSTLY = 0.5
"""Share of the updates that must be low for "pessimistic", else "partly pessimistic"."""
NEARLY_ALL = 0.6
"""Share of the updates that must be high for "optimistic" although something is not."""
STEP = 0.6
"""A late fault follows a stretch with less than this share of its scale."""
GROWTH = 2.5
"""Factor by which the last of all-high stretches must exceed the one before to be late."""


@dataclass(frozen=True)
class Word:
    """The verdict on a trace; onset and settling count its values, outliers included."""

    verdict: str
    onset: int | None = None
    settle: int | None = None


def describe(trace: Trace, level: float) -> Word:
    """The verdict on a trace that has been cut."""
    if not trace.sufficient:
        return Word("insufficient")
    word = _from_ends(trace, _from_stretches(trace), level)
    word = _recovered(trace, word)
    verdict = word.verdict
    if trace.outliers and verdict == "consistent":
        verdict = "outliers"
    return Word(verdict, _place(trace, word.onset), _place(trace, word.settle))


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
    last, before = stretches[-1], stretches[-2]
    late = Word("late_divergence", onset=last.start)
    if all(s.label == "high" for s in stretches):
        return late if last.scale > GROWTH * before.scale else Word("optimistic")
    if before.label == "high":
        return late if last.start >= LATE * n else Word("optimistic")
    smaller = any(s.scale < STEP * last.scale and len(s) >= LEAST_SEGMENT for s in stretches[:-1])
    return late if smaller or last.start >= LATE * n else Word("optimistic")


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
    """What a short beginning or end says where the stretches see nothing too large."""
    if word.verdict not in ("consistent", "pessimistic", "partly_pessimistic"):
        return word
    if trace.end_p < level and trace.end_length >= LEAST_SEGMENT:
        return Word("late_divergence", onset=len(trace.kept) - trace.end_length)
    if trace.start_p < level:
        then = "consistent" if word.verdict == "consistent" else "pessimistic"
        return Word(f"startup_then_{then}", settle=trace.start_length)
    if word.verdict == "consistent" and any(s.spike for s in trace.stretches):
        return Word("outliers")
    return word


def _recovered(trace: Trace, word: Word) -> Word:
    """A late fault must last to the very end; otherwise it was transient."""
    if word.verdict != "late_divergence" or word.onset is None:
        return word
    values, dof = trace.kept_values()
    length = len(values) - word.onset
    end = max(2, min(5, length // 3))
    if length > end and chisquare.upper_tail(values[-end:].sum(), dof[-end:].sum()) > 0.05:
        return Word("transient", onset=word.onset)
    return word
