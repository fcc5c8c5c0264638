"""Limits and ticks that both backends share."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from trackmetrics.report.scene import Floats

Limits = tuple[float, float]


def log_limits(
    values: Iterable[Floats | float], at_least: Limits = (0.4, 2.5), names: int = 0
) -> Limits:
    """Limits of a logarithmic axis with room around every positive value, and for rows of names."""
    finite = _finite(values)
    finite = np.append(finite[finite > 0], at_least)
    low, high = math.log10(finite.min()), math.log10(finite.max())
    room = 0.07 * (high - low)
    return 10 ** (low - room), 10 ** (high + room * (1.6 + 3.2 * names))


def linear_limits(values: Iterable[Floats | float], at_least: Limits | None = None) -> Limits:
    """Limits of a linear axis with room around every value."""
    finite = np.append(_finite(values), () if at_least is None else at_least)
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    room = 0.07 * (high - low) or 0.07 * abs(high) or 1.0
    return low - room, high + room


def on_log_axis(values: Floats, limits: Limits) -> Floats:
    """Values as a logarithmic axis can show them: zero stands at its lower end."""
    return np.where(values <= 0, limits[0], values)


def log_ticks(limits: Limits) -> list[tuple[float, str]]:
    """Powers of ten, every second or third where they are many; 1-2-5 where they are few."""
    low, high = math.log10(limits[0]), math.log10(limits[1])
    first, last = math.ceil(low), math.floor(high)
    if last - first < 1:
        values = [m * 10.0**e for e in range(first - 1, last + 2) for m in (1, 2, 5)]
        return [(v, _number(v)) for v in values if limits[0] <= v <= limits[1]]
    step = math.ceil((last - first + 1) / 5)
    return [(10.0**e, _number(10.0**e)) for e in range(first, last + 1) if e % step == 0]


def on_branch(values: Floats, near: Floats, period: float) -> Floats:
    """Angles, each moved by whole turns to within half a turn of another."""
    moved: Floats = values - period * np.round((values - near) / period)
    return moved


def unrolled(values: Floats, period: float) -> Floats:
    """Angles without jumps: each within half a turn of the one before."""
    known = np.isfinite(values)
    whole: Floats = values.copy()
    whole[known] = np.unwrap(values[known], period=period)
    return whole


def angle_ticks(limits: Limits, period: float, signed: bool) -> list[tuple[float, str]]:
    """Ticks of an unrolled angle, each named by the angle within one turn."""
    span = limits[1] - limits[0]
    parts = (1, 2, 4, 8, 12, 24, 36, 72, 180, 360, 720, 1800, 3600)
    step = next((period / n for n in reversed(parts) if span / (period / n) <= 5), period)
    step *= max(1, math.ceil(span / step / 6))
    ticks = np.arange(math.ceil(limits[0] / step), math.floor(limits[1] / step) + 1) * step
    low = -period / 2 if signed else 0.0
    return [(float(t), f"{(t - low) % period + low:.6g}") for t in ticks]


def whole(*columns: Floats) -> list[Floats]:
    """The rows in which every column has a value: a line joins what is known."""
    known = np.logical_and.reduce([np.isfinite(column) for column in columns])
    return [column[known] for column in columns]


def broken(
    x: Floats, y: Floats, *others: Floats, period: float | None
) -> tuple[NDArray[np.float64], ...]:
    """The columns with a gap wherever an angle ``y`` jumps by more than half its period."""
    columns = (x, y, *others)
    if period is None or len(y) < 2:
        return columns
    jumps = np.flatnonzero(np.abs(np.diff(y)) > period / 2) + 1
    return tuple(np.insert(column, jumps, np.nan) for column in columns)


def runs(*columns: Floats) -> list[slice]:
    """The stretches over which every column has a value."""
    whole = np.logical_and.reduce([np.isfinite(column) for column in columns])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], whole, [False]]).astype(int)))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _finite(values: Iterable[Floats | float]) -> NDArray[np.float64]:
    flat: Floats = np.concatenate([np.empty(0), *(np.ravel(v) for v in values)])
    return flat[np.isfinite(flat)]


def _number(value: float) -> str:
    return (
        f"{value:g}"
        if 1e-4 <= value < 1e5
        else f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
    )
