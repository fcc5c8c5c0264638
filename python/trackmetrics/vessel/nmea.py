"""NMEA sentences of AIS as rows, through ``pyais`` (the extra ``ais``).

Position reports of class A (messages 1, 2, 3) and B (18, 19) become rows; other messages are no
reports and pass. A sentence that cannot be decoded becomes a row without a position, so that it is
counted with the unreadable ones. The time is that of the tag block (``\\c:UNIX``) or of the
number before the sentence; a message in several sentences has the time of its first.
"""

import re
from pathlib import Path
from typing import Any

_LINE = re.compile(r"^\s*(?:\\(?P<tag>[^\\]*)\\|(?P<time>\d+(?:\.\d+)?)[,;\s]+)?(?P<rest>!.*)$")
_TAG_TIME = re.compile(r"(?:^|,)c:(\d+(?:\.\d+)?)")
_POSITIONS = (1, 2, 3, 18, 19)


def read_sentences(path: Path) -> list[dict[str, Any]]:
    """A row for every position report and for every sentence that is broken."""
    try:
        import pyais
        from pyais.exceptions import AISBaseException
    except ImportError as error:
        raise ImportError("NMEA needs pyais: pip install 'trackmetrics[ais]'") from error
    rows: list[dict[str, Any]] = []
    waiting: dict[tuple[str, str], tuple[str, list[str]]] = {}
    for line in path.read_text(encoding="ascii", errors="replace").splitlines():
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
        "sog": message["speed"],
        "cog": message["course"],
    }


def _cut(line: str) -> tuple[str, str]:
    """Time and sentence of a line; without a time the row will be unreadable."""
    found = _LINE.match(line)
    if not found:
        return "", line.strip()
    tagged = _TAG_TIME.search(found["tag"] or "")
    return (tagged[1] if tagged else found["time"] or ""), found["rest"].strip()


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
