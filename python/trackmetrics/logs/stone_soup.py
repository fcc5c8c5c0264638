"""Columns from the tracks of Stone Soup."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from trackmetrics.logs._records import Record, Table, to_columns


def read(tracks: Iterable[Any], truths: Any) -> Table:
    """The columns of Stone Soup's tracks: one row for each state that is an update."""
    truth_of = truths if isinstance(truths, Mapping) else {}
    records: list[Record] = []
    for track in tracks:
        truth = truth_of.get(track, truth_of.get(track.id))
        at = {} if truth is None else {s.timestamp: np.ravel(s.state_vector) for s in truth}
        records += [_state_row(track, s, at) for s in track.states if hasattr(s, "hypothesis")]
    if not records:
        raise ValueError("tracks hold no update: expected states with a hypothesis")
    start = min(record["time"] for record in records)
    for record in records:
        record["time"] = (record["time"] - start).total_seconds()
    return to_columns(records)


def _state_row(track: Any, state: Any, truth: Mapping[Any, Any]) -> Record:
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
