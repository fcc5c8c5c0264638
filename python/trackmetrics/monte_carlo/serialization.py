"""Arrays as bytes: a magic word, the version, a checksum, a header in JSON, then the arrays.

Nothing is unpickled, so that bytes from anywhere can be read; what is not whole is refused.
"""

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"trackmetrics\n"
VERSION = 2
_FIXED = struct.Struct("<HIQ")


def seal(kind: str, header: Mapping[str, Any], body: bytes) -> bytes:
    """``body`` with what it is, a header of JSON, and a checksum."""
    text = json.dumps({"kind": kind, **header}).encode()
    content = text + body
    return MAGIC + _FIXED.pack(VERSION, zlib.crc32(content), len(text)) + content


def opened(data: bytes, kind: str) -> tuple[dict[str, Any], bytes]:
    """The header and the body of what ``seal`` made."""
    start = len(MAGIC) + _FIXED.size
    if data[: len(MAGIC)] != MAGIC or len(data) < start:
        raise ValueError("these bytes are not an accumulator of trackmetrics")
    version, checksum, length = _FIXED.unpack_from(data, len(MAGIC))
    if version != VERSION:
        raise ValueError(f"these bytes have format {version}, this version reads {VERSION}")
    if zlib.crc32(data[start:]) != checksum:
        raise ValueError("these bytes are damaged or cut short")
    header = json.loads(data[start : start + length])
    if header.pop("kind") != kind:
        found = json.loads(data[start : start + length])["kind"]
        raise ValueError(f"these bytes hold a {found}, not a {kind}")
    return header, data[start + length :]


def pack(kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """``header`` and ``arrays`` of float64 or int64 as bytes."""
    columns, parts = [], []
    for name, array in arrays.items():
        data = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False).tobytes()
        if array.dtype.kind == "i":  # counts are mostly zeros
            data = zlib.compress(data, 1)
        columns.append([name, array.dtype.str[1:], array.shape, len(data)])
        parts.append(data)
    return seal(kind, {"header": header, "arrays": columns}, b"".join(parts))


def unpack(data: bytes, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of what ``pack`` made."""
    content, body = opened(data, kind)
    arrays, place = {}, 0
    for name, dtype, shape, size in content["arrays"]:
        part = body[place : place + size]
        raw = zlib.decompress(part) if dtype[0] == "i" else part
        arrays[name] = np.frombuffer(raw, dtype="<" + dtype).reshape(shape).astype(dtype)
        place += size
    return content["header"], arrays
