"""From a log to its diagnosis."""

from dataclasses import dataclass

import numpy as np

from trackmetrics import _deprecated
from trackmetrics._angles import wrap
from trackmetrics._check import number
from trackmetrics._covariances import side_by_side, valid_components
from trackmetrics.diagnostics import text
from trackmetrics.diagnostics.angles import WrappingCheck, check_wrapping, find_radian_headings
from trackmetrics.diagnostics.attribution import Attribution, attribute_nees
from trackmetrics.diagnostics.autocorrelation import nees_traces
from trackmetrics.diagnostics.bias import (
    Biases,
    innovation_biases,
    named_by_states,
    state_biases,
)
from trackmetrics.diagnostics.cause import CAUSE_VERDICTS, probable_cause
from trackmetrics.diagnostics.cusum import alarm_of_fault
from trackmetrics.diagnostics.innovations import innovations_at, subtract_biases
from trackmetrics.diagnostics.results import (
    FAILING_VERDICTS,
    InnovationCorrelation,
    QuantityVerdict,
)
from trackmetrics.diagnostics.segmentation import segment_traces
from trackmetrics.diagnostics.states import diagnose_states, states_by_type, weakest_state
from trackmetrics.diagnostics.thresholds import ALPHA, MAX_ALPHA, MIN_UPDATES_FOR_BIAS
from trackmetrics.diagnostics.timeline import Timeline
from trackmetrics.diagnostics.trace import Trace, no_trace
from trackmetrics.diagnostics.track import Diagnosis, TrackDiagnosis
from trackmetrics.diagnostics.verdict import (
    JudgedTrace,
    combined_verdict,
    judge,
    judge_nees,
    judge_nis,
    reconcile_nis_and_nees,
)
from trackmetrics.diagnostics.whiteness import innovation_correlation, sign, variance_inflation
from trackmetrics.logs.columns import Columns, Floats, Integers
from trackmetrics.logs.derived import component_periods
from trackmetrics.logs.log import EstimatorLog

NAN = float("nan")


@_deprecated.parameters(level="alpha")
def diagnose(log: EstimatorLog, *, alpha: float = ALPHA) -> Diagnosis:
    """Diagnoses each track of a log: is it consistent, since when not, and which state fails?

    Each track has a verdict for its NIS, one for its NEES if there is truth, and the more severe of
    the two. From the most to the least severe:

    ``angle_wrap_bug``
        a logged innovation of an angle lies beyond half its period, and the logged NIS is that of
        the unwrapped residual;
    ``late_divergence``
        too large from some time to the very end;
    ``startup_then_consistent``, ``startup_then_pessimistic``
        too large at the beginning only;
    ``biased``
        the mean innovation of a component or the mean error of a state explains the excess;
    ``optimistic``
        too large throughout: the covariance is too small;
    ``transient``
        too large for a while;
    ``pessimistic``, ``partly_pessimistic``
        too small in at least half, or in less, of the track: the covariance is too large;
    ``outliers``
        consistent apart from isolated values that are far too large;
    ``non_white``
        of the right size, but the innovations are correlated in time;
    ``consistent``
        none of these;
    ``insufficient``
        fewer than 4 updates or 8 degrees of freedom.

    The NIS c_k with m_k degrees of freedom is taken as s chi2(m_k) with a scale s that is constant
    in each of at most four segments, found by dynamic programming; a change point must gain more
    likelihood than the 1 - ``alpha`` quantile of the best change point of consistent data. Each
    segment is tested against s = 1. NEES is treated alike after division by its autocorrelation
    time, computed from ``A`` and ``P`` or else estimated.

    Parameters
    ----------
    log
        The log. NIS with their degrees of freedom are enough; innovations with ``S`` add bias,
        whiteness and cause, errors with ``P`` the states, ``A`` exact autocorrelation times.
    alpha
        False-alarm probability of each of the six families of tests (segments, levels, ends,
        outliers, whiteness and bias of NIS; the same of NEES), between 0 and 0.05.

    Returns
    -------
    Diagnosis
        A mapping from the names of the tracks to :class:`TrackDiagnosis`.

    Raises
    ------
    TypeError
        If ``log`` is no log.
    ValueError
        If ``alpha`` is outside its range.

    Notes
    -----
    The result is deterministic: simulations use a fixed seed, once for each pattern of degrees of
    freedom. A bias common to all sensors cannot be detected without truth. A turn to which the
    filter adapts is ``transient`` in the NIS while the state is still wrong: only the NEES shows
    it. For an estimator far from linear, chi-square is an approximation.

    References
    ----------
    Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and
    Navigation (2001), chapter 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> import numpy as np
    >>> from trackmetrics.logs import EstimatorLog
    >>> rng = np.random.default_rng(1)
    >>> nis = rng.chisquare(2, 60)
    >>> nis[40:] *= 8
    >>> d = diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2))
    >>> d["track"].verdict, d["track"].nis.onset_index
    ('late_divergence', 39)
    """
    if not isinstance(log, EstimatorLog):
        raise TypeError(
            f"log must be an EstimatorLog, got {type(log).__name__}: call "
            "EstimatorLog.from_columns(...), EstimatorLog.from_frame(...) or read_log(path)"
        )
    if not 0 < number("alpha", alpha) <= MAX_ALPHA:
        raise ValueError(f"alpha must be above 0 and at most {MAX_ALPHA}, got {alpha!r}")
    tracks = [log.columns.take(log.rows(t)) for t in range(len(log.tracks))]
    nis, nees = side_by_side(
        lambda: _judged([_nis_trace(columns) for columns in tracks], alpha),
        lambda: _judged(nees_traces(tracks, alpha), alpha),
    )
    nothing = judge(segment_traces([no_trace()], alpha)[0], alpha)
    periods = component_periods(log.columns, log.states, log.measurement_angles)
    check, warnings = check_wrapping(log, periods), find_radian_headings(log)
    found = []
    for t, columns in enumerate(tracks):
        rows, values = log.rows(t), columns.innovation
        if values is not None and periods is not None:
            values = wrap(values, periods[rows])
        of_track = None if check is None else check.of(rows)
        given = _TrackInput(log, t, columns, values, of_track, warnings, alpha)
        found.append(_diagnose_track(given, nis[t] or nothing, nees[t]))
    return Diagnosis(tuple(found), (*log.notes, *warnings))


def _judged(traces: list[Trace | None], alpha: float) -> list[JudgedTrace | None]:
    """All traces segmented in one go, each with its verdict."""
    segmented = iter(segment_traces([t for t in traces if t is not None], alpha))
    return [None if trace is None else judge(next(segmented), alpha) for trace in traces]


def _nis_trace(columns: Columns) -> Trace | None:
    """The NIS of a track without tentative updates."""
    if columns.nis is None or columns.nis_dof is None:
        return None
    usable = ~np.isnan(columns.nis)
    if columns.status is not None:
        usable &= columns.status != "tentative"
    rows = np.flatnonzero(usable)
    return Trace(columns.nis[rows], columns.nis_dof[rows], rows, columns.time[rows], is_nis=True)


@dataclass(frozen=True, eq=False)
class _TrackInput:
    """What the diagnosis of one track is made from, beside its NIS and NEES."""

    log: EstimatorLog
    index: int
    columns: Columns
    innovations: Floats | None
    """Wrapped."""
    wrapping: WrappingCheck | None
    """None if no innovation of the log is beyond half a period."""
    warnings: tuple[str, ...]
    alpha: float


def _diagnose_track(
    given: _TrackInput, nis: JudgedTrace, nees: JudgedTrace | None
) -> TrackDiagnosis:
    log, columns, alpha = given.log, given.columns, given.alpha
    nis, found = _with_innovations(nis, given)
    if given.wrapping is not None and given.wrapping.proven.any():
        nis = nis.renamed("angle_wrap_bug", "angles")
    of_states: Biases = ()
    if nees is not None:
        rows = nees.segmented.settled_rows()
        of_states, is_explained = state_biases(columns, rows, log.states, alpha)
        before = nees
        nees = judge_nees(nees, is_explained)
        nis, nees = reconcile_nis_and_nees(nis, nees, before, bool(of_states))
    verdict = combined_verdict(nis.name, None if nees is None else nees.name)
    biases = named_by_states(found.biases, columns, log.states) + of_states
    attribution = None if nees is None else _attribution(nees, columns)
    states = diagnose_states(columns, log.states, _onset(nis, nees), attribution)
    gap, gap_time = _longest_gap(columns.time)
    return TrackDiagnosis(
        track=log.tracks[given.index],
        verdict=verdict,
        nis=quantity_verdict("nis", nis),
        nees=None if nees is None else quantity_verdict("nees", nees),
        cause=found.cause if verdict in CAUSE_VERDICTS else None,
        weakest_state=weakest_state(verdict, None if nees is None else nees.name, states, biases),
        states=states,
        biases=biases,
        whiteness=found.correlation,
        outliers=nis.shown.outliers.all_reported(),
        updates=len(columns),
        updates_without_nis=len(columns) - len(nis.segmented.trace.rows),
        repeated=log.repeated[given.index],
        start_time=float(columns.time[0]),
        stop_time=float(columns.time[-1]),
        longest_gap=gap,
        longest_gap_time=gap_time,
        observed=states_by_type(columns, log.state_names),
        notes=_notes(given),
        time_unit=log.time_unit,
        log_start=log.start_time,
    )


@dataclass(frozen=True)
class _InnovationFindings:
    """Bias, correlation and cause from the innovations of the settled part."""

    biases: Biases = ()
    correlation: InnovationCorrelation | None = None
    cause: str | None = None


def _with_innovations(
    nis: JudgedTrace, given: _TrackInput
) -> tuple[JudgedTrace, _InnovationFindings]:
    """The verdict on the NIS in the light of the innovations of its settled part."""
    columns, alpha = given.columns, given.alpha
    if given.innovations is None or columns.S is None:
        return nis, _InnovationFindings()
    rows = nis.segmented.settled_rows()
    innovations = innovations_at(rows, columns, given.innovations, columns.S)
    if len(innovations) < MIN_UPDATES_FOR_BIAS:
        return nis, _InnovationFindings()
    biases = innovation_biases(innovations, alpha)
    clean = subtract_biases(innovations, biases)
    correlation = innovation_correlation(clean)
    if biases and sign(correlation, alpha) > 0:
        biases = innovation_biases(innovations, alpha, variance_inflation(correlation))
        clean = subtract_biases(innovations, biases)
    nis = judge_nis(nis, innovations, clean, biases, correlation, alpha)
    is_heavy_tailed = nis.segmented.outliers.is_heavy_tailed
    cause = probable_cause(nis.name, correlation, alpha, is_heavy_tailed)
    return nis, _InnovationFindings(biases, correlation, cause)


def _longest_gap(time: Floats) -> tuple[float, float | None]:
    """The longest time between two updates, and when it begins."""
    gaps = time[1:] - time[:-1]
    if not len(gaps):
        return NAN, None
    longest = int(gaps.argmax())
    return float(gaps[longest]), float(time[longest])


def quantity_verdict(name: str, judged: JudgedTrace) -> QuantityVerdict:
    """The result for a judged trace."""
    shown, verdict, trace = judged.shown, judged.verdict, judged.segmented.trace
    settled = shown.settled()
    segment = None if settled is None else shown.segments[settled]
    onset, settling = (
        None if k is None else int(shown.inliers[k]) for k in (verdict.onset, verdict.settling)
    )
    alarm = alarm_of_fault(trace.pair, shown.alarm, onset)
    at, rise = (None, None) if alarm is None else alarm

    def row(k: int | None) -> int | None:
        return None if k is None else int(trace.rows[k])

    def time(k: int | None) -> float | None:
        return None if k is None else float(trace.times[k])

    return QuantityVerdict(
        quantity=name,
        verdict=verdict.verdict,
        updates=len(trace.rows),
        segments=shown.segments,
        scale=NAN if segment is None else segment.scale,
        interval=(NAN, NAN) if segment is None else segment.interval,
        onset_index=row(onset),
        onset_time=time(onset),
        settling_index=row(settling),
        settling_time=time(settling),
        alarm_index=row(at),
        alarm_time=time(at),
        alarm_onset_time=time(rise),
        autocorrelation_time=trace.autocorrelation_time,
        decided_by=verdict.decided_by,
    )


def _onset(nis: JudgedTrace, nees: JudgedTrace | None) -> int | None:
    """The update at which the fault begins, by the quantity that shows it first."""
    found = [
        int(q.segmented.rows[q.verdict.onset])
        for q in (nis, nees)
        if q is not None and q.verdict.onset is not None
    ]
    return min(found, default=None)


def _attribution(nees: JudgedTrace, columns: Columns) -> Attribution | None:
    """The NEES of the last optimistic segment (else of all updates) attributed to the states."""
    if nees.name not in FAILING_VERDICTS or columns.error is None or columns.P is None:
        return None
    rows = _failing_rows(nees)
    rows = rows[valid_components(columns.error[rows], columns.P[rows]).any(axis=1)]
    return attribute_nees(columns.error[rows], columns.P[rows]) if len(rows) else None


def _failing_rows(nees: JudgedTrace) -> Integers:
    segmented = nees.segmented
    failing = [i for i, s in enumerate(segmented.segments) if s.label == "optimistic"]
    if not failing:
        return segmented.rows
    return segmented.rows[segmented.edges[failing[-1]] : segmented.edges[failing[-1] + 1]]


def _notes(given: _TrackInput) -> tuple[str, ...]:
    """Warnings about the log, vectors that lack components, and angles that are not wrapped."""
    notes = [*given.warnings, *text.incomplete_vectors(given.columns)]
    if given.wrapping is not None:
        timeline = Timeline(given.log.start_time, given.log.time_unit)
        notes += text.wrapping(given.wrapping, given.columns.time, timeline)
    return tuple(notes)
