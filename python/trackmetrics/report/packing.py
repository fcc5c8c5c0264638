"""Columns of numbers inside the page: few bytes each, every column once, decoded by the browser.

A column is stored in one of three forms. ``u``: whole numbers of 2 or 4 bytes that count steps from
the least value; differences of neighbours where those are smaller. ``f``: the upper 3 bytes of
32-bit floats, rounded to a relative precision of 1.2e-4, for logarithmic axes. ``b``: one bit per
row. The bytes of a column are stored plane by plane (all first bytes, then all second bytes, ...),
which compresses better.
"""

import json
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.report.scene import Floats

Json = dict[str, Any]
FEW = 8
"""Arrays of at most this many numbers are written as lists."""
LEVELS = {2: 10_000, 4: 2**32 - 2}
"""Steps from the least to the largest value, by bytes: four digits for values, more for times."""
_MANTISSA = np.uint32(0x800)
"""Unit of the last bit that is kept of a 32-bit float."""


class PackedArrays:
    """Collects columns, and gives references to them for the figures of :mod:`draw_plotly`."""

    def __init__(self) -> None:
        self._tracks: list[list[tuple[str, NDArray[Any]]]] = []
        self._ids: dict[tuple[str, bytes], int] = {}

    def begin_track(self) -> None:
        """Columns are numbered anew for each track, so that the references of tracks are alike."""
        self._tracks.append([])
        self._ids = {}

    def values(self, values: Floats, log: bool, rows: NDArray[np.bool_] | None = None) -> Any:
        """A reference to the values, restricted to ``rows``; a list where they are few."""
        return self._reference("f" if log else "u2", values, rows)

    def times(self, values: Floats, rows: NDArray[np.bool_] | None = None) -> Any:
        """As :meth:`values`, with the precision that times need."""
        return self._reference("u4", values, rows)

    def band(self, x: Floats, low: Floats, high: Floats, log: bool) -> Json:
        """A reference to a band between two lines, which the browser turns into its outline."""
        return {"band": [self.times(x), self.values(low, log), self.values(high, log)]}

    def std_band(self, x: Floats, centre: Floats, std: Floats, factor: float) -> Json:
        """A reference to a band around a line, which the browser turns into its outline."""
        parts = [self.times(x), self.values(centre, False), self.values(std, True)]
        return {"around": parts, "factor": factor}

    def payload(self, content: Any) -> bytes:
        """The content with its columns, as the browser reads it: length, JSON, bytes."""
        descriptions, data = _encoded([column for track in self._tracks for column in track])
        remaining = iter(descriptions)
        columns = [list(islice(remaining, len(track))) for track in self._tracks]
        whole = {"columns": columns, **content}
        header = json.dumps(whole, separators=(",", ":"), allow_nan=False).encode()
        return b"".join([len(header).to_bytes(4, "little"), header, data])

    def _reference(self, form: str, values: Floats, rows: NDArray[np.bool_] | None) -> Any:
        if len(values) <= FEW:
            return _rounded(values if rows is None else values[rows])
        reference: Json = {"column": self._id(form, values)}
        if rows is not None and not rows.all():
            reference["rows"] = self._id("b", rows)
        return reference

    def _id(self, form: str, values: NDArray[Any]) -> int:
        key = form, values.tobytes()
        found = self._ids.get(key)
        if found is None:
            found = self._ids[key] = len(self._tracks[-1])
            self._tracks[-1].append((form, values))
        return found


def _rounded(values: Floats) -> list[float | None]:
    return [float(f"{v:.7g}") if np.isfinite(v) else None for v in values.tolist()]


def _encoded(columns: list[tuple[str, NDArray[Any]]]) -> tuple[list[Json], bytes]:
    """Descriptions and bytes of all columns; those of one form and length are encoded at once."""
    groups: dict[tuple[str, int], list[int]] = {}
    for i, (form, values) in enumerate(columns):
        groups.setdefault((form, len(values)), []).append(i)
    found: list[tuple[Json, bytes]] = [({}, b"")] * len(columns)
    for (form, _), members in groups.items():
        coded = _FORMS[form](np.stack([columns[i][1] for i in members]))
        for i, pair in zip(members, coded, strict=True):
            found[i] = pair
    descriptions, size = [], 0
    for (_, values), (description, data) in zip(columns, found, strict=True):
        descriptions.append({"n": len(values), "at": size, **description})
        size += len(data)
    return descriptions, b"".join(data for _, data in found)


def _planes(values: NDArray[Any], count: int) -> list[bytes]:
    """For each row the bytes of its whole numbers, the most significant ones of all first."""
    width = values.dtype.itemsize
    bytes_of = values.view(np.uint8).reshape(*values.shape, width)[..., ::-1]
    planes = np.ascontiguousarray(np.swapaxes(bytes_of[..., :count], 1, 2))
    return [row.tobytes() for row in planes]


def _whole(values: Floats, dtype: Any) -> list[tuple[Json, bytes]]:
    """Steps from the least value of each row; the largest code is NaN."""
    levels, largest = LEVELS[np.dtype(dtype).itemsize], int(np.iinfo(dtype).max)
    known = np.isfinite(values)
    low = np.min(values, axis=1, where=known, initial=np.inf)
    span = np.max(values, axis=1, where=known, initial=-np.inf) - low
    low, span = np.where(np.isfinite(span), [low, span], 0.0)
    shifted = np.where(known, values - low[:, None], 0.0)
    counts = (span < largest) & ~np.any(shifted % 1, axis=1)
    step = np.where(counts | (span == 0), 1.0, span / levels)
    codes = np.where(known, np.rint(shifted / step[:, None]), largest).astype(dtype)
    changes = np.diff(codes, axis=1, prepend=np.zeros((len(codes), 1), dtype))  # modulo the range
    smaller = _spread(changes) < _spread(codes)
    stored = np.where(smaller[:, None], changes, codes)
    return [
        ({"form": "u", "bytes": codes.itemsize, **_scale(*scale)}, data)
        for *scale, data in zip(low, step, smaller, _planes(stored, codes.itemsize), strict=True)
    ]


def _scale(low: float, step: float, changes: bool) -> Json:
    scale: Json = {"low": float(f"{low:.9g}"), "step": float(f"{step:.9g}")}
    return {**scale, "changes": 1} if changes else scale


def _spread(codes: NDArray[Any]) -> NDArray[np.float64]:
    """Mean distance of the codes of each row from a middle one, in the modular sense."""
    middle = np.partition(codes, codes.shape[1] // 2, axis=1)[:, codes.shape[1] // 2]
    signed = (codes - middle[:, None]).view(np.dtype(f"i{codes.dtype.itemsize}"))
    return np.asarray(np.abs(signed.astype(np.float64)).mean(axis=1))


def _float(values: Floats) -> list[tuple[Json, bytes]]:
    """The upper 3 bytes of 32-bit floats, rounded."""
    bits = values.astype(np.float32).view(np.uint32)
    rounded = np.where(np.isfinite(values), bits + _MANTISSA // 2, bits) & ~(_MANTISSA - 1)
    return [({"form": "f"}, data) for data in _planes(rounded.astype(np.uint32), 3)]


def _bits(rows: NDArray[Any]) -> list[tuple[Json, bytes]]:
    return [({"form": "b"}, row.tobytes()) for row in np.packbits(rows, axis=1)]


_FORMS: dict[str, Any] = {
    "u2": lambda values: _whole(values, np.uint16),
    "u4": lambda values: _whole(values, np.uint32),
    "f": _float,
    "b": _bits,
}
