"""Reports of AIS as columns, from tables with the headings that providers use, and from JSON."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables import headings, times
from trackmetrics.vessel.settings import Floats

COLUMNS = ("time", "vessel", "lat", "lon", "sog", "cog")
"""What a report may have; time, vessel, lat and lon it must have."""

NAMES = {
    "time": (
        *("time", "timestamp", "basedatetime", "datetime", "datetimeutc", "timeutc"),
        *("timestamputc", "unixtime", "msgtime", "receivedtime", "timestampexternal"),
        *("tid", "tidspunkt", "aika", "aikaleima", "t"),
    ),
    "vessel": ("mmsi", "vessel", "id", "userid", "mmsinumber", "shipid"),
    "lat": ("latitudedegrees", "latitude", "lat", "breddegrad", "leveysaste", "y"),
    "lon": ("longitudedegrees", "longitude", "lon", "long", "lengdegrad", "pituusaste", "x"),
    "sog": ("sogknots", "sog", "speedoverground", "speed", "fart", "nopeus"),
    "cog": ("cogdegrees", "cog", "courseoverground", "course", "kurs", "suunta"),
    "type": ("typeofmobile", "msgtype", "messagetype", "messageid", "transponderclass"),
}
"""Headings that are known for each, in small letters and without blanks, ``_``, ``-`` and dots."""

JSON_NAMES = {
    **NAMES,
    # A key "timestamp" of AIS is the second of the minute, so that the receiver's time comes first.
    "time": ("rxuxtime", "rxtime", "timeutc", *NAMES["time"]),
    "type": ("type", *NAMES["type"]),
}
POSITION_MESSAGES = (1, 2, 3, 9, 18, 19, 27)
"""Numbers of the messages that report a position of a vessel."""
_SENDERS = {"4": "base station", "11": "base station", "21": "aid to navigation"}
_BASE_STATION = re.compile(r"00[2-7]\d{6}")
_AID = re.compile(r"99[2-7]\d{6}")


@dataclass(eq=False)
class Table:
    """Reports as columns, and what was given in their places."""

    time: Floats
    """Seconds; NaN where there is none."""
    vessel: NDArray[np.object_]
    """MMSI or name; empty where there is none."""
    vessel_code: NDArray[np.int64]
    """A number for each identity."""
    lat: Floats
    lon: Floats
    sog: Floats
    cog: Floats
    sender: NDArray[np.object_]
    """Empty for a vessel, else ``"base station"``, ``"aid to navigation"`` or ``"no report"``."""
    raw: Mapping[str, Any]
    """The columns as they were read."""

    def __len__(self) -> int:
        """How many rows."""
        return len(self.time)

    def given(self, name: str, row: int) -> Any:
        """What was read; None where nothing was."""
        column = self.raw.get(name)
        found = None if column is None else column[row]
        found = found.item() if isinstance(found, np.generic) else found
        return None if found != found else found

    def type_of(self, row: int) -> str:
        """What sent the row, as the recording says."""
        found = self.given("type", row)
        kind = f"type {found}" if isinstance(found, int | float) else found
        return str(kind or f"MMSI {self.vessel[row]}")[:40]

    def unreadable(self, name: str) -> NDArray[np.bool_]:
        """Rows that have something in this column that is no finite number."""
        numbers: Floats = getattr(self, name)
        column = self.raw.get(name)
        bad: NDArray[np.bool_] = ~np.isfinite(numbers)
        if column is None or column.dtype.kind == "f":
            return np.isinf(numbers)
        for row in np.flatnonzero(bad):
            bad[row] = not _is_missing(column[row])
        return bad


def make_table(raw: Mapping[str, Any], date_order: str | None = None) -> Table:
    """A table of columns under the names of :data:`COLUMNS` and ``type``."""
    n = len(raw["time"])
    vessel, code = _vessels(raw["vessel"])
    numbers = {
        name: _numbers(raw[name]) if name in raw else np.full(n, np.nan)
        for name in ("lat", "lon", "sog", "cog")
    }
    sender = _senders(raw.get("type"), vessel, code)
    return Table(_times(raw["time"], date_order), vessel, code, **numbers, sender=sender, raw=raw)


def from_rows(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A table of rows of text or numbers."""
    for k, row in enumerate(rows):
        if not isinstance(row, Mapping):
            raise TypeError(f"rows[{k}] must be a mapping, got {type(row).__name__}")
    raw = {}
    for name in (*COLUMNS, "type"):
        column = np.empty(len(rows), object)
        column[:] = [row.get(name) for row in rows]
        raw[name] = column
    return make_table(raw)


def select(
    columns: Mapping[str, Any],
    chosen: Mapping[str, str],
    file: str,
    known: Mapping[str, Sequence[str]] = NAMES,
) -> dict[str, Any]:
    """The columns that are needed, under our names."""
    unknown = [name for name in chosen if name not in COLUMNS]
    if unknown:
        raise ValueError(f"columns: no column {unknown[0]!r}; a report has {', '.join(COLUMNS)}")
    by_plain: dict[str, str] = {}
    for heading in columns:
        by_plain.setdefault(plain(heading), heading)
    found = {}
    for name, names in known.items():
        wanted = [chosen[name]] if name in chosen else list(names)
        here = [by_plain[plain(w)] for w in wanted if plain(w) in by_plain]
        if here:
            found[name] = columns[here[0]]
        elif name in chosen or name not in ("sog", "cog", "type"):
            raise ValueError(
                f"{file}: no column for {name!r}: expected {' or '.join(wanted[:4])}; "
                f"{headings.nearest(wanted[0], list(columns))}"
            )
    return {name: _as_array(column) for name, column in found.items()}


def plain(heading: str) -> str:
    """A heading in small letters, without blanks and marks."""
    return re.sub(r"[\s_.\-()\[\]]", "", heading.lower())


def _as_array(column: Any) -> Any:
    if isinstance(column, np.ndarray):
        return column
    array = np.empty(len(column), object)
    array[:] = column
    return array


def flatten_aisstream(columns: Mapping[str, Any]) -> dict[str, Any]:
    """The columns of aisstream's records, whose values lie one and two levels deep."""
    bodies = [
        (message or {}).get(kind) or {}
        for message, kind in zip(columns["Message"], columns["MessageType"], strict=True)
    ]
    metadata = [m or {} for m in columns.get("MetaData", columns.get("Metadata", []))]
    return {
        "time": [m.get("time_utc") for m in metadata],
        "mmsi": [str(m.get("MMSI") or "") for m in metadata],
        **{
            name: [body.get(key) for body in bodies]
            for name, key in (("lat", "Latitude"), ("lon", "Longitude"), ("sog", "Sog"))
        },
        "cog": [body.get("Cog") for body in bodies],
        "type": columns["MessageType"],
    }


def _vessels(column: Any) -> tuple[NDArray[np.object_], NDArray[np.int64]]:
    """Identities as text, and a number for each."""
    if column.dtype.kind == "f":
        kinds, inverse = np.unique(column, return_inverse=True)
        names = ["" if v != v else f"{v:.0f}" for v in kinds.tolist()]
    else:
        given: dict[Any, int] = {}
        inverse = np.array([given.setdefault(v, len(given)) for v in column.tolist()], np.int64)
        names = ["" if _is_missing(v) else str(v).strip() for v in given]
    codes: dict[str, int] = {}
    code = np.array([codes.setdefault(name, len(codes)) for name in names], np.int64)
    listed = np.array([*codes, ""], object)[:-1]
    code = code[inverse] if len(inverse) else np.empty(0, np.int64)
    return listed[code], code


def _senders(
    kinds: Any, vessel: NDArray[np.object_], code: NDArray[np.int64]
) -> NDArray[np.object_]:
    """What sent each row, by its type and by its MMSI."""
    first = np.unique(code, return_index=True)[1]
    by_vessel = np.array([_sender_of_mmsi(v) for v in vessel[first]], object)
    sender: NDArray[np.object_] = by_vessel[code] if len(code) else np.empty(0, object)
    if kinds is None:
        return sender
    seen: dict[Any, str] = {}
    for kind in kinds.tolist():
        if kind not in seen:
            seen[kind] = _sender_of_type(kind)
    by_type = np.array([seen[kind] for kind in kinds.tolist()], object)
    return np.where(by_type != "", by_type, sender)


def _sender_of_mmsi(mmsi: str) -> str:
    if _BASE_STATION.fullmatch(mmsi):
        return "base station"
    return "aid to navigation" if _AID.fullmatch(mmsi) else ""


def _sender_of_type(kind: Any) -> str:
    if _is_missing(kind):
        return ""
    number = _number(kind)
    if np.isfinite(number):
        if str(int(number)) in _SENDERS:
            return _SENDERS[str(int(number))]
        return "" if number in POSITION_MESSAGES else "no report"
    text = plain(str(kind))
    if "basestation" in text:
        return "base station"
    if "aton" in text or "aidstonavigation" in text or "aidtonavigation" in text:
        return "aid to navigation"
    no_position = ("staticdata", "shipstatic", "safety", "interrogation", "binary", "acknowledge")
    return "no report" if any(part in text for part in no_position) else ""


def _times(column: Any, date_order: str | None) -> Floats:
    """Seconds; NaN for what is no time. Numbers and dates may stand in one column."""
    if column.dtype.kind != "O":
        return times.to_seconds(column, "time", date_order=date_order).seconds
    try:
        return times.to_seconds(column, "time", date_order=date_order).seconds
    except ValueError:
        pass  # some are no times, or numbers and dates are mixed
    numbers = _numbers(column)
    seconds = np.full(len(column), np.nan)
    is_number = np.isfinite(numbers)
    if is_number.any():
        seconds[is_number] = times.to_seconds(numbers[is_number], "time").seconds
    is_text = ~is_number & np.array([not _is_missing(v) for v in column.tolist()], bool)
    if is_text.any():
        text = column[is_text].astype(str).astype(object)
        found = times.to_seconds(text, "time", date_order=date_order, strict=False)
        seconds[is_text] = found.seconds
    return seconds


def _numbers(column: Any) -> Floats:
    """Numbers; NaN for what is missing and for what is none."""
    if column.dtype.kind in "biuf":
        return np.array(column, np.float64)
    return np.array([_number(v) for v in column.tolist()], np.float64)


def _number(given: Any) -> float:
    try:
        return float(given)
    except (TypeError, ValueError):
        return np.nan


def _is_missing(given: Any) -> bool:
    return given is None or given != given or (isinstance(given, str) and not given.strip())
