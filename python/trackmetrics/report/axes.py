"""Limits and ticks that both backends share."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.report.scene import Bounds, Floats, Panel, Primitive, floats

Limits = tuple[float, float]


def log_limits(
    values: Iterable[Floats | float], at_least: Limits = (0.4, 2.5), names: int = 0
) -> Limits:
    """Limits of a logarithmic axis with a margin around the positive values and ``names`` rows."""
    finite = _finite(values)
    finite = np.append(finite[finite > 0], at_least)
    low, high = math.log10(finite.min()), math.log10(finite.max())
    margin = 0.07 * (high - low)
    return 10 ** (low - margin), 10 ** (high + margin * (1.6 + 3.2 * names))


def linear_limits(values: Iterable[Floats | float], at_least: Limits | None = None) -> Limits:
    """Limits of a linear axis with a margin around all values."""
    finite = np.append(_finite(values), () if at_least is None else at_least)
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    margin = 0.07 * (high - low) or 0.07 * abs(high) or 1.0
    return low - margin, high + margin


def on_log_axis(values: Floats, limits: Limits) -> Floats:
    """Values for a logarithmic axis: zero is drawn at its lower end."""
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


def drop_nan(*columns: Floats) -> list[Floats]:
    """The rows in which every column has a value, so that a line joins them."""
    known = np.logical_and.reduce([np.isfinite(column) for column in columns])
    return list(columns) if known.all() else [column[known] for column in columns]


def finite_runs(*columns: Floats) -> list[slice]:
    """The slices of consecutive rows in which every column has a value."""
    known = np.logical_and.reduce([np.isfinite(column) for column in columns])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(int)))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


class TimeAxis:
    """A time axis: minutes since the first time, or indices of frames or steps without times."""

    def __init__(self, times: Any, count: int, unit_name: str) -> None:
        given = np.arange(count) if times is None else floats(times)
        if len(given) != count:
            raise ValueError(f"times has {len(given)} {unit_name}s, the results have {count}")
        self.x: Floats = floats(given if times is None else (given - given[0]) / 60.0)
        self.label = unit_name if times is None else "minutes since start"
        self.unit = "" if times is None else "min"

    @property
    def limits(self) -> Limits:
        """The limits of the axis, with a margin of 2 %."""
        ends = (float(self.x.min()), float(self.x.max())) if self.x.size else (0.0, 1.0)
        margin = 0.02 * (ends[1] - ends[0]) or 0.5
        return ends[0] - margin, ends[1] + margin

    def panel(
        self, bounds: Bounds, primitives: Sequence[Primitive], limits: Limits, **content: Any
    ) -> Panel:
        """A panel with this x axis."""
        return Panel(
            bounds,
            tuple(primitives),
            x_limits=self.limits,
            y_limits=limits,
            x_unit=self.unit,
            **content,
        )


def _finite(values: Iterable[Floats | float]) -> NDArray[np.float64]:
    flat: Floats = np.concatenate([np.empty(0), *(np.ravel(v) for v in values)])
    return flat[np.isfinite(flat)]


def _number(value: float) -> str:
    return (
        f"{value:g}"
        if 1e-4 <= value < 1e5
        else f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
    )
