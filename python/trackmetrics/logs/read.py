"""Reads logs from files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from trackmetrics.logs.header import Header, State
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.logs.normalize import build
from trackmetrics.logs.tables import Renaming, chosen, from_file


def read_log(
    path: str | Path,
    *,
    columns: Renaming | None = None,
    states: Sequence[State | str] | None = None,
    state_dim: int | None = None,
    angles: Mapping[str | int, float] | None = None,
    measurement_angles: Mapping[str, Mapping[int, float]] | None = None,
    time_unit: str | None = None,
    progress: bool = False,
) -> EstimatorLog:
    """Read a log from a ``.jsonl``, ``.csv`` or ``.parquet`` file, or a PX4 flight log (``.ulg``).

    The columns are those of :meth:`EstimatorLog.from_columns`; a vector or a matrix is a list
    (JSON Lines, Parquet) or one column an element, ``x[0]``, ``x[1]``, ... (CSV). The first record
    of JSON Lines, or the first line of a CSV behind ``#``, may be the header that
    :meth:`EstimatorLog.write` writes. Other columns are left alone.

    Parameters
    ----------
    path
        The file; its ending says in which form it is. Parquet needs ``pyarrow``, a flight log
        (ULog: the innovations of each axis as a track) ``pyulog``, the extra ``px4``.
    columns
        Names of the file's columns where they differ: ``{"nis_dof": "df", "std": ["s0", "s1"]}``.
    states, state_dim, angles, measurement_angles, time_unit
        As in :meth:`EstimatorLog.from_columns`; they override the file's header.
    progress
        Whether a bar on standard error shows how much of a ``.jsonl`` or ``.csv`` file is read,
        where it takes longer than a second (needs the extra ``progress``).

    Returns
    -------
    EstimatorLog
        The log.

    Raises
    ------
    ValueError
        If the file is no such log; names the file, and the line or row.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "run.csv")
    >>> _ = path.write_text("time,value,df\\n0,1.5,2\\n1,3.1,2\\n")
    >>> read_log(path, columns={"nis": "value", "nis_dof": "df"})
    EstimatorLog(1 track, 2 updates, columns: nis, nis_dof)
    """
    path = Path(path)
    table, found = from_file(path, progress)
    header = _header(found, states, state_dim, angles, measurement_angles, time_unit)
    try:
        return EstimatorLog(*build(chosen(table, columns or {}), header))
    except ValueError as error:
        raise type(error)(f"{path.name}: {error}") from None


def _header(
    found: Mapping[str, Any],
    states: Sequence[State | str] | None,
    state_dim: int | None,
    angles: Mapping[str | int, float] | None,
    measurement_angles: Mapping[str, Mapping[int, float]] | None,
    time_unit: str | None,
) -> Header:
    """The file's header, overridden by what the caller says."""
    listed = [State(s["name"], s.get("unit", ""), s.get("period")) for s in found.get("states", ())]
    components = {
        kind: {int(i): float(period) for i, period in of_kind.items()}
        for kind, of_kind in found.get("measurement_angles", {}).items()
    }
    return Header(
        states if states is not None else listed or None,
        state_dim,
        angles or {},
        measurement_angles if measurement_angles is not None else components,
        time_unit or found.get("time_unit", "s"),
    )
