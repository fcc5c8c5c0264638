"""Reads logs from files of any form that :mod:`trackmetrics.logs.formats` lists."""

from dataclasses import replace
from pathlib import Path
from typing import Unpack

from trackmetrics._tables import opening
from trackmetrics._tables.polars_columns import polars
from trackmetrics.logs import formats
from trackmetrics.logs.header import HeaderArguments, LogHeader
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.logs.normalize import normalize
from trackmetrics.logs.selection import Renaming, check_selected, notes_on_unused, select_columns

MAX_SMALL_BYTES = 1_000_000
"""Text of more bytes than this is read slowly without Polars."""
SLOW = "read without Polars, row by row: pip install 'trackmetrics[files]' is many times faster"


def read_log(
    path: str | Path,
    *,
    columns: Renaming | None = None,
    progress: bool = False,
    **header: Unpack[HeaderArguments],
) -> EstimatorLog:
    """Read a log from a file: JSON Lines, delimited text, Parquet, or a PX4 flight log.

    The columns are those of :meth:`EstimatorLog.from_columns`; a vector or a matrix is a list
    (JSON Lines, Parquet) or one column an element, ``x[0]``, ``x[1]``, ... (delimited text). The
    first record of JSON Lines, or the first line of text behind ``#``, may be the header that
    :meth:`EstimatorLog.write` writes. Other columns are left alone. Files may be packed (gzip, xz,
    zip with one member) and text in UTF-8 or UTF-16; columns of text may be separated by commas,
    semicolons, tabs or blanks, with a decimal comma.

    Parameters
    ----------
    path
        The file, or ``"-"`` for standard input. Parquet needs Polars (the extra ``files``, which
        also makes the other forms many times faster), a flight log ``pyulog``, the extra ``px4``.
    columns
        Names of the file's columns where they differ: ``{"nis_dof": "df", "std": ["s0", "s1"]}``.
    progress
        Kept for callers of earlier releases: files are read whole, without a bar.
    **header
        ``states``, ``state_dim``, ``angles``, ``measurement_angles``, ``time_unit``, ``time``,
        ``date_order``, ``covariance_forms``, ``on_repeats``, ``nis_scale`` as in
        :meth:`EstimatorLog.from_columns`; they override the file's header. ``time="row"`` takes
        the numbers of the rows in each track as times, where a file has no column ``time``.

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
    content = opening.read(path)
    form = formats.to_read(path, content)
    table, found = form.read(content)
    wanted = LogHeader(**header).over(found)
    try:
        chosen = check_selected(select_columns(table, columns or {}), table, wanted.time)
        parts = normalize(chosen, wanted)
    except ValueError as error:
        raise type(error)(f"{content.name}: {error}") from None
    parts = replace(parts, notes=(*parts.notes, *notes_on_unused(table, chosen, columns or {})))
    if form.kind == "text" and polars() is None and content.size > MAX_SMALL_BYTES:
        parts = replace(parts, notes=(*parts.notes, SLOW))
    return EstimatorLog.from_parts(parts)
