"""Recordings of AIS: tables with the headings of many providers, JSON Lines, and NMEA.

Rows that cannot be used are rejected and listed; see :mod:`trackmetrics.vessel.screening`.
"""

import csv
import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trackmetrics._tables import delimited, json_lines, opening
from trackmetrics.vessel import ais_columns
from trackmetrics.vessel.screening import MAX_SPEED, Recording, screen_table

_SENTENCE = re.compile(
    rb"^\s*(?:\\[^\\\n]*\\)*\s*(?:\d+(?:\.\d+)?[,;\s]+)?[!$](?:AI|BS|AB|AN|SA)VD[MO],", re.MULTILINE
)
_SHORT_ROW = re.compile(r"\d+ cells, the header has")


def read_ais(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    max_speed: float = MAX_SPEED,
    *,
    date_order: str | None = None,
    progress: bool = False,
) -> Recording:
    """Read a recording of AIS reports.

    Parameters
    ----------
    path : path
        A table with a heading (comma, semicolon, tab; decimal point or comma), JSON Lines as
        AIS-catcher and aisstream write them, or NMEA sentences (needs the extra ``ais``), each with
        its time in a tag block (``\\c:UNIX*hh\\!AIVDM``), before the sentence (``UNIX,!AIVDM``) or
        behind it. The file may be packed (gzip, xz, zip); ``-`` is standard input.
    columns : mapping, optional
        The heading of each of ``time, vessel, lat, lon, sog, cog`` where it is none of the usual
        ones.
    max_speed : float
        Knots that no vessel makes.
    date_order : {"dmy", "mdy"}, optional
        Whether dates such as 07/09/2024 begin with the day. By default the whole column decides.
    progress : bool
        Whether a bar on standard error shows how far it is, where it takes longer than half a
        second (needs the extra ``progress``).

    Returns
    -------
    Recording
        The usable reports, and each row that was rejected with its reason.

    Raises
    ------
    ValueError
        If a column is missing, the order of day and month cannot be told, or no row is usable.

    Notes
    -----
    Times are seconds, Unix milliseconds (recognised by their size), ``YYYYMMDDHHMMSS``, or dates as
    ISO 8601 and others have them, in UTC where no zone is given.
    """
    found = opening.read(path)
    if found.kind != "text":
        raise ValueError(f"{found.name} is a {found.kind} file: expected text with AIS reports")
    return screen_table(_table(found, columns or {}, date_order), max_speed, progress=progress)


def _table(
    found: opening.Content, columns: Mapping[str, str], date_order: str | None
) -> ais_columns.Table:
    head = found.head().lstrip()
    if head.startswith((b"{", b"[")):
        raw = _from_json(found, columns)
    elif _SENTENCE.search(head) and not columns:
        from trackmetrics.vessel.nmea import read_sentences

        return ais_columns.from_rows(read_sentences(found.data.decode()))
    else:
        read = _read_delimited(found)
        raw = ais_columns.select(read, columns, found.name)
        # The Danish Maritime Authority writes the day first.
        if {"timestamp", "typeofmobile"} <= {ais_columns.plain(name) for name in read}:
            date_order = date_order or "dmy"
    return ais_columns.make_table(raw, date_order)


def _read_delimited(found: opening.Content) -> dict[str, Any]:
    text = {*ais_columns.NAMES["vessel"], "MMSI"}
    try:
        return delimited.read(found.source, found.name, text)
    except ValueError as error:
        if not _SHORT_ROW.search(str(error)):
            raise
    return delimited.read(_with_full_rows(found.data), found.name, text)


def _with_full_rows(data: bytes) -> bytes:
    """The table with rows that were cut off filled up: what they lack is missing."""
    sample = data.lstrip().partition(b"\n")[0].decode()
    delimiter = next((d for d in (";", "\t") if d in sample), ",")
    rows = [row for row in csv.reader(io.StringIO(data.decode()), delimiter=delimiter) if row]
    width = len(rows[0])
    out = io.StringIO()
    csv.writer(out, delimiter=delimiter, lineterminator="\n").writerows(
        [*row, *[""] * (width - len(row))][:width] for row in rows
    )
    return out.getvalue().encode()


def _from_json(found: opening.Content, columns: Mapping[str, str]) -> dict[str, Any]:
    data = found.data
    if data.lstrip().startswith(b"["):
        import json

        data = "\n".join(json.dumps(record) for record in json.loads(data)).encode()
    read = json_lines.read(data, found.name)
    if "Message" in read and "MessageType" in read:
        read = ais_columns.flatten_aisstream(read)
    return ais_columns.select(read, columns, found.name, ais_columns.JSON_NAMES)
