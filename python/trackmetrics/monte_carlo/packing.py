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
VERSION = 1
_FIXED = struct.Struct("<HIQ")


def pack(kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """``header`` and ``arrays`` of float64 or int64 as bytes."""
    columns, parts = [], []
    for name, array in arrays.items():
        data = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False).tobytes()
        if array.dtype.kind == "i":  # counts are mostly zeros
            data = zlib.compress(data, 1)
        columns.append([name, array.dtype.str[1:], array.shape, len(data)])
        parts.append(data)
    text = json.dumps({"kind": kind, "header": header, "arrays": columns}).encode()
    body = text + b"".join(parts)
    return MAGIC + _FIXED.pack(VERSION, zlib.crc32(body), len(text)) + body


def unpack(data: bytes, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of what ``pack`` made."""
    start = len(MAGIC) + _FIXED.size
    if data[: len(MAGIC)] != MAGIC or len(data) < start:
        raise ValueError("these bytes are not an accumulator of trackmetrics")
    version, checksum, length = _FIXED.unpack_from(data, len(MAGIC))
    if version != VERSION:
        raise ValueError(f"these bytes have format {version}, this version reads {VERSION}")
    if zlib.crc32(data[start:]) != checksum:
        raise ValueError("these bytes are damaged or cut short")
    content = json.loads(data[start : start + length])
    if content["kind"] != kind:
        raise ValueError(f"these bytes hold a {content['kind']}, not a {kind}")
    arrays, place = {}, start + length
    for name, dtype, shape, size in content["arrays"]:
        part = data[place : place + size]
        raw = zlib.decompress(part) if dtype[0] == "i" else part
        array = np.frombuffer(raw, dtype="<" + dtype).reshape(shape)
        arrays[name] = array.astype(dtype)
        place += size
    return content["header"], arrays
