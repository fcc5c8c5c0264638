"""Reports left out, as a test of the filter's predictions.

A recording has no truth, but reports that the filter has not fused are nearly as good: the
prediction to the time of a report left out has the innovation y = z - H x and, if the filter is
honest, S = H P H' + R. Its NIS y' S^-1 y is chi-square distributed. Within one gap between two
fused reports all predictions start from one state, so that their errors are correlated; and that
state remembers the gap before. With F_i the Jacobian from the last fused report to report i and
A_k = (I - K_k H_k) F_k of the fused reports between, the error of a later prediction is Phi_ij
times that of an earlier one plus new noise:

    Phi_ij = F_j A_b ... A_(a+1) F_i^-1,  Cov(y_j, y_i) = H Phi_ij P_i H'.

The sum of the NIS of a track has the expectation M, the number of components, and the variance

    2 M + 4 sum over i < j of || S_j^-1/2 Cov(y_j, y_i) S_i^-1/2 ||^2,

which is 2 M only where nothing is correlated. It is taken for g chi2(h) with both (Satterthwaite).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend
from trackmetrics.diagnostics import EstimatorLog
from trackmetrics.vessel.model import OBSERVED, Floats, Settings
from trackmetrics.vessel.reports import Reports

Integers = NDArray[np.int64]


MEMORY = 8
"""Gaps after which the correlation is taken for gone."""


@dataclass(frozen=True)
class HeldOut:
    """How well a filter predicted the reports of one track that it had not fused."""

    track: str
    """Name of the track."""
    reports: int
    """How many reports were predicted."""
    gaps: int
    """Into how many gaps between fused reports they fall."""
    dof: int
    """Their components together."""
    effective_dof: float
    """The same for the correlation: as many independent ones would tell as much."""
    scale: float
    """Sum of the NIS over ``dof``: 1 is honest, above 1 the filter claims too much."""
    interval: tuple[float, float]
    """95 % confidence interval of the scale."""
    p_value: float
    """Two-sided p-value of "the scale is 1"."""
    nis: Floats
    """The predictive NIS of each report."""
    times: Floats
    """Its time."""

    @property
    def verdict(self) -> str:
        """``"consistent"``, ``"optimistic"`` or ``"pessimistic"``, at 0.5 % and if material."""
        if self.p_value >= 0.005 or 0.8 <= self.scale <= 1.25:
            return "consistent"
        return "optimistic" if self.scale > 1 else "pessimistic"

    def to_dict(self) -> dict[str, Any]:
        """The numbers, without those of each report."""
        names = ("track", "reports", "gaps", "dof", "effective_dof", "scale", "p_value", "verdict")
        found = {name: getattr(self, name) for name in names}
        return {**found, "interval": list(self.interval)}

    def __repr__(self) -> str:
        """Scale and verdict."""
        low, high = self.interval
        return (
            f"HeldOut({self.track!r}, {self.verdict!r}, scale={self.scale:.3g} "
            f"[{low:.3g}, {high:.3g}], reports={self.reports}, gaps={self.gaps})"
        )


def predictive_nis(
    log: EstimatorLog, held_out: Reports, settings: Settings
) -> Mapping[str, HeldOut]:
    """Test a filter on the reports that it has not fused.

    Parameters
    ----------
    log : EstimatorLog
        What :meth:`Tracker.log` gave; tracks are named as the vessels are.
    held_out : Reports
        Reports with identity that were not added to the tracker.
    settings : Settings
        Those of the tracker.

    Returns
    -------
    mapping of str to HeldOut
        Of each track whose active filter some held-out reports can be predicted from. Reports
        before the first or after the last fused one, or of a track not yet active, are left out.
    """
    results = {}
    for track in log:
        rows = held_out.take(np.flatnonzero(held_out.vessel == track))
        found = _of_track(track, log[track], rows, settings)
        if found is not None:
            results[track] = found
    return results


def _of_track(track: str, fused: Any, rows: Reports, settings: Settings) -> HeldOut | None:
    order = np.argsort(rows.time, kind="stable")
    before = np.searchsorted(fused.time, rows.time[order], side="right") - 1
    usable = (before >= 0) & (before < len(fused.time) - 1)
    usable &= (fused.status == "active")[np.maximum(before, 0)]
    rows, before = rows.take(order[usable]), before[usable]
    if not len(rows):
        return None
    predictions = _Predictions(fused, rows, before, settings)
    nis = predictions.nis()
    gaps = len(np.unique(before))
    return _judge(track, rows, nis, predictions.observed, gaps, predictions.variance())


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
            y[1::2] = (y[1::2] + 180.0) % 360.0 - 180.0
            s = self.p[k, :m, :m] + np.diag(self.r[k, :m])
            self.white[k, :m, :m] = np.linalg.inv(np.linalg.cholesky(s))
            values[k] = ((self.white[k, :m, :m] @ y) ** 2).sum()
        return values

    def variance(self) -> float:
        """Variance of the sum of the NIS."""
        later = self.white @ self.f[:, :4]
        earlier = np.linalg.solve(self.f, self.p[:, :, :4] @ self.white.swapaxes(1, 2))
        gaps = np.split(np.arange(len(self.rows)), np.flatnonzero(np.diff(self.before)) + 1)
        total = 2.0 * float(self.observed.sum())
        total += sum(4.0 * _within(later[gap], earlier[gap]) for gap in gaps)
        return total + 4.0 * self._between(gaps, later, earlier)

    def _between(self, gaps: list[Integers], later: Floats, earlier: Floats) -> float:
        """The same over pairs of different gaps; traces replace the sum over single pairs."""
        ends = [self.before[gap[0]] for gap in gaps]
        grams = [np.einsum("nab,nac->bc", later[gap], later[gap]) for gap in gaps]
        starts = [np.einsum("nab,ncb->ac", earlier[gap], earlier[gap]) for gap in gaps]
        total = 0.0
        for k in range(len(gaps)):
            carried = np.eye(5)
            for j in range(k + 1, min(k + 1 + MEMORY, len(gaps))):
                for row in range(ends[j - 1] + 1, ends[j] + 1):
                    carried = self.a[row] @ carried
                total += float(np.trace(carried @ starts[k] @ carried.T @ grams[j]))
        return total


def _within(later: Floats, earlier: Floats) -> float:
    """Sum of the squared correlations of all pairs of one gap."""
    return sum(float(((later[k + 1 :] @ earlier[k]) ** 2).sum()) for k in range(len(later) - 1))


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


def _judge(
    track: str, rows: Reports, nis: Floats, observed: Integers, gaps: int, variance: float
) -> HeldOut:
    from scipy.special import chdtr, chdtrc, chdtri

    dof = int(observed.sum())
    g, h = variance / (2 * dof), 2 * dof**2 / variance
    total = float(nis.sum())
    p = 2 * min(float(chdtr(h, total / g)), float(chdtrc(h, total / g)))
    low, high = (total / (g * float(chdtri(h, tail))) for tail in (0.025, 0.975))
    return HeldOut(
        track, len(rows), gaps, dof, h, total / dof, (low, high), min(p, 1.0), nis, rows.time
    )
