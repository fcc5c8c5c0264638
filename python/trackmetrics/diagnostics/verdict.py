"""The verdict on a track: every rule that decides one, in the order in which they are applied.

1. :func:`judge` - from the labels of the segments of a trace, then from the tests of its ends;
2. :func:`judge_nis` - the NIS with the bias and the correlation of its innovations;
3. :func:`judge_nees` - the NEES with the biases of its errors;
4. :func:`reconcile_nis_and_nees` - each in the light of the other;
5. :func:`combined_verdict` - the more severe of the two.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics.bias import explains_most
from trackmetrics.diagnostics.innovations import Innovations
from trackmetrics.diagnostics.results import VERDICTS, Bias, InnovationCorrelation, Segment
from trackmetrics.diagnostics.segmentation import SegmentedTrace, cut_end
from trackmetrics.diagnostics.thresholds import (
    BEFORE_FAULT_SHARE,
    MAX_FADED_SHARE,
    MAX_P_BEFORE_FAULT,
    MAX_P_SIZE,
    MAX_P_TOO_LARGE,
    MAX_SCALE_BEFORE_LATE,
    MAX_STARTUP_SHARE,
    MIN_LATE_GROWTH,
    MIN_LATE_SHARE,
    MIN_NEES_SCALE_OF_BIAS,
    MIN_OPTIMISTIC_SHARE,
    MIN_P_RECOVERED,
    MIN_PESSIMISTIC_SHARE,
    MIN_SCALE_RATIO,
    MIN_SEGMENT_UPDATES,
)
from trackmetrics.diagnostics.whiteness import sign


@dataclass(frozen=True)
class TraceVerdict:
    """A verdict; onset and settling count the inliers of the trace."""

    verdict: str
    onset: int | None = None
    settling: int | None = None
    decided_by: str = "segments"


CONSISTENT = TraceVerdict("consistent")
INSUFFICIENT = TraceVerdict("insufficient")


@dataclass(frozen=True, eq=False)
class JudgedTrace:
    """A trace with its verdict so far."""

    segmented: SegmentedTrace
    verdict: TraceVerdict
    shown: SegmentedTrace
    """The same with the beginning or the end as a segment, where its own test decides."""
    from_segments: TraceVerdict
    """The verdict without the tests of the ends."""

    @property
    def name(self) -> str:
        """The name of the verdict."""
        return self.verdict.verdict

    @property
    def is_end_only(self) -> bool:
        """Whether an end of the track is too large although the segments are not."""
        is_end = self.shown is not self.segmented
        return is_end and not self.name.endswith("pessimistic")

    def renamed(self, verdict: str, decided_by: str) -> "JudgedTrace":
        """The same with another verdict; onset and settling stay."""
        return replace(self, verdict=replace(self.verdict, verdict=verdict, decided_by=decided_by))

    def replaced(self, verdict: TraceVerdict) -> "JudgedTrace":
        """The same with another verdict, onset and settling included; ends are not shown."""
        return replace(self, verdict=verdict, shown=self.segmented)

    def without_end_tests(self) -> "JudgedTrace":
        """The same by its segments alone."""
        return self.replaced(self.from_segments)

    def scale(self) -> float:
        """The scale of all inliers together."""
        total, dof = self.segmented.sums()
        return total / dof


# -- 1. from segments and ends


def judge(segmented: SegmentedTrace, alpha: float) -> JudgedTrace:
    """The verdict on a trace by its segments and the tests of its ends."""
    if not segmented.segments:
        return JudgedTrace(segmented, INSUFFICIENT, segmented, INSUFFICIENT)
    by_segments = _from_segments(segmented)
    by_ends, shown = _from_ends(segmented, by_segments, alpha)
    plain = _without_recovery(segmented, by_segments)
    return JudgedTrace(segmented, _without_recovery(segmented, by_ends), shown, plain)


def _num_updates(segmented: SegmentedTrace, label: str, first: int = 0) -> int:
    """How many updates the segments with this label have, from the ``first`` one on."""
    pairs = zip(segmented.segments[first:], segmented.lengths[first:], strict=True)
    return sum(length for segment, length in pairs if segment.label == label)


def _from_segments(segmented: SegmentedTrace) -> TraceVerdict:
    segments, n = segmented.segments, segmented.edges[-1]
    labels = {s.label for s in segments}
    if labels == {"consistent"}:
        has_outliers = segmented.outliers.removed or segmented.outliers.spike_segments
        return TraceVerdict("outliers") if has_outliers else CONSISTENT
    if "optimistic" not in labels:
        most = _num_updates(segmented, "pessimistic") >= MIN_PESSIMISTIC_SHARE * n
        return TraceVerdict("pessimistic" if most else "partly_pessimistic")
    if len(segments) == 1:
        return TraceVerdict("optimistic")
    if segments[-1].label == "optimistic":
        return _optimistic_to_the_end(segmented)
    return _optimistic_before_the_end(segmented)


def _optimistic_to_the_end(segmented: SegmentedTrace) -> TraceVerdict:
    """Late, unless the track was too large from the start."""
    segments, start = segmented.segments, segmented.edges[-2]
    last = segments[-1]
    first = next(i for i, s in enumerate(segments) if s.label == "optimistic")
    if first and not _are_too_large(segments[:first]):
        return _optimistic_after_consistent(segmented, first)
    if len(segments) == 2 or all(s.label == "optimistic" for s in segments):
        has_grown = last.scale > MIN_LATE_GROWTH * max(s.scale for s in segments[:-1])
        return TraceVerdict("late_divergence", start) if has_grown else TraceVerdict("optimistic")
    earlier = zip(segments[:-1], segmented.lengths[:-1], strict=True)
    fell = any(
        s.scale < MAX_SCALE_BEFORE_LATE * last.scale and length >= MIN_SEGMENT_UPDATES
        for s, length in earlier
    )
    if fell and start >= MIN_LATE_SHARE * segmented.edges[-1]:
        return TraceVerdict("late_divergence", start)
    return TraceVerdict("optimistic")


def _optimistic_after_consistent(segmented: SegmentedTrace, first: int) -> TraceVerdict:
    """Late from the last time on that it became too large; transient, if it has nearly faded."""
    segments, edges = segmented.segments, segmented.edges
    if segments[-1].scale < MAX_FADED_SHARE * max(s.scale for s in segments):
        return TraceVerdict("transient", edges[first])
    onset = len(segments) - 1
    while onset and segments[onset - 1].label == "optimistic":
        onset -= 1
    return TraceVerdict("late_divergence", edges[onset])


def _are_too_large(segments: Sequence[Segment]) -> bool:
    """Whether these segments together are materially too large."""
    return _is_too_large(sum(s.scale * s.dof for s in segments), sum(s.dof for s in segments))


def _is_too_large(total: float, dof: float, max_p: float = MAX_P_TOO_LARGE) -> bool:
    return total > MIN_SCALE_RATIO * dof and bool(_distributions.chi2_sf(total, dof) < max_p)


def _optimistic_before_the_end(segmented: SegmentedTrace) -> TraceVerdict:
    """A bad start, optimistic in most of the track, or transient."""
    segments, edges, n = segmented.segments, segmented.edges, segmented.edges[-1]
    optimistic = [i for i, s in enumerate(segments) if s.label == "optimistic"]
    after = optimistic[-1] + 1
    settling = edges[after]
    if optimistic == list(range(after)) and settling <= MAX_STARTUP_SHARE * n:
        low = _num_updates(segmented, "pessimistic", after)
        is_low = low > 0 and low >= MIN_PESSIMISTIC_SHARE * (n - settling)
        rest = "pessimistic" if is_low else "consistent"
        return TraceVerdict(f"startup_then_{rest}", settling=settling)
    if _num_updates(segmented, "optimistic") >= MIN_OPTIMISTIC_SHARE * n:
        return TraceVerdict("optimistic")
    return TraceVerdict("transient", edges[optimistic[0]])


def _from_ends(
    segmented: SegmentedTrace, found: TraceVerdict, alpha: float
) -> tuple[TraceVerdict, SegmentedTrace]:
    """The verdict by a short beginning or end, where the segments give no time of a fault.

    A track that is too large as a whole may be so by its ends. The beginning or end becomes a
    segment of its own.
    """
    several = len(segmented.segments) > 1
    if several and "optimistic" in {s.label for s in segmented.segments}:
        return found, segmented
    ends = segmented.ends
    at_end = ends.end_p < alpha and ends.end_length >= MIN_SEGMENT_UPDATES
    if not at_end and not ends.start_p < alpha:
        return found, segmented
    shown = cut_end(segmented, at_start=not at_end, alpha=alpha)
    rest = shown.segments[:-1] if at_end else shown.segments[1:]
    is_high = found.verdict == "optimistic"
    if is_high and (_are_too_large(rest) or any(s.label == "optimistic" for s in rest)):
        return found, segmented
    if at_end:
        return TraceVerdict("late_divergence", shown.edges[-2], decided_by="end test"), shown
    then = "pessimistic" if _is_pessimistic_after_start(found, shown) else "consistent"
    return TraceVerdict(f"startup_then_{then}", None, shown.edges[1], "start test"), shown


def _is_pessimistic_after_start(found: TraceVerdict, shown: SegmentedTrace) -> bool:
    low, rest = _num_updates(shown, "pessimistic", 1), shown.edges[-1] - shown.edges[1]
    return low > 0 and ("pessimistic" in found.verdict or low >= MIN_PESSIMISTIC_SHARE * rest)


def _without_recovery(segmented: SegmentedTrace, found: TraceVerdict) -> TraceVerdict:
    """A late fault must last to the very end; otherwise it was transient."""
    if found.verdict != "late_divergence" or found.onset is None:
        return found
    values, dof = segmented.pair
    length = len(values) - found.onset
    end = max(2, min(5, length // 3))
    p = _distributions.chi2_sf(values[-end:].sum(), dof[-end:].sum())
    if length > end and p > MIN_P_RECOVERED:
        return replace(found, verdict="transient")
    return found


# -- 2. the NIS and its innovations


def judge_nis(
    nis: JudgedTrace,
    innovations: Innovations,
    clean: Innovations,
    biases: Sequence[Bias],
    correlation: InnovationCorrelation,
    alpha: float,
) -> JudgedTrace:
    """The verdict on the NIS in the light of the innovations of its settled part.

    ``clean`` are the innovations minus their significant biases.
    """
    if biases:
        is_biased = nis.is_end_only or _is_biased(nis.name, innovations, clean)
        return nis.renamed("biased", "bias") if is_biased else nis
    if nis.name != "consistent":
        return nis
    if sign(correlation, alpha):
        return nis.renamed(_verdict_by_size(*clean.sums), "correlation")
    verdict = _verdict_by_size_and_correlation(clean, correlation, alpha)
    return nis if verdict is None else nis.renamed(verdict, "size and correlation")


def _is_biased(verdict: str, innovations: Innovations, clean: Innovations) -> bool:
    """Whether a bias is the verdict: not if that says more, or the bias explains too little."""
    if verdict == "optimistic":
        return explains_most(innovations.scale, clean.scale)
    return verdict in ("consistent", "outliers", "transient", "partly_pessimistic")


def _verdict_by_size(total: float, dof: float) -> str:
    """The verdict on innovations that are correlated in time: by their size if significant."""
    if _distributions.chi2_sf(total, dof) < MAX_P_SIZE / 2:
        return "optimistic"
    if _distributions.chi2_cdf(total, dof) < MAX_P_SIZE / 2:
        return "pessimistic"
    return "non_white"


def _verdict_by_size_and_correlation(
    innovations: Innovations, correlation: InnovationCorrelation, alpha: float
) -> str | None:
    """The verdict by size and correlation jointly, where neither is significant alone.

    Both are standard normal and independent for a consistent filter. A wrong noise covariance moves
    both; their sum and their difference over the root of 2 are tested, since either sign may come
    with either size.
    """
    total, dof = innovations.sums
    if 1 / MIN_SCALE_RATIO <= total / dof <= MIN_SCALE_RATIO:
        return None
    size = float(_distributions.chi2_to_z(np.array([total]), np.array([dof]))[0])
    z = (abs(size) + abs(correlation.z)) / 2**0.5
    if 2 * _distributions.normal_p_value(z) > alpha:
        return None
    return "optimistic" if size > 0 else "pessimistic"


# -- 3. the NEES and its errors


def judge_nees(nees: JudgedTrace, is_explained_by_bias: bool) -> JudgedTrace:
    """The verdict on the NEES, whether or not biases of the states explain it."""
    open_to_bias = ("consistent", "optimistic", "transient", "outliers", "partly_pessimistic")
    if is_explained_by_bias and nees.name in open_to_bias:
        return nees.renamed("biased", "bias")
    return nees


# -- 4. NIS and NEES together


def reconcile_nis_and_nees(
    nis: JudgedTrace, nees: JudgedTrace, before_bias: JudgedTrace, has_state_bias: bool
) -> tuple[JudgedTrace, JudgedTrace]:
    """NIS and NEES, each in the light of the other.

    - A verdict by the end of one gives way to a bias that the other shows: a filter absorbs a bias
      as it starts.
    - A mean innovation is no bias if the errors are far too large and have no mean; a mean error is
      none if both NIS and NEES are too small (the NEES is then judged as ``before_bias``).
    - Innovations that are correlated in time are judged by the size of the errors, if significant.
    - A NIS that diverges late is optimistic if the NEES was so from the start.
    """
    optimistic = TraceVerdict("optimistic", decided_by="nees")
    names = nis.name, nees.name
    if nees.name == "biased" and nis.is_end_only:
        return nis.without_end_tests(), nees
    if nis.name == "biased" and nees.is_end_only:
        return nis, nees.without_end_tests()
    if names == ("pessimistic", "biased") and nees.scale() < 1:
        return nis, _without_bias(nees, before_bias)
    if names == ("biased", "optimistic") and not has_state_bias:
        is_large = nees.scale() > MIN_NEES_SCALE_OF_BIAS
        return (nis.replaced(optimistic) if is_large else nis), nees
    if names == ("non_white", "consistent"):
        verdict = _verdict_by_size(*nees.segmented.sums())
        return (nis if verdict == "non_white" else nis.renamed(verdict, "nees")), nees
    if names == ("late_divergence", "optimistic") and _is_too_large_before(nees, nis):
        return nis.replaced(optimistic), nees
    return nis, nees


def _without_bias(nees: JudgedTrace, before_bias: JudgedTrace) -> JudgedTrace:
    """The verdict before the bias, if it says no more than the NIS does; else consistent."""
    if before_bias.name in ("consistent", "outliers", "partly_pessimistic"):
        return before_bias
    return nees.replaced(replace(CONSISTENT, decided_by="nis"))


def _is_too_large_before(nees: JudgedTrace, nis: JudgedTrace) -> bool:
    """Whether the NEES was too large before the onset in the NIS: then no fault began there."""
    if nis.verdict.onset is None:
        return False
    onset = int(nis.segmented.rows[nis.verdict.onset])
    # The NEES may rise a little before the NIS does.
    before = nees.segmented.rows < onset * BEFORE_FAULT_SHARE
    values, dof = (column[before] for column in nees.segmented.pair)
    return _is_too_large(float(values.sum()), float(dof.sum()), MAX_P_BEFORE_FAULT)


# -- 5. the track


def combined_verdict(nis: str, nees: str | None) -> str:
    """The more severe verdict; after a bad start the worse of what follows."""
    if nees is None:
        return nis
    if nis == "insufficient" or nees == "insufficient":
        return nees if nis == "insufficient" else nis
    verdict = min(nis, nees, key=VERDICTS.index)
    if verdict == "startup_then_consistent" and any("pessimistic" in v for v in (nis, nees)):
        return "startup_then_pessimistic"
    return verdict
