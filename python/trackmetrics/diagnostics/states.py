"""State by state: what observes it, how its uncertainty grew, and its part in a fault."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from trackmetrics.diagnostics.attribution import Attribution
from trackmetrics.diagnostics.results import FAILING_VERDICTS, Bias, StateDiagnosis
from trackmetrics.diagnostics.thresholds import STD_GROWTH_LIMIT, VARIANCE_REDUCTION
from trackmetrics.logs.columns import Columns, Floats
from trackmetrics.logs.derived import components_observed, observed_mask
from trackmetrics.logs.header import State

NAN = float("nan")
Mask = NDArray[np.bool_]


def diagnose_states(
    columns: Columns, states: tuple[State, ...], onset: int | None, attribution: Attribution | None
) -> tuple[StateDiagnosis, ...]:
    """One result per state; whether it is observed is decided before the ``onset`` of a fault."""
    if attribution is None and columns.observed is None and columns.std is None:
        return _unknown(states)
    observed, gains = observed_states(columns, len(states)), _information_gains(columns)
    before = slice(onset)
    return tuple(
        _diagnose(state, i, columns, observed, gains, before, attribution)
        for i, state in enumerate(states)
    )


def _diagnose(
    state: State,
    i: int,
    columns: Columns,
    observed: Mask | None,
    gains: Floats | None,
    before: slice,
    attribution: Attribution | None,
) -> StateDiagnosis:
    updates = _direct_updates(columns, None if observed is None else observed[:, i])
    growth = NO_GROWTH if columns.std is None else _growth(columns.std[:, i], columns.time)
    return StateDiagnosis(
        state=state.name,
        unit=state.unit,
        observed_by=updates.observed_by,
        num_direct_updates=updates.count,
        longest_gap=updates.longest_gap,
        reference_std=growth.reference_std,
        peak_growth=growth.peak,
        peak_time=growth.peak_time,
        growth_onset_time=growth.onset_time,
        information_gain=NAN if gains is None else _mean(gains[:, i]),
        is_observed=_is_observed(columns, gains, before, i, bool(updates.observed_by)),
        nees_share=_part(attribution, "nees_share", i),
        shapley_nees=_part(attribution, "shapley_nees", i),
        marginal_nees=_part(attribution, "marginal_nees", i),
        conditional_nees=_part(attribution, "conditional_nees", i),
    )


@lru_cache(maxsize=16)
def _unknown(states: tuple[State, ...]) -> tuple[StateDiagnosis, ...]:
    """The results for states of which the log has nothing but the names."""
    return tuple(
        StateDiagnosis(
            state=s.name,
            unit=s.unit,
            observed_by=(),
            num_direct_updates=None,
            longest_gap=NAN,
            reference_std=NAN,
            peak_growth=NAN,
            peak_time=None,
            growth_onset_time=None,
            information_gain=NAN,
            is_observed=None,
            nees_share=NAN,
            shapley_nees=NAN,
            marginal_nees=NAN,
            conditional_nees=NAN,
        )
        for s in states
    )


def _mean(values: Floats) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else NAN


def _part(attribution: Attribution | None, name: str, i: int) -> float:
    return NAN if attribution is None else float(getattr(attribution, name)[i])


# -- which updates observe a state


def observed_states(columns: Columns, states: int) -> Mask | None:
    """``(rows, n)``: which states each update observes; None where the log does not say."""
    observed = components_observed(columns)
    if observed is None or not (observed >= 0).any():
        return None
    mask: Mask = observed_mask(observed, states)
    return mask


def states_by_type(columns: Columns, names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """The states that each measurement type observes."""
    mask = observed_states(columns, len(names))
    if mask is None or columns.measurement_type is None:
        return {}
    seen: dict[str, tuple[str, ...]] = {}
    for name in dict.fromkeys(columns.measurement_type):
        if name is not None:
            states = mask[columns.measurement_type == name].any(axis=0)
            seen[name] = tuple(names[i] for i in np.flatnonzero(states))
    return seen


@dataclass(frozen=True)
class _DirectUpdates:
    """The updates that observe a state directly."""

    observed_by: tuple[str, ...] = ()
    count: int | None = None
    longest_gap: float = NAN


def _direct_updates(columns: Columns, observed: Mask | None) -> _DirectUpdates:
    if observed is None:
        return _DirectUpdates()
    rows = np.flatnonzero(observed)
    names: dict[str, None] = {}
    if len(rows):
        types = columns.measurement_type
        names = dict.fromkeys(["measurement"] if types is None else types[rows].tolist())
    times = np.concatenate([columns.time[:1], columns.time[rows], columns.time[-1:]])
    return _DirectUpdates(tuple(map(str, names)), len(rows), float(np.diff(times).max()))


def _information_gains(columns: Columns) -> Floats | None:
    """1 - P+/P- of each update and state."""
    if columns.P is None or columns.P_pred is None:
        return None
    after, before = (p.diagonal(axis1=1, axis2=2) for p in (columns.P, columns.P_pred))
    gains: Floats = 1.0 - after / np.where(before > 0, before, np.nan)
    return gains


def _is_observed(
    columns: Columns, gains: Floats | None, before: slice, i: int, has_direct: bool
) -> bool | None:
    """Whether any update has removed half of the variance; None where the log does not say."""
    if gains is not None and not np.isnan(gains[before, i]).all():
        return bool(np.nanmax(gains[before, i]) >= VARIANCE_REDUCTION)
    if columns.std is None or (columns.observed is None and not has_direct):
        return None
    if has_direct:
        return True
    std = columns.std[before, i]
    std = std[~np.isnan(std)]
    return bool(len(std) > 1 and (std[1:] <= std[:-1] * VARIANCE_REDUCTION**0.5).any())


# -- growth of the claimed standard deviation


@dataclass(frozen=True)
class _Growth:
    """First claimed deviation, its largest growth, and when it had doubled."""

    reference_std: float = NAN
    peak: float = NAN
    peak_time: float | None = None
    onset_time: float | None = None


NO_GROWTH = _Growth()


def _growth(std: Floats, time: Floats) -> _Growth:
    known = ~np.isnan(std)
    std, time = std[known], time[known]
    if not len(std) or std[0] <= 0:
        return _Growth(float(std[0])) if len(std) else NO_GROWTH
    ratio = std / std[0]
    peak, doubled = int(np.argmax(ratio)), ratio > STD_GROWTH_LIMIT
    first = np.flatnonzero(doubled[:-1] & doubled[1:])
    onset = float(time[first[0]]) if len(first) else None
    return _Growth(float(std[0]), float(ratio[peak]), float(time[peak]), onset)


# -- the weakest state


def weakest_state(
    verdict: str, nees: str | None, states: tuple[StateDiagnosis, ...], biases: tuple[Bias, ...]
) -> str | None:
    """The weakest state of a track that fails; a bias without truth names its component.

    ``verdict`` is that of the track, ``nees`` that of its NEES.
    """
    if verdict not in FAILING_VERDICTS:
        return None
    if nees in FAILING_VERDICTS:
        return _weakest(states)
    if verdict.startswith("startup"):
        return None
    if verdict == "biased":
        return max(biases, key=lambda b: abs(b.z)).component if biases else None
    return _weakest(states)


def _weakest(states: tuple[StateDiagnosis, ...]) -> str | None:
    """The state with the largest share; without truth one that no update observes, else the first
    whose claimed deviation doubles."""
    shares = [(s.nees_share, s.state) for s in states if not np.isnan(s.nees_share)]
    if shares:
        return max(shares, key=lambda pair: pair[0])[1]
    unobserved = [s.state for s in states if s.is_observed is False]
    if len(unobserved) == 1:
        return unobserved[0]
    grown = [s for s in states if s.growth_onset_time is not None]
    grown.sort(key=lambda s: (s.growth_onset_time, -s.peak_growth))
    return grown[0].state if grown else None
