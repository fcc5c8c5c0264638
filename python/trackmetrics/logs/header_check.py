"""What can be wrong with the header of a log, and the message that names the argument."""

from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np

from trackmetrics._tables.errors import shown, value
from trackmetrics.logs.header import LogHeader, State
from trackmetrics.logs.schema import COVARIANCE_COLUMNS, COVARIANCE_FORMS


def check_header(header: LogHeader) -> None:
    """Refuse the first thing that cannot be meant."""
    dim = header.state_dim
    if dim is not None and (not _is_whole(dim) or dim < 1):
        raise ValueError(f"state_dim must be a whole number of at least 1, got {value(dim)}")
    for name in ("time_unit", "epoch"):
        text = getattr(header, name)
        if text is not None and not isinstance(text, str):
            raise TypeError(f"{name} must be text, got {value(text)}")
    _check_states(header.states)
    _check_mapping("angles", header.angles, "states to periods")
    for key, period in (header.angles or {}).items():
        _check_period(f"angles[{value(key)}]", period)
    _check_mapping("measurement_angles", header.measurement_angles, "types to angles")
    for kind, angles in (header.measurement_angles or {}).items():
        _check_mapping(f"measurement_angles[{value(kind)}]", angles, "components to periods")
        for component, period in angles.items():
            if not _is_whole(component):
                raise ValueError(
                    f"measurement_angles[{value(kind)}]: no component {value(component)}"
                )
            _check_period(f"measurement_angles[{value(kind)}][{value(component)}]", period)
    _check_mapping("covariance_forms", header.covariance_forms, "columns to forms")
    for name, form in (header.covariance_forms or {}).items():
        if name not in COVARIANCE_COLUMNS:
            known = shown(COVARIANCE_COLUMNS)
            raise ValueError(f"covariance_forms: no covariance {value(name)}; there are {known}")
        if form not in COVARIANCE_FORMS:
            raise ValueError(
                f"covariance_forms[{name!r}] must be one of {shown(COVARIANCE_FORMS)}, "
                f"got {value(form)}"
            )


def _check_states(states: Any) -> None:
    if isinstance(states, (str, bytes)):
        raise TypeError(f"states must be a list of names, got {value(states)}")
    for i, state in enumerate(states or ()):
        if not isinstance(state, State):
            if not isinstance(state, str) or not state:
                raise ValueError(f"states[{i}] must be a name or a State, got {value(state)}")
        elif not isinstance(state.name, str) or not state.name:
            raise ValueError(f"states[{i}].name must be a name, got {value(state.name)}")
        elif state.period is not None:
            _check_period(f"states[{i}].period", state.period)


def _check_mapping(name: str, given: Any, what: str) -> None:
    if given is not None and not isinstance(given, Mapping):
        raise TypeError(f"{name} must be a mapping of {what}, got {value(given)}")


def _check_period(name: str, period: Any) -> None:
    is_number = isinstance(period, Real) and not isinstance(period, (bool, np.bool_))
    if not is_number or not period > 0 or not np.isfinite(period):
        raise ValueError(f"{name} must be a positive period, got {value(period)}")


def _is_whole(given: Any) -> bool:
    return isinstance(given, Integral) and not isinstance(given, bool)
