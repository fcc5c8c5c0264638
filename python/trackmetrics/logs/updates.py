"""Rows that are no updates, and test ratios in the place of NIS.

A NIS of exactly 0, where no innovation is logged beside it, is what many programs write between two
fusions. Beside an innovation it may be real: a vessel at rest reports the same rounded position. A
test ratio is a NIS divided by its gate, as PX4 and others log it.
"""

from math import isfinite

import numpy as np

from trackmetrics._tables.errors import value
from trackmetrics.logs.columns import Columns, Strings
from trackmetrics.logs.header import LogHeader

MAX_RATIO_QUANTILE = 0.2
"""Test ratios look like NIS far too small: their median is below this share of the expected one."""


def scale_and_drop(
    columns: Columns, names: Strings, header: LogHeader
) -> tuple[Columns, Strings, tuple[str, ...]]:
    """NIS from test ratios by ``nis_scale``; rows that are no updates by ``on_repeats``."""
    columns = _scaled(columns, header.nis_scale)
    rows, note = _zeros(columns, header.on_repeats)
    if rows is not None:
        columns, names = columns.take(~rows), names[~rows]
    return columns, names, tuple(n for n in (note, _hint(columns, header.nis_scale)) if n)


def _scaled(columns: Columns, scale: float) -> Columns:
    is_number = isinstance(scale, (int, float, np.number)) and not isinstance(scale, bool)
    if not is_number or not isfinite(scale) or scale <= 0:
        raise ValueError(f"nis_scale must be positive and finite, got {value(scale)}")
    if scale == 1 or columns.nis is None:
        return columns
    return columns.replace(nis=columns.nis * scale)


def _zeros(columns: Columns, on_repeats: str) -> tuple[np.ndarray | None, str]:
    """Rows whose logged NIS is exactly 0, and what to say of them."""
    if columns.nis is None or on_repeats == "keep":
        return None, ""
    if columns.innovation is not None or columns.z is not None:
        return None, ""
    zero = columns.nis == 0
    count = int(zero.sum())
    if not count:
        return None, ""
    if count == len(zero):
        raise ValueError(
            f"all {count} NIS are exactly 0: they are no updates; on_repeats='keep' keeps them"
        )
    if on_repeats == "raise":
        raise ValueError(f"nis[{int(np.argmax(zero))}] is exactly 0: no update")
    return zero, (
        f"{count} of {len(zero)} rows have a NIS of exactly 0: they are no updates and were left "
        "out; on_repeats='keep' keeps them"
    )


def _hint(columns: Columns, scale: float) -> str:
    """What to say where NIS look like test ratios: all below 1, and far below their dof."""
    if columns.nis is None or columns.nis_dof is None or scale != 1:
        return ""
    there = ~np.isnan(columns.nis)
    if there.sum() < 50:
        return ""
    share = np.median(columns.nis[there] / columns.nis_dof[there])
    if columns.nis[there].max() < 1 and share < MAX_RATIO_QUANTILE:
        return (
            "every NIS is below 1 and their median far below the degrees of freedom: if these are "
            "test ratios (NIS divided by a gate), give nis_scale=, the gate"
        )
    return ""
