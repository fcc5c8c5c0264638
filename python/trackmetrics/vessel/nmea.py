"""NMEA sentences of AIS as rows, through ``pyais`` (the extra ``ais``).

Position reports of class A (messages 1, 2, 3), class B (18, 19), aircraft (9) and long range (27)
become rows, and those of base stations and aids to navigation, which are rejected; other messages
are no reports and pass. A sentence that cannot be decoded becomes a row without a position, so that
it is counted with the unreadable ones. The time is that of the tag block (``\\c:UNIX``) or of the
number before or behind the sentence; a message in several sentences has the time of its first.
"""

import re
from typing import Any

_LINE = re.compile(
    r"^\s*(?P<tags>(?:\\[^\\]*\\)*)\s*(?:(?P<before>\d+(?:\.\d+)?)[,;\s]+)?"
    r"(?P<sentence>[!$][^*]*\*[0-9A-Fa-f]{2})(?:[,;\s]+(?P<behind>\d+(?:\.\d+)?))?"
)
_TAG_TIME = re.compile(r"(?:^|[,\\])c:(\d+(?:\.\d+)?)")
_POSITIONS = (1, 2, 3, 4, 9, 11, 18, 19, 21, 27)
"""Messages with a position; base stations (4, 11) and aids to navigation (21) are rejected."""
_NO_SPEED_27 = 63
"""What message 27 sends for "speed not available"."""


def read_sentences(text: str) -> list[dict[str, Any]]:
    """A row for every position report and for every sentence that is broken."""
    try:
        import pyais
        from pyais.exceptions import AISBaseException
    except ImportError as error:
        raise ImportError("NMEA needs pyais: pip install 'trackmetrics[ais]'") from error
    rows: list[dict[str, Any]] = []
    waiting: dict[tuple[str, str], tuple[str, list[str]]] = {}
    for line in text.splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        time, sentence = _cut(line)
        parts = _complete(sentence, time, waiting)
        if parts is None:
            continue
        time, sentences = parts
        try:
            message = pyais.decode(*sentences, error_if_checksum_invalid=True).asdict()
        except (AISBaseException, ValueError, IndexError, KeyError) as error:
            rows.append({"time": time, "vessel": "", "lat": f"{type(error).__name__}", "lon": ""})
            continue
        if message["msg_type"] in _POSITIONS:
            rows.append(_row(time, message))
    return rows


def _row(time: str, message: dict[str, Any]) -> dict[str, Any]:
    return {
        "time": time,
        "vessel": str(message["mmsi"]),
        "lat": message["lat"],
        "lon": message["lon"],
        "sog": _speed(message),
        "cog": message.get("course"),
        "type": int(message["msg_type"]),
    }


def _cut(line: str) -> tuple[str, str]:
    """Time and sentence of a line; without a time the row will be unreadable."""
    found = _LINE.match(line)
    if not found:
        return "", line.strip()
    tagged = _TAG_TIME.search(found["tags"])
    time = tagged[1] if tagged else found["before"] or found["behind"] or ""
    return time, found["sentence"]


def _speed(message: dict[str, Any]) -> Any:
    speed = message.get("speed")
    not_available = message["msg_type"] == 27 and speed == _NO_SPEED_27
    return None if not_available else speed


def _complete(
    sentence: str, time: str, waiting: dict[tuple[str, str], tuple[str, list[str]]]
) -> tuple[str, list[str]] | None:
    """The sentences of a message once all are there."""
    fields = sentence.split(",")
    if len(fields) < 4 or not fields[1].isdigit() or int(fields[1]) < 2:
        return time, [sentence]
    key = (fields[3], fields[4] if len(fields) > 4 else "")
    first, parts = waiting.setdefault(key, (time, []))
    parts.append(sentence)
    if len(parts) < int(fields[1]):
        return None
    del waiting[key]
    return first, parts
