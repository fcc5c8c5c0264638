"""Columns of numbers inside the page: few bytes each, every column once, decoded by the browser.

A column is stored in one of these forms. ``u2``, ``u4``: whole numbers of 2 or 4 bytes that count
steps from the least value. ``l2``: the same for the logarithm, for logarithmic axes. ``u2d``,
``u4d``, ``l2d``: the differences of neighbours, where those are smaller. ``b``: one bit per row.
The first bytes of all columns of a form stand together, then the second bytes, and so on: bytes of
one kind compress best beside each other.
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
LEVELS = {"u2": 4096, "l2": 8192, "u4": 2**22}
"""Steps from the least to the largest value: a thirtieth of a pixel of a panel, four digits of a
value on a logarithmic axis, milliseconds of a day."""


FORMS = ("b", "u2", "u2d", "l2", "l2d", "u4", "u4d")
"""The forms in the order of their bytes."""


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
        return self._reference("l2" if log else "u2", values, rows)

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
    found: list[tuple[Json, list[bytes]]] = [({}, [])] * len(columns)
    for (form, _), members in groups.items():
        coded = _ENCODE[form](form, np.stack([columns[i][1] for i in members]))
        for i, pair in zip(members, coded, strict=True):
            found[i] = pair
    return [description for description, _ in found], _sorted_planes(found)


def _sorted_planes(found: list[tuple[Json, list[bytes]]]) -> bytes:
    """The planes of all columns: by form, by plane, and in the order of the columns."""
    parts = []
    for form in FORMS:
        columns = [planes for description, planes in found if description["form"] == form]
        parts += [plane for same_plane in zip(*columns, strict=True) for plane in same_plane]
    return b"".join(parts)


def _planes(values: NDArray[Any]) -> list[list[bytes]]:
    """For each row its planes: the most significant bytes of its numbers, then the next ones."""
    width = values.dtype.itemsize
    bytes_of = values.view(np.uint8).reshape(*values.shape, width)[..., ::-1]
    return [[plane.tobytes() for plane in row] for row in np.swapaxes(bytes_of, 1, 2)]


def _whole(form: str, values: Floats) -> list[tuple[Json, list[bytes]]]:
    """Steps from the least value of each row; the largest code is NaN."""
    dtype = np.uint32 if form == "u4" else np.uint16
    largest, levels = int(np.iinfo(dtype).max), LEVELS[form]
    known = np.isfinite(values)
    low = np.min(values, axis=1, where=known, initial=np.inf)
    span = np.max(values, axis=1, where=known, initial=-np.inf) - low
    low, span = np.where(np.isfinite(span), [low, span], 0.0)
    shifted = np.where(known, values - low[:, None], 0.0)
    counts = (span < levels) & ~np.any(shifted % 1, axis=1)
    step = np.where(counts | (span == 0), 1.0, span / levels)
    codes = np.where(known, np.rint(shifted / step[:, None]), largest).astype(dtype)
    changes = np.diff(codes, axis=1, prepend=np.zeros((len(codes), 1), dtype))  # modulo the range
    smaller = _spread(changes) < _spread(codes)
    stored = np.where(smaller[:, None], changes, codes)
    n = values.shape[1]
    return [
        (_description(form, n, *scale), data)
        for *scale, data in zip(low, step, smaller, _planes(stored), strict=True)
    ]


def _description(form: str, n: int, low: float, step: float, changes: bool) -> Json:
    """What the browser needs to decode a column."""
    digits = 11 if form == "u4" else 6
    form = f"{form}d" if changes else form
    return {"form": form, "n": n, "low": float(f"{low:.9g}"), "step": float(f"{step:.{digits}g}")}


def _spread(codes: NDArray[Any]) -> NDArray[np.float64]:
    """Mean distance of the codes of each row from a middle one, in the modular sense."""
    middle = np.partition(codes, codes.shape[1] // 2, axis=1)[:, codes.shape[1] // 2]
    signed = (codes - middle[:, None]).view(np.dtype(f"i{codes.dtype.itemsize}"))
    return np.asarray(np.abs(signed.astype(np.float64)).mean(axis=1))


def _logarithms(form: str, values: Floats) -> list[tuple[Json, list[bytes]]]:
    """As :func:`_whole` for the natural logarithm; the least code is zero where there are zeros."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithms = np.log(values)
    if not np.any(values == 0):
        return _whole(form, logarithms)
    lowest = np.min(logarithms, where=np.isfinite(logarithms), initial=0.0)
    return [
        ({**description, "zero": 1}, data)
        for description, data in _whole(form, np.where(values == 0, lowest - 1.0, logarithms))
    ]


def _bits(form: str, rows: NDArray[Any]) -> list[tuple[Json, list[bytes]]]:
    description = {"form": form, "n": rows.shape[1]}
    return [(description, [row.tobytes()]) for row in np.packbits(rows, axis=1)]


_ENCODE: dict[str, Any] = {"u2": _whole, "u4": _whole, "l2": _logarithms, "b": _bits}
