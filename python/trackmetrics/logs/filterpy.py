"""Columns from the savers of filterpy."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trackmetrics.logs._records import Record, Table, to_columns


def read(savers: Any, truths: Any, times: Any) -> Table:
    """The columns of one saver, or of several by the names of their tracks."""
    named = savers if isinstance(savers, Mapping) else {"track": savers}
    truth_of = truths if isinstance(truths, Mapping) else dict.fromkeys(named, truths)
    times_of = times if isinstance(times, Mapping) else dict.fromkeys(named, times)
    records: list[Record] = []
    for name, saver in named.items():
        records += _epochs(name, saver, truth_of.get(name), times_of.get(name))
    return to_columns(records)


def _epochs(name: str, saver: Any, truth: Any, times: Any) -> list[Record]:
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
        records.append(record | (_update_row(saver, k) if measured else {}))
    return records


def _update_row(saver: Any, k: int) -> Record:
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
