"""Reports left out, as a test of the filter's predictions.

A recording has no truth, but reports that the filter has not fused are nearly as good: the
prediction to the time of a report left out has the innovation y = z - H x and, if the filter is
consistent, S = H P H' + R. Its NIS y' S^-1 y is chi-square distributed. Within one gap between two
fused reports all predictions start from one state, so that their errors are correlated; and that
state remembers the gap before. With F_i the Jacobian from the last fused report to report i and
A_k = (I - K_k H_k) F_k of the fused reports between, the error of a later prediction is Phi_ij
times that of an earlier one plus new noise:

    Phi_ij = F_j A_b ... A_(a+1) F_i^-1,  Cov(y_j, y_i) = H Phi_ij P_i H'.

With C the correlation matrix of all whitened innovations of a track, its M components, the sum of
the NIS has the cumulants M, 2 tr C^2 and 8 tr C^3; where nothing is correlated C is the identity
and the sum chi2(M). With a_i = E_i E_i', g_k = L_k' L_k and b_j = L_j' E_j', where L_j E_i is the
block (j, i) of C below the diagonal,

    tr C^2 = M + 2 sum over i < j of tr a_i g_j,
    tr C^3 = M + 6 sum over i < j of tr a_i g_j + 6 sum over i < j < k of tr a_i b_j g_k,

sums that two passes over the reports, one forward and one backward, carry along in matrices of the
size of the state. The null distribution is a shifted and scaled chi-square with the same three
cumulants (Imhof 1961, Biometrika 48, 419-426, eq. 4.1): two of them alone would reject too seldom
below and too often above, as a few strong correlations make the sum skew.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, _deprecated
from trackmetrics._angles import wrap
from trackmetrics._progress import with_progress
from trackmetrics.diagnostics.thresholds import MIN_SCALE_RATIO
from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel.reports import Reports
from trackmetrics.vessel.settings import OBSERVED, Floats, Settings

Integers = NDArray[np.int64]

VERDICT_ALPHA = 0.005
"""p-value from which on a track counts as consistent."""


@dataclass(frozen=True)
class HeldOutResult:
    """How well a filter predicted the reports of one track that it had not fused."""

    track: str
    """Name of the track."""
    reports: int
    """How many reports were predicted."""
    num_gaps: int
    """Number of gaps between fused reports in which they lie."""
    dof: int
    """Their components together."""
    effective_dof: float
    """Number of independent components with the same information, given the correlation."""
    scale: float
    """Sum of the NIS over ``dof``: 1 if consistent, above 1 optimistic, below 1 pessimistic."""
    interval: tuple[float, float]
    """95 % confidence interval of the scale."""
    p_value: float
    """Two-sided p-value of "the scale is 1"."""
    nis: Floats
    """The predictive NIS of each report."""
    times: Floats
    """Its time."""

    gaps = _deprecated.attribute("num_gaps")

    @property
    def verdict(self) -> str:
        """``"consistent"``, ``"optimistic"`` or ``"pessimistic"``, at 0.5 % and if material."""
        is_material = not 1 / MIN_SCALE_RATIO <= self.scale <= MIN_SCALE_RATIO
        if self.p_value >= VERDICT_ALPHA or not is_material:
            return "consistent"
        return "optimistic" if self.scale > 1 else "pessimistic"

    def to_dict(self) -> dict[str, Any]:
        """The numbers, without those of each report."""
        names = (
            "track",
            "reports",
            "num_gaps",
            "dof",
            "effective_dof",
            "scale",
            "p_value",
            "verdict",
        )
        found = {name: getattr(self, name) for name in names}
        return {**found, "interval": list(self.interval)}

    def __repr__(self) -> str:
        """Scale and verdict."""
        low, high = self.interval
        return (
            f"HeldOutResult({self.track!r}, {self.verdict!r}, scale={self.scale:.3g} "
            f"[{low:.3g}, {high:.3g}], reports={self.reports}, num_gaps={self.num_gaps})"
        )


def predictive_nis(
    log: EstimatorLog, held_out: Reports, settings: Settings, *, progress: bool = False
) -> Mapping[str, HeldOutResult]:
    """Test a filter on the reports that it has not fused.

    Parameters
    ----------
    log : EstimatorLog
        What :meth:`Tracker.log` gave; tracks are named as the vessels are.
    held_out : Reports
        Reports with identity that were not added to the tracker.
    settings : Settings
        Those of the tracker.
    progress : bool
        Whether a bar on standard error counts the tracks, where it takes longer than a second
        (needs the extra ``progress``).

    Returns
    -------
    mapping of str to HeldOutResult
        Of each track whose active filter some held-out reports can be predicted from. Reports
        before the first or after the last fused one, or of a track not yet active, are left out.
    """
    results = {}
    of_vessel = held_out.rows_by_vessel()
    nothing = np.empty(0, np.int64)
    for track in with_progress(log, "predicting", len(log.tracks), " tracks") if progress else log:
        rows = held_out.take(of_vessel.get(track, nothing))
        found = _of_track(track, log[track], rows, settings)
        if found is not None:
            results[track] = found
    return results


def _of_track(track: str, fused: Any, rows: Reports, settings: Settings) -> HeldOutResult | None:
    order = np.argsort(rows.time, kind="stable")
    before = np.searchsorted(fused.time, rows.time[order], side="right") - 1
    usable = (before >= 0) & (before < len(fused.time) - 1)
    usable &= (fused.status == "active")[np.maximum(before, 0)]
    rows, before = rows.take(order[usable]), before[usable]
    if not len(rows):
        return None
    predictions = _Predictions(fused, rows, before, settings)
    nis = predictions.nis()
    num_gaps = len(np.unique(before))
    return _result(track, rows, nis, predictions.observed, num_gaps, predictions.traces())


class _Predictions:
    """Predictions to every held-out report of a track, each from the last fused report."""

    def __init__(self, fused: Any, rows: Reports, before: Integers, settings: Settings) -> None:
        self.rows, self.before, self.a = rows, before, fused.A
        self.observed = OBSERVED[rows.kind]
        times = np.ascontiguousarray(rows.time - fused.time[before])
        start = (np.ascontiguousarray(fused.x[before]), np.ascontiguousarray(fused.P[before]))
        predict = _backend.kernels.vessel_predict
        self.x, self.p, self.f = predict(*start, times, settings.motion)
        self.r = _variances(rows, settings)
        self.white = np.zeros((len(rows), 4, 4))

    def nis(self) -> Floats:
        """The predictive NIS of each; keeps S^-1/2, padded with zeros."""
        values = np.empty(len(self.rows))
        for k, m in enumerate(self.observed):
            y = self.rows.z[k, :m] - self.x[k, :m]
            y[1::2] = wrap(y[1::2], 360.0)
            s = self.p[k, :m, :m] + np.diag(self.r[k, :m])
            self.white[k, :m, :m] = np.linalg.inv(np.linalg.cholesky(s))
            values[k] = ((self.white[k, :m, :m] @ y) ** 2).sum()
        return values

    def traces(self) -> tuple[float, float]:
        """``tr C^2`` and ``tr C^3`` of the correlations C of all whitened innovations."""
        later = self.white @ self.f[:, :4]
        earlier = np.linalg.solve(self.f, self.p[:, :, :4] @ self.white.swapaxes(1, 2))
        before = earlier @ earlier.swapaxes(1, 2)
        after = later.swapaxes(1, 2) @ later
        between = later.swapaxes(1, 2) @ earlier.swapaxes(1, 2)
        carried = self._transition_products()
        sums = _running(before, carried[1:])
        ends = _running(after[::-1], carried[:0:-1].swapaxes(1, 2))[::-1]
        pairs = float(np.einsum("nij,nji->", sums, after))
        triples = float(np.einsum("nij,njk,nki->", sums, between, ends, optimize=True))
        total = float(self.observed.sum())
        return total + 2 * pairs, total + 6 * pairs + 6 * triples

    def _transition_products(self) -> Floats:
        """For each report, what the updates since the report before did to the error."""
        carried = np.broadcast_to(np.eye(5), (len(self.rows), 5, 5)).copy()
        for k in np.flatnonzero(np.diff(self.before)) + 1:
            for row in range(self.before[k - 1] + 1, self.before[k] + 1):
                carried[k] = self.a[row] @ carried[k]
        return carried


def _running(terms: Floats, carried: Floats) -> Floats:
    """The sum of all terms before each one, carried along from one to the next."""
    sums = np.zeros_like(terms)
    for k in range(1, len(terms)):
        step = carried[k - 1]
        sums[k] = step @ (sums[k - 1] + terms[k - 1]) @ step.T
    return sums


def _variances(rows: Reports, settings: Settings) -> Floats:
    """``(n, 4)``: variances of the components of each report, in the units of the state."""
    n = len(rows)
    blank = (np.zeros((n, 7)), np.zeros((n, 5)), np.zeros((n, 5, 5)))
    starts = np.arange(n + 1, dtype=np.int64)
    z, sigmas = np.ascontiguousarray(rows.z), np.ascontiguousarray(settings.sigmas[rows.kind])
    # A track that starts from a report has its R: the one place where metres become degrees.
    _, out = _backend.kernels.vessel_filter(
        *blank, starts, rows.time, z, OBSERVED[rows.kind], sigmas, settings.motion, settings.rules
    )
    variances: Floats = np.einsum("nii->ni", out[6])
    return variances


def _result(
    track: str,
    rows: Reports,
    nis: Floats,
    observed: Integers,
    num_gaps: int,
    traces: tuple[float, float],
) -> HeldOutResult:
    dof, total = int(observed.sum()), float(nis.sum())
    # 1 <= shape <= effective <= dof holds for every C; clipped, it holds for a rounded one too.
    effective = float(np.clip(dof**2 / traces[0], 1.0, dof))
    shape = float(np.clip(traces[0] ** 3 / traces[1] ** 2, 1.0, effective))
    p, (low, high) = _tails(total / dof, effective, shape)
    interval = (total / dof / high, total / dof / low)
    return HeldOutResult(
        track, len(rows), num_gaps, dof, effective, total / dof, interval, p, nis, rows.time
    )


def _tails(scale: float, effective: float, shape: float) -> tuple[float, tuple[float, float]]:
    """The p-value of a scale, and the 95 % interval of a consistent one.

    A consistent scale is 1 + (x - shape) / sqrt(shape * effective), with x chi2(shape).
    """
    from scipy.special import chdtr, chdtrc, chdtri

    unit = np.sqrt(shape * effective)
    x = max(shape + unit * (scale - 1), 0.0)
    p = 2 * min(float(chdtr(shape, x)), float(chdtrc(shape, x)), 0.5)
    low, high = (float(1 + (chdtri(shape, tail) - shape) / unit) for tail in (0.975, 0.025))
    return p, (low, high)
