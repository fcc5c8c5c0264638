"""State by state: what supports it, how its uncertainty grew, and its part in a fault."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from trackmetrics import _backend
from trackmetrics.diagnostics.records import StateDiagnosis
from trackmetrics.logs.columns import Columns, Floats, Integers, components
from trackmetrics.logs.derived import components_observed, observed_mask
from trackmetrics.logs.header import State
from trackmetrics.logs.validation import completed

EXACT = 10
"""Up to this many states the Shapley split is exact."""
ORDERS = 2000
SEED = 20260224
DOUBLED = 2.0
HALVED = 0.5
NAN = float("nan")


@dataclass(frozen=True)
class Attribution:
    """The mean squared error of each state over the updates that have it, in three readings."""

    parts: Floats
    """Its part of the sum of all NEES."""
    shares: Floats
    marginal: Floats
    unique: Floats


def attribute(errors: Floats, covariances: Floats) -> Attribution:
    """Splits the NEES of these updates over the states.

    Shapley shares add up to the NEES; a marginal value is e_i^2 / P_ii; a unique one is what the
    NEES loses without the state, (P^-1 e)_i^2 / (P^-1)_ii. A component that is missing takes no
    part in its update.
    """
    d, there = errors.shape[1], components(errors, covariances)
    covariances = completed(covariances, there)
    std = np.sqrt(covariances.diagonal(axis1=1, axis2=2))
    e, p = np.where(there, errors, 0.0) / std, covariances / std[:, :, None] / std[:, None, :]
    e, p = np.ascontiguousarray(e), np.ascontiguousarray((p + p.swapaxes(1, 2)) / 2)
    if d <= EXACT:
        shares = _backend.kernels.shapley_shares(e, p)
    else:
        shares = _backend.kernels.sampled_shapley_shares(e, p, _orders(d))
    inverse = np.linalg.inv(p)
    pulled = np.einsum("kij,kj->ki", inverse, e)
    unique = pulled**2 / inverse.diagonal(axis1=1, axis2=2)
    total, count = float(shares.sum()), there.sum(axis=0)
    parts = shares.sum(axis=0) / total if total > 0 else np.full(d, NAN)
    means = (_share(column.sum(axis=0), count) for column in (shares, e**2, unique))
    return Attribution(np.where(count > 0, parts, NAN), *means)


def _share(sums: Floats, count: Integers) -> Floats:
    return np.where(count > 0, sums / np.maximum(count, 1), NAN)


@lru_cache(maxsize=8)
def _orders(states: int) -> Integers:
    generator = np.random.default_rng(SEED)
    drawn = np.tile(np.arange(states), (ORDERS, 1))
    orders: Integers = generator.permuted(drawn, axis=1).astype(np.int64).ravel()
    return orders


def state_records(
    columns: Columns, states: tuple[State, ...], onset: int | None, attribution: Attribution | None
) -> tuple[StateDiagnosis, ...]:
    """One record a state; support is counted before the ``onset`` of a fault, if there is one."""
    if attribution is None and columns.observed is None and columns.std is None:
        return _unknown(states)
    observed = observed_states(columns, len(states))
    growth = _growth(columns)
    gains = _gains(columns)
    before = slice(onset)
    records = []
    for i, state in enumerate(states):
        kinds, support, gap = _support(columns, None if observed is None else observed[:, i])
        reference, peak, peak_time, first = growth[i] if growth else (NAN, NAN, None, None)
        gain = NAN if gains is None else _mean(gains[:, i])
        supported = _supported(columns, gains, before, i, bool(kinds))
        share, nees, marginal, unique = _part(attribution, i)
        records.append(
            StateDiagnosis(
                state.name,
                state.unit,
                kinds,
                support,
                gap,
                reference,
                peak,
                peak_time,
                first,
                gain,
                supported,
                share,
                nees,
                marginal,
                unique,
            )
        )
    return tuple(records)


@lru_cache(maxsize=16)
def _unknown(states: tuple[State, ...]) -> tuple[StateDiagnosis, ...]:
    """Records of states of which the log has nothing but the names."""
    return tuple(
        StateDiagnosis(
            s.name, s.unit, (), None, NAN, NAN, NAN, None, None, NAN, None, NAN, NAN, NAN, NAN
        )
        for s in states
    )


def _mean(values: Floats) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else NAN


def _part(attribution: Attribution | None, i: int) -> tuple[float, float, float, float]:
    if attribution is None:
        return NAN, NAN, NAN, NAN
    a = attribution
    return float(a.parts[i]), float(a.shares[i]), float(a.marginal[i]), float(a.unique[i])


def observed_states(columns: Columns, states: int) -> Integers | None:
    """``(rows, n)``: which states each update observes; None where the log does not say."""
    observed = components_observed(columns)
    if observed is None or not (observed >= 0).any():
        return None
    mask: Integers = observed_mask(observed, states)
    return mask


def _support(
    columns: Columns, observed: Integers | None
) -> tuple[tuple[str, ...], int | None, float]:
    """The measurement types that observe a state, how many updates do, and the longest gap."""
    if observed is None:
        return (), None, NAN
    rows = np.flatnonzero(observed)
    kinds: dict[str, None] = {}
    if len(rows):
        types = columns.measurement_type
        kinds = dict.fromkeys(["measurement"] if types is None else types[rows].tolist())
    times = np.concatenate([columns.time[:1], columns.time[rows], columns.time[-1:]])
    return tuple(str(k) for k in kinds), len(rows), float(np.diff(times).max())


def _growth(columns: Columns) -> list[tuple[float, float, float | None, float | None]]:
    """Of each state: first claim, largest ratio to it, its time, and when it had doubled."""
    if columns.std is None:
        return []
    return [_growth_of(std, columns.time) for std in columns.std.T]


def _growth_of(std: Floats, time: Floats) -> tuple[float, float, float | None, float | None]:
    known = ~np.isnan(std)
    std, time = std[known], time[known]
    if not len(std) or std[0] <= 0:
        return float(std[0]) if len(std) else NAN, NAN, None, None
    ratio = std / std[0]
    peak, doubled = int(np.argmax(ratio)), ratio > DOUBLED
    first = np.flatnonzero(doubled[:-1] & doubled[1:])
    onset = float(time[first[0]]) if len(first) else None
    return float(std[0]), float(ratio[peak]), float(time[peak]), onset


def _gains(columns: Columns) -> Floats | None:
    """1 - P+/P- of each update and state."""
    if columns.P is None or columns.P_pred is None:
        return None
    after, before = (p.diagonal(axis1=1, axis2=2) for p in (columns.P, columns.P_pred))
    gains: Floats = 1.0 - after / np.where(before > 0, before, np.nan)
    return gains


def _supported(
    columns: Columns, gains: Floats | None, before: slice, i: int, observed: bool
) -> bool | None:
    """Whether any update has cut the variance by half; None where the log cannot tell."""
    if gains is not None and not np.isnan(gains[before, i]).all():
        return bool(np.nanmax(gains[before, i]) >= HALVED)
    if columns.std is None or (columns.observed is None and not observed):
        return None
    if observed:
        return True
    std = columns.std[before, i]
    std = std[~np.isnan(std)]
    return bool(len(std) > 1 and (std[1:] <= std[:-1] * HALVED**0.5).any())


def weakest(records: tuple[StateDiagnosis, ...]) -> str | None:
    """The state with the largest share; without truth one that nothing supports, else the first
    whose claim doubles."""
    shares = [(r.share, r.state) for r in records if not np.isnan(r.share)]
    if shares:
        return max(shares, key=lambda pair: pair[0])[1]
    unsupported = [r.state for r in records if r.supported is False]
    if len(unsupported) == 1:
        return unsupported[0]
    grown = [r for r in records if r.growth_onset_time is not None]
    grown.sort(key=lambda r: (r.growth_onset_time, -r.peak_growth))
    return grown[0].state if grown else None
