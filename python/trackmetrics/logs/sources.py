"""Columns from the runs of other libraries: filterpy's savers, Stone Soup's tracks."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

Record = dict[str, Any]
Table = dict[str, list[Any]]


def from_filterpy(savers: Any, truths: Any, times: Any) -> Table:
    """The columns of one saver, or of several by the names of their tracks."""
    named = savers if isinstance(savers, Mapping) else {"track": savers}
    truth_of = truths if isinstance(truths, Mapping) else dict.fromkeys(named, truths)
    times_of = times if isinstance(times, Mapping) else dict.fromkeys(named, times)
    records: list[Record] = []
    for name, saver in named.items():
        records += _saved(name, saver, truth_of.get(name), times_of.get(name))
    return _columns(records)


def _saved(name: str, saver: Any, truth: Any, times: Any) -> list[Record]:
    """What a saver holds, one record an epoch; an epoch without measurement has no innovation."""
    count = len(saver.x)
    for argument, values in (("truth", truth), ("times", times)):
        if values is not None and len(values) != count:
            raise ValueError(f"{argument} has {len(values)} rows, the saver has {count}")
    records = []
    for k in range(count):
        measured = saver.z[k] is not None and not all(v is None for v in np.ravel(saver.z[k]))
        record: Record = {
            "track": name,
            "time": float(k) if times is None else times[k],
            "x": np.ravel(saver.x[k]),
            "P": np.asarray(saver.P[k]),
            "truth": None if truth is None else np.ravel(truth[k]),
            "status": "active" if measured else "tentative",
        }
        records.append(record | (_measured(saver, k) if measured else {}))
    return records


def _measured(saver: Any, k: int) -> Record:
    record: Record = {
        "x_pred": np.ravel(saver.x_prior[k]),
        "P_pred": np.asarray(saver.P_prior[k]),
        "innovation": np.ravel(saver.y[k]),
        "S": np.atleast_2d(saver.S[k]),
        "z": np.ravel(saver.z[k]),
        "measurement_type": "measurement",
    }
    if hasattr(saver, "H"):
        record["H"] = np.atleast_2d(saver.H[k])
    if all(hasattr(saver, name) for name in ("K", "H", "F")):
        gain = np.asarray(saver.K[k]) @ np.asarray(saver.H[k])
        record["A"] = (np.eye(len(gain)) - gain) @ np.asarray(saver.F[k])
    return record


def from_stone_soup(tracks: Iterable[Any], truths: Any) -> Table:
    """The columns of Stone Soup's tracks: one row for each state that is an update."""
    truth_of = truths if isinstance(truths, Mapping) else {}
    records: list[Record] = []
    for track in tracks:
        truth = truth_of.get(track, truth_of.get(track.id))
        at = {} if truth is None else {s.timestamp: np.ravel(s.state_vector) for s in truth}
        records += [_updated(track, s, at) for s in track.states if hasattr(s, "hypothesis")]
    if not records:
        raise ValueError("tracks hold no update: expected states with a hypothesis")
    start = min(record["time"] for record in records)
    for record in records:
        record["time"] = (record["time"] - start).total_seconds()
    return _columns(records)


def _updated(track: Any, state: Any, truth: Mapping[Any, Any]) -> Record:
    record: Record = {"track": str(track.id), "time": state.timestamp, "status": "tentative"}
    record |= {"x": _vector(state), "P": _matrix(state), "truth": truth.get(state.timestamp)}
    hypothesis = state.hypothesis
    measurement = getattr(hypothesis, "measurement", None)
    predicted = getattr(hypothesis, "measurement_prediction", None)
    if measurement is None or predicted is None:
        return record
    prior = hypothesis.prediction
    difference = measurement.state_vector - predicted.state_vector
    model = getattr(measurement, "measurement_model", None)
    return record | {
        "status": "active",
        "measurement_type": type(model or measurement).__name__,
        "x_pred": _vector(prior),
        "P_pred": _matrix(prior),
        "z": np.ravel(measurement.state_vector).astype(np.float64),
        "innovation": np.ravel(difference).astype(np.float64),
        "S": _matrix(predicted),
    }


def _vector(state: Any) -> Any:
    return np.ravel(getattr(state, "mean", state.state_vector)).astype(np.float64)


def _matrix(state: Any) -> Any:
    return np.asarray(state.covar, np.float64)


def _columns(records: Sequence[Record]) -> Table:
    names = dict.fromkeys(name for record in records for name in record)
    columns = {name: [record.get(name) for record in records] for name in names}
    return {k: v for k, v in columns.items() if any(value is not None for value in v)}
