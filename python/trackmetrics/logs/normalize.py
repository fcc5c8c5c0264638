"""From columns as users have them to the parts of a log."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import headings, times
from trackmetrics._tables.columns import Ragged
from trackmetrics._tables.errors import shown, value
from trackmetrics.logs import coercion, schema
from trackmetrics.logs.columns import Columns, Integers
from trackmetrics.logs.derived import derive
from trackmetrics.logs.header import LogHeader, State
from trackmetrics.logs.header_check import check_header
from trackmetrics.logs.ordering import group_by_track
from trackmetrics.logs.updates import scale_and_drop
from trackmetrics.logs.validation import check_values


@dataclass(frozen=True)
class LogParts:
    """What a log is made of."""

    columns: Columns
    tracks: Sequence[str]
    starts: Sequence[int]
    states: Sequence[State]
    measurement_angles: Mapping[str, Mapping[int, float]]
    computed: Mapping[str, NDArray[np.bool_]]
    repeated: Sequence[int]
    time_unit: str
    epoch: str | None
    notes: tuple[str, ...]


def normalize(given: Mapping[str, Any], header: LogHeader) -> LogParts:
    """The parts of the log of these columns."""
    given = {name: values for name, values in given.items() if values is not None}
    _refuse_unknown(given)
    rows = _count(given)
    states = _states(given, header)
    timed = "time" in given
    found = _times(given, header, rows)
    columns = _as_columns(given, rows, states, header).replace(time=found.seconds)
    names = coercion.as_strings("track", given.get("track", "track"), rows)
    check_values(columns, timed)
    columns, names, notes = scale_and_drop(columns, names, header)
    grouped = group_by_track(columns, names, timed, header.on_repeats)
    angles = {k: dict(v) for k, v in (header.measurement_angles or {}).items()}
    columns, computed = derive(grouped.columns, states, angles)
    return LogParts(
        columns,
        grouped.tracks,
        grouped.starts,
        states,
        angles,
        computed,
        grouped.repeated,
        # Dates become seconds, whatever unit numbers would have.
        "s" if found.epoch else header.time_unit or "s",
        found.epoch or header.epoch,
        tuple(note for note in (found.note, *notes) if note),
    )


def _refuse_unknown(given: Mapping[str, Any]) -> None:
    unknown = [name for name in given if name not in schema.COLUMN_NAMES]
    if unknown:
        meant = headings.closest(unknown[0], schema.COLUMN_NAMES)
        hint = f"did you mean {meant}?" if meant else f"a log has {', '.join(schema.COLUMN_NAMES)}"
        raise ValueError(f"unknown column {value(unknown[0])}; {hint}")
    if not any(name in given for name in schema.NUMERIC_COLUMNS):
        raise ValueError("the log has no column to diagnose: expected nis and nis_dof, or more")


def _count(given: Mapping[str, Any]) -> int:
    """The number of rows: of the first column that has one."""
    for values in given.values():
        if isinstance(values, str) or not hasattr(values, "__len__"):
            continue
        if isinstance(values, np.ndarray) and values.ndim == 0:
            continue
        if len(values):
            return len(values)
        raise ValueError("the log is empty: expected at least one row")
    raise ValueError(
        f"no column has rows ({shown(given)}): give at least one as an array or a list"
    )


def _times(given: Mapping[str, Any], header: LogHeader, rows: int) -> times.Times:
    if "time" not in given:
        return times.Times(np.zeros(rows))
    given_times = given["time"]
    if isinstance(given_times, Ragged):
        given_times = coercion.as_scalars("time", given_times, rows)
    if np.ndim(given_times) == 0:
        given_times = np.full(rows, given_times)
    if len(given_times) != rows:
        raise ValueError(f"time has {len(given_times)} rows, the log has {rows}")
    found = times.to_seconds(given_times, "time", header.time_unit, header.date_order)
    return times.Times(found.seconds.reshape(rows), found.epoch, found.note)


def _states(given: Mapping[str, Any], header: LogHeader) -> tuple[State, ...]:
    """Every state with its name, unit and period."""
    check_header(header)
    names = header.states
    if names is None:
        names = [f"x[{i}]" for i in range(header.state_dim or _state_width(given, header))]
    states = [s if isinstance(s, State) else State(str(s)) for s in names]
    if header.state_dim not in (None, len(states)):
        raise ValueError(f"state_dim is {header.state_dim}, states has {len(states)} names")
    place = {state.name: i for i, state in enumerate(states)}
    if len(place) < len(states):
        raise ValueError(f"states must have different names, got {shown(s.name for s in states)}")
    for key, period in (header.angles or {}).items():
        i = coercion.state_index("angles", key, place)
        states[i] = State(states[i].name, states[i].unit, float(period))
    return tuple(states)


def _state_width(given: Mapping[str, Any], header: LogHeader) -> int:
    """The number of states, from the first column that tells."""
    for name in schema.STATE_VECTOR_COLUMNS:
        if name in given:
            values = given[name]
            if isinstance(values, np.ndarray) and values.ndim == 2:
                return int(values.shape[1])
            return int(coercion.as_ragged(name, values, len(values)).lengths.max(initial=0))
    for name in schema.STATE_MATRIX_COLUMNS:
        if name in given:
            form = (header.covariance_forms or {}).get(name)
            matrices = coercion.as_matrices(name, given[name], len(given[name]), None, None, form)
            return int(matrices.shape[1])
    if "nees" in given and "nees_dof" not in given:
        raise ValueError("nees needs the number of states: give state_dim, states or nees_dof")
    return 0


def _as_columns(
    given: Mapping[str, Any], rows: int, states: Sequence[State], header: LogHeader
) -> Columns:
    """Every column but the time as one array."""
    n = len(states)
    place = {state.name: i for i, state in enumerate(states)}
    columns: dict[str, Any] = {"row": np.arange(rows), "time": np.zeros(rows)}
    cut = header.missing_ends_cut
    # Vectors first: their lengths tell the sizes of the measurement's matrices.
    for name in sorted(given, key=lambda name: name in schema.MEASUREMENT_MATRIX_COLUMNS):
        values = given[name]
        if name in ("track", "time"):
            continue
        if name in schema.STRING_COLUMNS:
            columns[name] = coercion.as_strings(name, values, rows)
        elif name in schema.SCALAR_COLUMNS:
            columns[name] = coercion.as_scalars(name, values, rows)
        elif name == "observed":
            columns[name] = coercion.as_indices(name, values, rows, place)
        elif name in schema.OBSERVATION_COLUMNS:
            columns[name] = coercion.as_observations(name, values, rows, n)
        elif name in schema.STATE_VECTOR_COLUMNS:
            columns[name] = coercion.as_vectors(name, values, rows, n)
        elif name in schema.MEASUREMENT_VECTOR_COLUMNS:
            columns[name] = coercion.as_vectors(name, values, rows, None)
        else:
            is_state = name in schema.STATE_MATRIX_COLUMNS
            sizes = None if is_state else _measurement_sizes(columns)
            form = (header.covariance_forms or {}).get(name)
            width = n if is_state else None
            columns[name] = coercion.as_matrices(
                name, values, rows, width, sizes, form, may_be_smaller=is_state or cut
            )
    return _align(Columns(**columns))


def _measurement_sizes(columns: Mapping[str, Any]) -> Integers | None:
    """How many components each row's measurement has; 0 where no vector tells."""
    for name in schema.MEASUREMENT_VECTOR_COLUMNS[::-1]:
        if name in columns:
            values = columns[name]
            width = np.arange(1, values.shape[1] + 1)
            sizes: Integers = np.where(np.isnan(values), 0, width).max(axis=1, initial=0)
            return sizes
    if "observed" in columns:
        observed: Integers = (columns["observed"] >= 0).sum(axis=1)
        return observed
    return None


def _align(columns: Columns) -> Columns:
    """Measurement columns of one common width."""
    along_rows = [*schema.MEASUREMENT_VECTOR_COLUMNS, "observed", *schema.OBSERVATION_COLUMNS]
    vectors = [n for n in along_rows if getattr(columns, n) is not None]
    squares = [n for n in schema.MEASUREMENT_MATRIX_COLUMNS if getattr(columns, n) is not None]
    width = max((getattr(columns, n).shape[1] for n in vectors + squares), default=0)
    wider = {}
    for name in vectors + squares:
        column = getattr(columns, name)
        missing = width - column.shape[1]
        if missing:
            fill = -1 if name == "observed" else np.nan
            pads = [(0, 0), (0, missing)] + [(0, missing if name in squares else 0)] * (
                column.ndim - 2
            )
            wider[name] = np.pad(column, pads, constant_values=fill)
    return columns.replace(**wider) if wider else columns
