"""What follows from other columns: errors, innovations, NIS, NEES, standard deviations."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._angles import wrap
from trackmetrics._covariances import quadratic_forms, valid_components
from trackmetrics._tables.errors import value
from trackmetrics.logs.columns import Columns, Floats, Integers, has_value
from trackmetrics.logs.header import State
from trackmetrics.logs.validation import check_covariances

Angles = Mapping[str, Mapping[int, float]]


def derive(
    columns: Columns, states: Sequence[State], measurement_angles: Angles
) -> tuple[Columns, dict[str, NDArray[np.bool_]]]:
    """The columns completed, and which rows of which column were computed."""
    check_covariances(columns)
    logged, periods = columns, component_periods(columns, states, measurement_angles)
    columns = columns.replace(
        innovation=_filled(columns.innovation, _innovations(columns, periods)),
        S=_filled(columns.S, _innovation_covariances(columns)),
        error=_filled(columns.error, _errors(columns, states)),
        std=_filled(columns.std, _deviations(columns)),
    )
    residuals = columns.innovation
    if residuals is not None and periods is not None:
        residuals = wrap(residuals, periods)
    columns = columns.replace(
        nis=_filled(columns.nis, _forms(residuals, columns.S)),
        nees=_filled(columns.nees, _forms(columns.error, columns.P)),
    )
    computed = {
        name: _computed_rows(getattr(logged, name), getattr(columns, name))
        for name in ("innovation", "S", "error", "std", "nis", "nees")
    }
    dofs = {
        "nis_dof": _dof_of_computed(columns.nis_dof, _nis_dof(columns), computed["nis"]),
        "nees_dof": _dof_of_computed(
            columns.nees_dof, _nees_dof(columns, len(states)), computed["nees"]
        ),
    }
    columns = columns.replace(**dofs)
    for name, dof in dofs.items():
        computed[name] = _computed_rows(getattr(logged, name), dof)
        source = computed[name.removesuffix("_dof")]
        if dof is not None and source is not None:
            computed[name] |= source
    return columns, {name: rows for name, rows in computed.items() if rows is not None}


def _computed_rows(logged: Floats | None, column: Floats | None) -> Any:
    """Which rows have a value that was not logged."""
    if column is None or logged is None:
        return None if column is None else has_value(column)
    return has_value(column) & ~has_value(logged)


def component_periods(
    columns: Columns, states: Sequence[State], measurement_angles: Angles
) -> Floats | None:
    """``(rows, m)``: the period of each component of the measurement, NaN where it is no angle."""
    width = _measurement_width(columns)
    if not width:
        return None
    periods = np.full((len(columns), width), np.nan)
    if columns.observed is not None and len(states):
        of_state = np.array([s.period or np.nan for s in states] + [np.nan])
        periods[:, : columns.observed.shape[1]] = of_state[columns.observed]
    if columns.measurement_type is not None:
        for kind, angles in measurement_angles.items():
            for component, period in angles.items():
                if not 0 <= component < width:
                    raise ValueError(
                        f"measurement_angles[{value(kind)}]: no component {value(component)}"
                    )
                periods[columns.measurement_type == kind, component] = period
    return periods


def _measurement_width(columns: Columns) -> int:
    for name in ("innovation", "z", "S", "R"):
        column = getattr(columns, name)
        if column is not None:
            return int(column.shape[1])
    return 0


def _filled(logged: Any, computed: Floats | None) -> Any:
    """The logged values, and computed ones in rows without."""
    if logged is None or computed is None:
        return computed if logged is None else logged
    there = has_value(logged).reshape((-1,) + (1,) * (logged.ndim - 1))
    return np.where(there, logged, computed)


def _forms(errors: Floats | None, covariances: Floats | None) -> Floats | None:
    return None if errors is None or covariances is None else quadratic_forms(errors, covariances)


def _errors(columns: Columns, states: Sequence[State]) -> Floats | None:
    if columns.x is None or columns.truth is None:
        return None
    with np.errstate(over="ignore"):
        error = columns.x - columns.truth
    return wrap(error, np.array([s.period or np.nan for s in states]))


def _deviations(columns: Columns) -> Floats | None:
    return None if columns.P is None else np.sqrt(columns.P.diagonal(axis1=1, axis2=2))


def _innovations(columns: Columns, periods: Floats | None) -> Floats | None:
    """z minus the predicted states that it observes, angles wrapped."""
    if columns.z is None or columns.x_pred is None or columns.observed is None or periods is None:
        return None
    predicted = _observed_states(columns.x_pred, columns.observed)
    return wrap(columns.z - predicted, periods)


def _innovation_covariances(columns: Columns) -> Floats | None:
    """H P- H' + R where each component observes one state."""
    if columns.P_pred is None or columns.R is None or columns.observed is None:
        return None
    o = columns.observed
    rows = np.arange(len(o))[:, None, None]
    chosen = columns.P_pred[rows, o[:, :, None], o[:, None, :]]
    return np.where((o >= 0)[:, :, None] & (o >= 0)[:, None, :], chosen, np.nan) + columns.R


def components_observed(columns: Columns) -> Integers | None:
    """``observed`` without the components that an update's innovation lacks."""
    if columns.observed is None or columns.innovation is None:
        return columns.observed
    lacking = np.isnan(columns.innovation) & has_value(columns.innovation)[:, None]
    return np.where(lacking, -1, columns.observed)


def observed_mask(observed: Integers, states: int) -> Any:
    """``(rows, n)``: which states each row observes."""
    mask = np.zeros((len(observed), states + 1), bool)
    np.put_along_axis(mask, observed, True, axis=1)
    return mask[:, :states]


def _observed_states(states: Floats, observed: Integers) -> Floats:
    chosen = np.take_along_axis(states, np.maximum(observed, 0), axis=1)
    return np.where(observed >= 0, chosen, np.nan)


def _nis_dof(columns: Columns) -> Floats | None:
    """How many components the innovation has, else the measurement."""
    if columns.innovation is not None:
        return _count(columns.innovation, columns.S)
    return None if columns.z is None else _count(columns.z, None)


def _nees_dof(columns: Columns, states: int) -> Floats | None:
    """How many components error and covariance have; all states where the NEES stands alone."""
    if columns.nees is None:
        return None
    dof = np.full(len(columns), float(states))
    if columns.error is not None and columns.P is not None:
        own = valid_components(columns.error, columns.P).sum(axis=1)
        dof = np.where(own > 0, own, dof)
    return np.where(np.isnan(columns.nees), np.nan, dof)


def _count(vectors: Floats, covariances: Floats | None) -> Floats:
    """How many components each row has, with a variance if it has any; NaN for none."""
    there = ~np.isnan(vectors)
    if covariances is not None:
        there &= valid_components(vectors, covariances) | ~has_value(covariances)[:, None]
    count = there.sum(axis=1).astype(np.float64)
    return np.where(count > 0, count, np.nan)


def _dof_of_computed(logged: Floats | None, own: Floats | None, computed: Any) -> Floats | None:
    """Degrees of freedom as logged; but a value that was computed here has its own."""
    if logged is None or own is None or computed is None:
        return own if logged is None else logged
    dof: Floats = np.where(computed & ~np.isnan(own), own, _filled(logged, own))
    return dof
