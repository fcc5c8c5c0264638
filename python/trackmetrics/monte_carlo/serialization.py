"""Arrays as bytes: a magic number, the version, a checksum, a header in JSON, then the arrays.

Nothing is unpickled, so that bytes from anywhere can be read; what is not whole is refused.
"""

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"trackmetrics\n"
VERSION = 2
_FIXED = struct.Struct("<HIQ")
_MAX_RATIO = 128
"""How many times their size in a file the counts of an accumulator can take in memory: a histogram
has 386 bins a step, mostly zeros, beside at least 7 sums that are not compressed."""
_MIN_INFLATED = 4096
_MALFORMED = (
    *(ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError),
    *(RecursionError, StopIteration, struct.error, zlib.error),
)


def encode(kind: str, header: Mapping[str, Any], body: bytes) -> bytes:
    """``body`` with what it is, a header of JSON, and a checksum."""
    text = json.dumps({"kind": kind, **header}).encode()
    content = text + body
    return MAGIC + _FIXED.pack(VERSION, zlib.crc32(content), len(text)) + content


def decode(data: bytes, kind: str) -> tuple[dict[str, Any], bytes]:
    """The header and the body of what ``seal`` made."""
    start = len(MAGIC) + _FIXED.size
    if data[: len(MAGIC)] != MAGIC or len(data) < start:
        raise ValueError("these bytes are not an accumulator of trackmetrics")
    version, checksum, length = _FIXED.unpack_from(data, len(MAGIC))
    if version != VERSION:
        raise ValueError(f"these bytes have format {version}, this version reads {VERSION}")
    if length > len(data) - start or zlib.crc32(data[start:]) != checksum:
        raise ValueError("these bytes are damaged or cut short")
    with refusing_malformed():
        header = json.loads(data[start : start + length])
        found = header.pop("kind")
    if found != kind:
        raise ValueError(f"these bytes hold a {str(found)[:40]}, not a {kind}")
    return header, data[start + length :]


@contextmanager
def refusing_malformed() -> Iterator[None]:
    """One error for whatever malformed content leads to."""
    try:
        yield
    except _MALFORMED as error:
        text = str(error)
        if text.startswith("these bytes"):
            raise
        raise ValueError(f"these bytes are damaged: {text[:120] or type(error).__name__}") from None


def whole(value: Any) -> int:
    """A whole number as JSON has it."""
    if type(value) is not int:
        raise ValueError(f"{value!r} is not a whole number")
    return value


def pack(kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """``header`` and ``arrays`` of float64 or int64 as bytes."""
    columns, parts = [], []
    for name, array in arrays.items():
        data = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False).tobytes()
        if array.dtype.kind == "i":  # counts are mostly zeros
            data = zlib.compress(data, 1)
        columns.append([name, array.dtype.str[1:], array.shape, len(data)])
        parts.append(data)
    return encode(kind, {"header": header, "arrays": columns}, b"".join(parts))


def unpack(data: bytes, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of what ``pack`` made."""
    content, body = decode(data, kind)
    arrays: dict[str, NDArray[Any]] = {}
    place, left = 0, _MIN_INFLATED + _MAX_RATIO * len(data)
    with refusing_malformed():
        for name, dtype, shape, size in content["arrays"]:
            if dtype not in ("i8", "f8") or not 0 <= whole(size) <= len(body) - place:
                raise ValueError(f"array {name} of {size} bytes of type {dtype}")
            if len(shape) > 3 or any(whole(n) < 0 for n in shape):
                raise ValueError(f"array {name} of shape {shape}")
            part, wanted = body[place : place + size], 8 * prod(shape)
            place += size
            left -= wanted if dtype == "i8" else 0
            if left < 0:
                raise ValueError(f"array {name} would take {wanted} bytes")
            raw = _inflated(part, wanted) if dtype == "i8" else part
            if len(raw) != wanted:
                raise ValueError(f"array {name} has {len(raw)} bytes, its shape {wanted}")
            arrays[name] = np.frombuffer(raw, dtype="<" + dtype).reshape(shape).astype(dtype)
        return content["header"], arrays


def _inflated(part: bytes, size: int) -> bytes:
    """Decompresses at most ``size`` bytes; one more shows that there were too many."""
    decompressor = zlib.decompressobj()
    raw = decompressor.decompress(part, size + 1)
    if not decompressor.eof and len(raw) <= size:
        raise ValueError("compressed numbers are cut short")
    return raw
