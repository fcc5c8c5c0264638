"""Angles on an axis: without jumps of a whole turn, and ticks within one turn."""

import math

import numpy as np
from numpy.typing import NDArray

from trackmetrics.report.axes import Limits
from trackmetrics.report.scene import Floats


def wrap_near(values: Floats, near: Floats, period: float) -> Floats:
    """Returns the angles shifted by whole periods to within half a period of ``near``."""
    moved: Floats = values - period * np.round((values - near) / period)
    return moved


def unwrap(values: Floats, period: float) -> Floats:
    """Returns the angles without jumps: each within half a period of the one before."""
    known = np.isfinite(values)
    continuous: Floats = values.copy()
    continuous[known] = np.unwrap(values[known], period=period)
    return continuous


def angle_ticks(limits: Limits, period: float, signed: bool) -> list[tuple[float, str]]:
    """Ticks of an unwrapped angle, labelled with the angle within one period."""
    span = limits[1] - limits[0]
    parts = (1, 2, 4, 8, 12, 24, 36, 72, 180, 360, 720, 1800, 3600)
    step = next((period / n for n in reversed(parts) if span / (period / n) <= 5), period)
    step *= max(1, math.ceil(span / step / 6))
    ticks = np.arange(math.ceil(limits[0] / step), math.floor(limits[1] / step) + 1) * step
    low = -period / 2 if signed else 0.0
    return [(float(t), f"{(t - low) % period + low:.6g}") for t in ticks]


def break_at_jumps(
    x: Floats, y: Floats, *others: Floats, period: float | None
) -> tuple[NDArray[np.float64], ...]:
    """The columns with a gap wherever an angle ``y`` jumps by more than half its period."""
    columns = (x, y, *others)
    if period is None or len(y) < 2:
        return columns
    jumps = np.flatnonzero(np.abs(np.diff(y)) > period / 2) + 1
    if not len(jumps):
        return columns
    return tuple(np.insert(column, jumps, np.nan) for column in columns)
