"""One row of panels per state: value, standard deviation over its reference, normalized error."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from trackmetrics.diagnostics import StateDiagnosis
from trackmetrics.logs import State
from trackmetrics.report.angles import angle_ticks, break_at_jumps, unwrap, wrap_near
from trackmetrics.report.axes import Limits, drop_nan, linear_limits, log_limits, on_log_axis
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Bounds,
    Event,
    Floats,
    Heading,
    HLine,
    Line,
    Panel,
    Points,
    Primitive,
    StdBand,
    Text,
)
from trackmetrics.report.track_view import TrackView

QUANTILE_95 = 1.96
"""Standard deviations within which 95 % of normal errors lie."""
MAX_DRAWN_ERROR = 6.0
"""Errors of more standard deviations than this are drawn as arrows at the edge."""

HEIGHT, GAP = 118.0, 34.0

PanelBuilder = Callable[[TrackView, int, Bounds], Panel]


def state_block(
    view: TrackView, frame: Frame, top: float
) -> tuple[list[Panel], tuple[Heading, ...], float]:
    """The panels of all states below ``top``, the headings of their columns, and where they end."""
    builders = [builder for builder in _HEADINGS if _any(view, builder)]
    states = [i for i in range(len(view.states)) if any(_has(view, m, i) for m in builders)]
    grid = [(builder, state) for state in states for builder in builders]
    columns = len(builders) if len(builders) > 1 else min(3, len(grid))
    if not grid:
        return [], (), top
    panels = []
    for i, (builder, state) in enumerate(grid):
        y = top + i // columns * (HEIGHT + GAP)
        bounds = frame.columns(y, HEIGHT, columns)[i % columns]
        panels.append(_panel_or_empty(view, builder, state, bounds, last=i + columns >= len(grid)))
    all_bounds = frame.columns(top - 28.0, 0.0, columns)
    heads = (
        Heading(p.left, p.top, _HEADINGS[m]) for p, m in zip(all_bounds, builders, strict=False)
    )
    return panels, tuple(heads), panels[-1].bounds.top + HEIGHT


def _panel_or_empty(
    view: TrackView, builder: PanelBuilder, state: int, bounds: Bounds, last: bool
) -> Panel:
    panel = builder(view, state, bounds) if _has(view, builder, state) else _empty(view, bounds)
    return replace(panel, x_label=view.clock.label) if last else panel


def _any(view: TrackView, builder: PanelBuilder) -> bool:
    return any(_has(view, builder, i) for i in range(len(view.states)))


def _has(view: TrackView, builder: PanelBuilder, state: int) -> bool:
    """Whether the log holds what this panel shows of this state."""
    needed = _NEEDED[builder]
    return all(view.state_column(name, state) is not None for name in needed)


def _empty(view: TrackView, bounds: Bounds) -> Panel:
    limits = view.x_limits
    middle = 0.5 * (limits[0] + limits[1])
    text = Text(middle, 0.5, "not in the log", "muted", "center")
    return Panel(bounds, (text,), x_limits=limits, y_limits=(0.0, 1.0), ticks=())


def _label(state: State) -> str:
    return f"{state.name} ({state.unit})" if state.unit else state.name


def _weak(view: TrackView, state: State) -> str:
    return ", the weakest state" if view.track.weakest_state == state.name else ""


def _diagnosed(view: TrackView, state: int) -> StateDiagnosis | None:
    name = view.states[state].name
    return next((s for s in view.track.states if s.state == name), None)


def _value_panel(view: TrackView, index: int, bounds: Bounds) -> Panel:
    """Measured, estimated and true values, with a band of two standard deviations."""
    state, x = view.states[index], view.minutes
    estimate, truth = view.state_column("x", index), view.state_column("truth", index)
    assert estimate is not None
    if state.period is not None:
        base = estimate if truth is None else np.where(np.isfinite(truth), truth, estimate)
        base = unwrap(base, state.period)
        estimate = wrap_near(estimate, base, state.period)
        truth = None if truth is None else wrap_near(truth, base, state.period)
    std, measured = view.state_column("std", index), _measured(view, index, estimate)
    primitives: list[Primitive] = []
    if std is not None:
        reference = _reference(std, _diagnosed(view, index))
        relative = std / reference  # which the next panel shows, too
        columns = break_at_jumps(*drop_nan(x, estimate, relative), period=state.period)
        colour = f"{view.style.colour}/0.18"
        bx, centre, half = columns
        primitives.append(StdBand(bx, centre, half, 2 * reference, colour, "±2 σ"))
    if truth is not None:
        tx, ty = drop_nan(x, truth)
        primitives.append(Line(tx, ty, "ink", 1.3, "dash", "truth"))
    ex, ey = break_at_jumps(*drop_nan(x, estimate), period=state.period)
    primitives.append(Line(ex, ey, view.style.colour, 1.8, name="estimate"))
    return _value_axes(view, state, bounds, (*primitives, *measured))


def _value_axes(
    view: TrackView, state: State, bounds: Bounds, primitives: tuple[Primitive, ...]
) -> Panel:
    heights = [m.y for m in primitives if isinstance(m, Line)]
    heights += [m.drawn()[1] for m in primitives if isinstance(m, Points)]
    heights += [side for m in primitives if isinstance(m, StdBand) for side in (m.low, m.high)]
    limits, ticks = linear_limits(heights), None
    if state.period is not None:
        column = view.state_column("x", view.states.index(state))
        signed = column is not None and bool(np.nanmin(column) < 0)
        ticks = tuple(angle_ticks(limits, state.period, signed))
    return Panel(
        bounds,
        primitives,
        title=f"{state.name}{_weak(view, state)}",
        y_label=_label(state),
        x_limits=view.x_limits,
        y_limits=limits,
        ticks=ticks,
    )


def _measured(view: TrackView, index: int, estimate: Floats) -> list[Points]:
    """The measured values of a state, one symbol per measurement type."""
    if view.rows is None or view.rows.z is None or view.rows.observed is None:
        return []
    width = min(view.rows.z.shape[1], view.rows.observed.shape[1])
    hits = view.rows.observed[:, :width] == index
    value = np.where(hits, view.rows.z[:, :width], np.nan)
    seen = np.isfinite(value).any(axis=1)
    z = np.where(hits & np.isfinite(value), value, 0.0).sum(axis=1)
    z = np.where(seen, z, np.nan)
    period = view.states[index].period
    if period is not None:
        z = wrap_near(z, np.where(np.isfinite(estimate), estimate, z), period)
    points = []
    for kind, symbol, hollow, rows in view.groups_of(z):
        name = f"measured, {kind}"
        points.append(Points(view.minutes, z, "ink", symbol, hollow, 4.5, name, rows))
    return points


def _std_ratio_panel(view: TrackView, index: int, bounds: Bounds) -> Panel:
    """The standard deviation over its reference."""
    state, std = view.states[index], view.state_column("std", index)
    diagnosed = _diagnosed(view, index)
    assert std is not None
    reference = _reference(std, diagnosed)
    doubled = None if diagnosed is None else diagnosed.growth_onset_time
    limits = log_limits([std / reference], names=int(doubled is not None))
    primitives: list[Primitive] = [HLine(1.0, "muted/0.8")]
    ratio = on_log_axis(std / reference, limits)
    minutes, line = drop_nan(view.minutes, ratio)
    primitives.append(Line(minutes, line, view.style.colour, 1.8, name="σ"))
    primitives += _points(view, ratio, 4.0)
    if doubled is not None:
        primitives.append(_doubled(view, doubled))
    unit = f" {state.unit}" if state.unit else ""
    return Panel(
        bounds,
        tuple(primitives),
        title=f"{state.name}{_weak(view, state)}: 1 = {reference:.3g}{unit}",
        y_label="σ / reference",
        log=True,
        x_limits=view.x_limits,
        y_limits=limits,
    )


def _doubled(view: TrackView, time: float) -> Event:
    minute = view.clock.at(time)
    return Event(minute, "doubled", "warning", left=minute > 0.7 * view.span[1])


def _reference(std: Floats, diagnosed: StateDiagnosis | None) -> float:
    if diagnosed is not None and np.isfinite(diagnosed.reference_std):
        return diagnosed.reference_std
    return float(std[np.isfinite(std)][0])


def _normalized_error_panel(view: TrackView, index: int, bounds: Bounds) -> Panel:
    """The error over its standard deviation, with the interval of 95 %."""
    state = view.states[index]
    error, std = view.state_column("error", index), view.state_column("std", index)
    assert error is not None
    assert std is not None
    ratio = error / std
    inside = np.where(np.abs(ratio) > MAX_DRAWN_ERROR, np.nan, ratio)
    minutes, line = drop_nan(view.minutes, np.clip(ratio, -MAX_DRAWN_ERROR, MAX_DRAWN_ERROR))
    primitives: list[Primitive] = [
        HLine(-QUANTILE_95, "band/0.22", top=QUANTILE_95),
        HLine(0.0, "muted/0.8"),
        Line(minutes, line, f"{view.style.colour}/0.6", 1.2),
        *_points(view, inside, 4.5),
        *_beyond(view, ratio),
    ]
    return Panel(
        bounds,
        tuple(primitives),
        title=f"{state.name}{_weak(view, state)}",
        y_label="error / σ",
        x_limits=view.x_limits,
        y_limits=_error_limits(ratio),
    )


def _error_limits(ratio: Floats) -> Limits:
    low, high = linear_limits([np.clip(ratio, -MAX_DRAWN_ERROR, MAX_DRAWN_ERROR)], (-3.0, 3.0))
    return max(low, -MAX_DRAWN_ERROR - 0.6), min(high, MAX_DRAWN_ERROR + 0.6)


def _beyond(view: TrackView, ratio: Floats) -> list[Primitive]:
    """Arrows at the edge for errors beyond MAX_DRAWN_ERROR."""
    primitives: list[Primitive] = []
    for beyond, y, symbol in (
        (ratio > MAX_DRAWN_ERROR, MAX_DRAWN_ERROR, "triangle-up"),
        (ratio < -MAX_DRAWN_ERROR, -MAX_DRAWN_ERROR, "triangle-down"),
    ):
        if beyond.any():
            name = f"beyond {y:+g} σ, up to {np.abs(ratio[beyond]).max():.3g} σ"
            x = view.minutes[beyond]
            primitives.append(Points(x, np.full(len(x), y), "high", symbol, False, 9.0, name))
    return primitives


def _points(view: TrackView, values: Floats, size: float) -> list[Primitive]:
    primitives: list[Primitive] = []
    colour = view.style.colour
    for kind, symbol, hollow, rows in view.groups_of(values):
        points = Points(view.minutes, values, colour, symbol, hollow, size, kind, rows)
        primitives.append(points)
    return primitives


_HEADINGS: dict[PanelBuilder, str] = {
    _value_panel: "estimate with ±2 σ, truth dashed, measurements as symbols",
    _std_ratio_panel: "σ over its reference",
    _normalized_error_panel: "error over σ (shaded: 95 %)",
}
_NEEDED: dict[PanelBuilder, tuple[str, ...]] = {
    _value_panel: ("x",),
    _std_ratio_panel: ("std",),
    _normalized_error_panel: ("error", "std"),
}
