"""The verdicts of NIS and NEES of one track, from its traces and what stands beside them."""

from dataclasses import dataclass, replace

import numpy as np

from trackmetrics import _distributions
from trackmetrics.diagnostics import innovations as nu
from trackmetrics.diagnostics.bias import StateOffset, state_offsets
from trackmetrics.diagnostics.innovations import Correlation, Innovations, Offset
from trackmetrics.diagnostics.outliers import robust_scale
from trackmetrics.diagnostics.trace import MATERIAL, Stretch, Trace
from trackmetrics.diagnostics.verdict import Word
from trackmetrics.logs.columns import Columns, Floats, Integers, components, present
from trackmetrics.logs.derived import quadratic_forms

EXPLAINED = 0.5
"""Share of the excess that a bias must take away to be the verdict."""
CERTAIN = 1e-4
"""Chance below which the NEES before a fault was too large already."""
FAR = 2.0
"""Scale of the NEES above which it should show a bias that is real."""
WELL_BEFORE = 2 / 3
"""Share of the updates before a fault that stand for what was before it."""
NAMING = 0.6
"""Share of the level at which a correlation names a cause: a wrong one is worse than none."""
LEANING = 0.05
"""Chance below which the size of correlated innovations decides what to call them."""


@dataclass(frozen=True)
class Quantity:
    """The NIS or the NEES of a track: its values, where they stand, and the verdict so far."""

    trace: Trace
    """Values over their inflation by what correlates in time."""
    rows: Integers
    """The update of each value."""
    inflation: float
    """The median of these factors."""
    word: Word

    def settled(self) -> Stretch | None:
        """The longest stretch that is not too high, else the longest."""
        stretches = self.trace.stretches
        calm = [s for s in stretches if s.label != "high"] or list(stretches)
        return max(calm, key=len, default=None)

    def settled_rows(self) -> Integers:
        """The updates of that stretch, outliers left out."""
        settled = self.settled()
        if settled is None:
            return self.rows if not len(self.trace.kept) else self.rows[self.trace.kept]
        return self.rows[self.trace.kept[settled.start : settled.stop]]

    def called(self, verdict: str) -> "Quantity":
        """The same with another verdict."""
        return replace(self, word=replace(self.word, verdict=verdict))


@dataclass(frozen=True)
class InnovationFindings:
    """What the innovations said."""

    offsets: tuple[Offset, ...] = ()
    correlation: Correlation | None = None
    cause: str | None = None


def judge_innovations(
    nis: Quantity, columns: Columns, values: Floats | None, level: float
) -> tuple[Quantity, InnovationFindings]:
    """The verdict on the NIS in the light of the innovations (wrapped) of its settled part."""
    if values is None or columns.S is None:
        return nis, InnovationFindings()
    found = _settled_innovations(nis, columns, values, columns.S)
    if len(found) < nu.LEAST_UPDATES:
        return nis, InnovationFindings()
    biases = [o for o in nu.offsets(found) if o.p_value < level]
    white = nu.correlation(nu.without(found, biases))
    if biases and white.sign(level) > 0:
        biases = [o for o in nu.offsets(found, white.memory) if o.p_value < level]
    clean = nu.without(found, biases)
    sign = white.sign(level)
    verdict = nis.word.verdict
    if biases:
        verdict = "biased" if _only_an_end(nis.word) else _biased(verdict, found, clean)
    elif verdict == "consistent":
        verdict = _leaning(clean) if sign else _together(clean, white, level)
    cause = _cause(verdict, white.lasting_sign(NAMING * level, high="optimistic" in verdict))
    if cause == "measurement noise too small" and _heavy_tailed(nis, level):
        cause = None
    return nis.called(verdict), InnovationFindings(tuple(biases), white, cause)


def _settled_innovations(
    nis: Quantity, columns: Columns, values: Floats, covariances: Floats
) -> Innovations:
    """The innovations of the settled part, of each the components that have a variance."""
    rows = nis.settled_rows()
    there = components(values[rows], covariances[rows])
    some = there.any(axis=1)
    rows, there = rows[some], there[some]
    types = columns.measurement_type
    kinds = np.full(len(rows), "", object) if types is None else types[rows].astype(str)
    kept = np.where(there, values[rows], np.nan)
    return Innovations(kept, covariances[rows], kinds.astype(object))


def _only_an_end(word: Word) -> bool:
    """Whether an end of the track is too large where the stretches are not."""
    return word.by_end and not word.verdict.endswith("pessimistic")


def _leaning(innovations: Innovations) -> str:
    """What to call innovations that are correlated in time: by their size, if it says anything."""
    return _called_by_size(*innovations.scale)


def _called_by_size(total: float, dof: float) -> str:
    if _distributions.chi2_sf(total, dof) < LEANING / 2:
        return "optimistic"
    if _distributions.chi2_cdf(total, dof) < LEANING / 2:
        return "pessimistic"
    return "non_white"


def _together(innovations: Innovations, white: Correlation, level: float) -> str:
    """Size and correlation in time at once: each may say too little by itself.

    Both are standard normal and independent for an honest filter. A noise that is wrong moves both;
    their sum and their difference over the root of 2 are tested, since either sign may come with
    either size.
    """
    total, dof = innovations.scale
    if 1 / MATERIAL <= total / dof <= MATERIAL:
        return "consistent"
    size = float(_distributions.chi2_to_z(np.array([total]), np.array([dof]))[0])
    z = (abs(size) + abs(white.z)) / 2**0.5
    if 2 * _distributions.normal_p_value(z) > level:
        return "consistent"
    return "optimistic" if size > 0 else "pessimistic"


def _biased(verdict: str, found: Innovations, clean: Innovations) -> str:
    """Biased, unless the verdict says more or the bias explains too little of it."""
    if verdict in ("consistent", "outliers", "transient", "partly_pessimistic"):
        return "biased"
    if verdict != "optimistic":
        return verdict
    before, after = (total / dof for total, dof in (found.scale, clean.scale))
    return "biased" if before - after > EXPLAINED * (before - 1.0) else verdict


def _heavy_tailed(nis: Quantity, level: float) -> bool:
    """Whether there are outliers: they too make innovations large, and alternate."""
    values, dof = nis.trace.kept_values()
    scale = robust_scale(values, dof)
    extreme = _distributions.chi2_sf(values / scale, dof).min() < level / len(values)
    return bool(nis.trace.outliers) or bool(extreme)


def _cause(verdict: str, sign: int) -> str | None:
    if "optimistic" in verdict:
        return nu.CAUSES.get(("high", sign))
    if "pessimistic" in verdict:
        return nu.CAUSES.get(("low", sign))
    return None


def judge_errors(
    nees: Quantity, columns: Columns, level: float
) -> tuple[Quantity, tuple[StateOffset, ...]]:
    """The verdict on the NEES in the light of the errors of its settled part."""
    if columns.error is None or columns.P is None:
        return nees, ()
    rows = nees.settled_rows()
    there = components(columns.error[rows], columns.P[rows])
    rows, there = rows[there.any(axis=1)], there[there.any(axis=1)]
    e, p = np.where(there, columns.error[rows], np.nan), columns.P[rows]
    steps = None if columns.A is None or not there.all() else transitions(columns, rows)
    biases = tuple(o for o in state_offsets(e, p, steps) if o.p_value < level)
    verdict = nees.word.verdict
    open_to_bias = ("consistent", "optimistic", "transient", "outliers", "partly_pessimistic")
    if biases and verdict in open_to_bias and _explains(e, p, biases, level):
        return nees.called("biased"), biases
    return nees, biases


def _explains(
    errors: Floats, covariances: Floats, biases: tuple[StateOffset, ...], level: float
) -> bool:
    """Whether the biases take away most of the excess; without one they must be the surer."""
    bias = np.zeros(errors.shape[1])
    for offset in biases:
        bias[offset.state] = offset.value
    dof = float((~np.isnan(errors)).sum())
    before, after = (
        float(quadratic_forms(e, covariances).sum()) / dof for e in (errors, errors - bias)
    )
    if before < MATERIAL:
        return min(b.p_value for b in biases) < level / 4
    return bool(before - after > EXPLAINED * (before - 1.0))


def transitions(columns: Columns, rows: Integers) -> Floats:
    """The A of these updates, 0 (no memory) where it is not logged or updates are left out."""
    assert columns.A is not None
    known = present(columns.A[rows])
    known[1:] &= np.diff(rows) == 1
    return np.where(known[:, None, None], np.nan_to_num(columns.A[rows]), 0.0)


def reconciled(
    nis: Quantity, nees: Quantity, state_biases: tuple[StateOffset, ...]
) -> tuple[Quantity, Quantity]:
    """NIS and NEES, each in the light of the other.

    What only an end of one of them shows gives way to a bias that the other shows: a filter absorbs
    a bias as it starts. A mean innovation is no bias where the errors are far too large and have no
    mean; a mean error is none where both are smaller than claimed. Innovations that are correlated
    in time are called by the size of the errors, if it says anything. And a NIS that diverges late
    is optimistic where the NEES was so from the start.
    """
    if nees.word.verdict == "biased" and _only_an_end(nis.word):
        nis = replace(nis, word=Word("consistent"))
    if nis.word.verdict == "biased" and _only_an_end(nees.word):
        nees = replace(nees, word=Word("consistent"))
    if (nis.word.verdict, nees.word.verdict) == ("pessimistic", "biased") and _scale(nees) < 1:
        nees = replace(nees, word=Word("consistent"))
    unexplained = nees.word.verdict == "optimistic" and not state_biases
    if nis.word.verdict == "biased" and unexplained and _scale(nees) > FAR:
        nis = replace(nis, word=Word("optimistic"))
    onset = nis.word.onset
    if (nis.word.verdict, nees.word.verdict) == ("non_white", "consistent"):
        nis = nis.called(_called_by_size(*_sums(nees)))
    late = (nis.word.verdict, nees.word.verdict) == ("late_divergence", "optimistic")
    if late and onset is not None and dishonest_before(nees, int(nis.rows[onset])):
        nis = replace(nis, word=Word("optimistic"))
    return nis, nees


def _sums(quantity: Quantity) -> tuple[float, float]:
    values, dof = quantity.trace.kept_values()
    return float(values.sum()), float(dof.sum())


def _scale(quantity: Quantity) -> float:
    total, dof = _sums(quantity)
    return total / dof


def dishonest_before(nees: Quantity, onset: int) -> bool:
    """Whether the NEES was too large already before this update: then nothing began there."""
    # The NEES may rise a little before the NIS does.
    before = nees.rows[nees.trace.kept] < onset * WELL_BEFORE
    values, dof = (column[before] for column in nees.trace.kept_values())
    total, m = float(values.sum()), float(dof.sum())
    return total > MATERIAL * m and bool(_distributions.chi2_sf(total, m) < CERTAIN)
