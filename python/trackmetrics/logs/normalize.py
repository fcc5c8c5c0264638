"""From columns as users have them to a log: forms, order, repeated rows, what follows from what."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs import columns as forms
from trackmetrics.logs.columns import Columns
from trackmetrics.logs.derived import derive
from trackmetrics.logs.header import Header, State
from trackmetrics.logs.ordering import arrange
from trackmetrics.logs.validation import check_values


class Parts(NamedTuple):
    """What a log is made of, in the order in which it takes them."""

    columns: Columns
    tracks: Sequence[str]
    starts: Sequence[int]
    states: Sequence[State]
    measurement_angles: Mapping[str, Mapping[int, float]]
    computed: Mapping[str, NDArray[np.bool_]]
    repeated: Sequence[int]
    time_unit: str


def build(given: Mapping[str, Any], header: Header) -> Parts:
    """The parts of the log of these columns."""
    given = {name: values for name, values in given.items() if values is not None}
    _refuse_unknown(given)
    rows = _count(given)
    states = _states(given, header)
    columns = _settle_forms(given, rows, states)
    names = forms.words("track", given.get("track", "track"), rows)
    check_values(columns, "time" in given)
    columns, tracks, starts, repeated = arrange(columns, names, "time" in given)
    angles = {k: dict(v) for k, v in (header.measurement_angles or {}).items()}
    columns, computed = derive(columns, states, angles)
    return Parts(columns, tracks, starts, states, angles, computed, repeated, header.time_unit)


def _refuse_unknown(given: Mapping[str, Any]) -> None:
    unknown = [name for name in given if name not in forms.KNOWN]
    if unknown:
        raise ValueError(f"unknown column {unknown[0]!r}; a log has {', '.join(forms.KNOWN)}")
    if not any(name in given for name in forms.FLOATS):
        raise ValueError("the log has no column to diagnose: expected nis and nis_dof, or more")


def _count(given: Mapping[str, Any]) -> int:
    """The number of rows: of the first column that has one."""
    for values in given.values():
        if isinstance(values, str) or not hasattr(values, "__len__"):
            continue
        if len(values):
            return len(values)
        break
    raise ValueError("the log is empty: expected at least one row")


def _states(given: Mapping[str, Any], header: Header) -> tuple[State, ...]:
    """Every state with its name, unit and period."""
    names = header.states
    if names is None:
        names = [f"x[{i}]" for i in range(header.state_dim or _state_width(given))]
    states = [s if isinstance(s, State) else State(str(s)) for s in names]
    if header.state_dim not in (None, len(states)):
        raise ValueError(f"state_dim is {header.state_dim}, states has {len(states)} names")
    place = {state.name: i for i, state in enumerate(states)}
    if len(place) < len(states):
        raise ValueError(f"states must have different names, got {[s.name for s in states]}")
    for key, period in (header.angles or {}).items():
        i = forms.state_index("angles", key, place)
        states[i] = State(states[i].name, states[i].unit, _period(key, period))
    return tuple(states)


def _period(key: str | int, period: float) -> float:
    if not period > 0 or not np.isfinite(period):
        raise ValueError(f"angles[{key!r}] must be a positive period, got {period!r}")
    return float(period)


def _state_width(given: Mapping[str, Any]) -> int:
    """The number of states, from the first column that tells."""
    for name in forms.STATES:
        if name in given:
            return max((np.size(v) for v in given[name] if v is not None), default=0)
    for name in forms.STATE_MATRICES:
        if name in given:
            return max((np.shape(v)[0] for v in given[name] if np.ndim(v) == 2), default=0)
    if "nees" in given and "nees_dof" not in given:
        raise ValueError("nees needs the number of states: give state_dim, states or nees_dof")
    return 0


def _settle_forms(given: Mapping[str, Any], rows: int, states: Sequence[State]) -> Columns:
    """Every column as one array."""
    n = len(states)
    place = {state.name: i for i, state in enumerate(states)}
    columns: dict[str, Any] = {"row": np.arange(rows)}
    columns["time"] = forms.numbers("time", given.get("time", np.zeros(rows)), rows)
    for name in set(given) - {"track", "time"}:
        values = given[name]
        if name in forms.WORDS:
            columns[name] = forms.words(name, values, rows)
        elif name in forms.NUMBERS:
            columns[name] = forms.numbers(name, values, rows)
        elif name == "observed":
            columns[name] = forms.indices(name, values, rows, place)
        elif name in forms.OBSERVATIONS:
            columns[name] = forms.observations(name, values, rows, n)
        elif name in forms.STATES + forms.MEASUREMENTS:
            width = n if name in forms.STATES else None
            columns[name] = forms.vectors(name, values, rows, width)
        else:
            width = n if name in forms.STATE_MATRICES else None
            columns[name] = forms.matrices(name, values, rows, width)
    return _align(Columns(**columns))


def _align(columns: Columns) -> Columns:
    """Measurement columns of one common width."""
    names = [n for n in (*forms.MEASUREMENTS, "observed") if getattr(columns, n) is not None]
    squares = [n for n in forms.MEASUREMENT_MATRICES if getattr(columns, n) is not None]
    wide = [n for n in forms.OBSERVATIONS if getattr(columns, n) is not None]
    width = max((getattr(columns, n).shape[1] for n in names + squares + wide), default=0)
    wider = {}
    for name in names + squares:
        column = getattr(columns, name)
        missing = [(0, 0)] + [(0, width - column.shape[1])] * (column.ndim - 1)
        wider[name] = np.pad(column, missing, constant_values=-1 if name == "observed" else np.nan)
    for name in wide:
        column = getattr(columns, name)
        missing = [(0, 0), (0, width - column.shape[1]), (0, 0)]
        wider[name] = np.pad(column, missing, constant_values=np.nan)
    return columns.with_(**wider)
