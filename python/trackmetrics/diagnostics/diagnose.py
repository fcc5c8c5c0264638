"""From a log to its diagnosis."""

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend
from trackmetrics.consistency.correlation_time import correlation_times
from trackmetrics.diagnostics.angles import radians_in_degrees, unwrapped
from trackmetrics.diagnostics.judging import Quantity, transitions
from trackmetrics.diagnostics.results import Diagnosis
from trackmetrics.diagnostics.segmentation import Pair, candidates, cut, edges, scores_within
from trackmetrics.diagnostics.trace import LEAST_UPDATES, Candidates, Trace
from trackmetrics.diagnostics.track import Evidence, assemble
from trackmetrics.diagnostics.verdict import describe
from trackmetrics.logs.columns import Columns, Floats, Integers, components, present
from trackmetrics.logs.derived import component_periods, wrapped
from trackmetrics.logs.log import EstimatorLog

LEVEL = 0.004
"""Chance of a false alarm of each family of tests."""


def diagnose(log: EstimatorLog, *, level: float = LEVEL) -> Diagnosis:
    """Is each track of a log honest, since when, and which state fails?

    A verdict for the NIS of each track, one for its NEES where there is truth, and the more severe
    of the two:

    ``angle_wrap_bug``
        a logged innovation of an angle lies beyond half its period, and the logged NIS is that of
        the unwrapped residual;
    ``late_divergence``
        too large from some time to the very end;
    ``startup_then_consistent``, ``startup_then_pessimistic``
        too large at the beginning only;
    ``biased``
        a constant offset of a measurement or of a state explains the excess;
    ``optimistic``
        too large throughout: the covariance is too small;
    ``transient``
        too large for a while;
    ``pessimistic``, ``partly_pessimistic``
        too small in at least half, or in less, of the track: the covariance is too large;
    ``outliers``
        honest apart from isolated values that are far too large;
    ``non_white``
        the right size, but innovations correlate in time;
    ``consistent``
        none of these;
    ``insufficient``
        fewer than 4 updates or 8 degrees of freedom.

    The NIS c_k with m_k degrees of freedom is taken as s chi2(m_k) with a scale s that is constant
    in each of at most four segments, found by dynamic programming; a cut must gain more likelihood
    than the best cut of honest data does by chance. Each segment is tested against s = 1. NEES is
    treated alike after division by its autocorrelation, known from ``A`` or else estimated.

    Parameters
    ----------
    log
        The log. NIS with their degrees of freedom are enough; innovations with ``S`` add bias,
        whiteness and cause, errors with ``P`` the states, ``A`` exactness in time.
    level
        Chance of a false alarm of each of the six families of tests (segments, levels, ends,
        outliers, whiteness and bias of NIS; the same of NEES), between 0 and 0.05.

    Returns
    -------
    Diagnosis
        A mapping from the names of the tracks to :class:`TrackDiagnosis`.

    Raises
    ------
    ValueError
        If ``level`` is outside its range.

    Notes
    -----
    Deterministic: what is drawn is drawn with a fixed seed, once for each pattern of degrees of
    freedom. A bias common to all sensors cannot be seen without truth. A turn to which the filter
    adapts shows as ``transient`` in the NIS while the state is still wrong: only the NEES tells.
    For an estimator far from linear chi-square is an approximation.

    References
    ----------
    Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and
    Navigation (2001), chapter 5.4, doi:10.1002/0471221279.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> nis = rng.chisquare(2, 60)
    >>> nis[40:] *= 8
    >>> d = diagnose(EstimatorLog.from_columns(nis=nis, nis_dof=2))
    >>> d["track"].verdict, d["track"].nis.onset_index
    ('late_divergence', 39)
    """
    if not 0 < level <= 0.05:
        raise ValueError(f"level must be above 0 and at most 0.05, got {level!r}")
    tracks = [log.columns.take(log.rows(t)) for t in range(len(log.tracks))]
    nis = _judged([_nis_parts(columns) for columns in tracks], level)
    nees = _judged(_nees_parts(log, tracks, level), level)
    periods = component_periods(log.columns, log.states, log.measurement_angles)
    angles, warnings = unwrapped(log, periods), radians_in_degrees(log)
    found = []
    for t, columns in enumerate(tracks):
        rows, values = log.rows(t), columns.innovation
        if values is not None and periods is not None:
            values = wrapped(values, periods[rows])
        of_track = None if angles is None else angles.of(rows)
        quantities = nis[t] or _nothing(), nees[t]
        evidence = Evidence(log, t, columns, values, *quantities, of_track, warnings, level)
        found.append(assemble(evidence))
    return Diagnosis(tuple(found), warnings)


_Parts = tuple[Trace, Integers, float]


def _judged(parts: list[_Parts | None], level: float) -> list[Quantity | None]:
    """All traces cut in one go, each with its verdict."""
    cut([part[0] for part in parts if part is not None], level)
    return [
        None if part is None else Quantity(part[0], part[1], part[2], describe(part[0], level))
        for part in parts
    ]


def _nothing() -> Quantity:
    """A quantity that the log does not have."""
    trace = Trace(np.empty(0), np.empty(0), True)
    return Quantity(trace, np.empty(0, np.int64), 1.0, describe(trace, LEVEL))


def _nis_parts(columns: Columns) -> _Parts | None:
    """The NIS of a track without tentative updates."""
    if columns.nis is None or columns.nis_dof is None:
        return None
    usable = ~np.isnan(columns.nis)
    if columns.status is not None:
        usable &= columns.status != "tentative"
    rows = np.flatnonzero(usable)
    return Trace(columns.nis[rows], columns.nis_dof[rows], True), rows, 1.0


def _nees_parts(log: EstimatorLog, tracks: list[Columns], level: float) -> list[_Parts | None]:
    """The NEES of every track over its autocorrelation."""
    if log.columns.nees is None or log.columns.nees_dof is None:
        return [None] * len(tracks)
    rows, pairs = [], []
    for c in tracks:
        assert c.nees is not None
        assert c.nees_dof is not None
        rows.append(np.flatnonzero(~np.isnan(c.nees)))
        pairs.append((c.nees[rows[-1]], c.nees_dof[rows[-1]]))
    inflation = _inflation(tracks, rows, pairs, level)
    return [
        (Trace(v / tau, d / tau, False, found=found), r, _middle(tau)) if len(r) else None
        for (v, d), r, (tau, found) in zip(pairs, rows, inflation, strict=True)
    ]


def _middle(tau: Floats | float) -> float:
    """The median, the upper one of two; np.median costs ten times as much."""
    if isinstance(tau, float):
        return tau
    half = len(tau) // 2
    return float(np.partition(tau, half)[half])


def _inflation(
    tracks: list[Columns], rows: list[Integers], pairs: list[Pair], level: float
) -> list[tuple[Floats | float, Candidates | None]]:
    """tau of every NEES: from the model where A and P are logged, else from the values.

    One tau for all values of a track scales every gain and moves no cut.
    """
    tau: list[tuple[Floats | float, Candidates | None]] = [(1.0, None)] * len(rows)
    modelled = [i for i, (c, r) in enumerate(zip(tracks, rows, strict=True)) if _has_model(c, r)]
    if modelled:
        steps = np.concatenate([transitions(tracks[i], rows[i]) for i in modelled])
        claims = np.concatenate([_claims(tracks[i], rows[i]) for i in modelled])
        starts = np.concatenate([[0], np.cumsum([len(rows[i]) for i in modelled])])
        known = np.concatenate([_known(tracks[i], rows[i]) for i in modelled])
        mask = None if known.all() else known.astype(np.int64).ravel()
        model = _backend.kernels.nees_inflation(steps, claims, starts.astype(np.int64), mask)
        for i, a, b in zip(modelled, starts[:-1], starts[1:], strict=True):
            tau[i] = model[a:b], None
    free = [i for i, r in enumerate(rows) if i not in set(modelled) and len(r) >= LEAST_UPDATES]
    chosen = [pairs[i] for i in free]
    best = candidates(chosen)
    times = correlation_times(scores_within(chosen, edges(chosen, best, level))).tolist()
    for i, time, found in zip(free, times, best, strict=True):
        tau[i] = time, Candidates(found.gains / time, found.cuts)
    return tau


def _has_model(columns: Columns, rows: Integers) -> bool:
    """Whether P is there for every NEES and A for most (not for the first, or while tentative)."""
    if columns.A is None or columns.P is None or columns.nees_dof is None or not len(rows):
        return False
    if present(columns.A[rows]).mean() <= 0.5 or np.isnan(columns.P[rows]).any():
        return False
    return bool((_known(columns, rows).sum(axis=1) == columns.nees_dof[rows]).all())


def _known(columns: Columns, rows: Integers) -> NDArray[np.bool_]:
    """The components of the errors that made these NEES; all where no error is logged."""
    assert columns.P is not None
    whole = np.ones((len(rows), columns.P.shape[1]), bool)
    if columns.error is None:
        return whole
    there = components(columns.error[rows], columns.P[rows])
    some = np.logical_or.reduce(there, axis=1)
    return np.where(some[:, None], there, whole)


def _claims(columns: Columns, rows: Integers) -> Floats:
    assert columns.P is not None
    return columns.P[rows]
