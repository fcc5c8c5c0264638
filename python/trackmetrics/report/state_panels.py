"""One row of panels a state: its value, the claim against its reference, the error in claims."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from trackmetrics.diagnostics import State, StateDiagnosis
from trackmetrics.report.axes import (
    Limits,
    angle_ticks,
    broken,
    linear_limits,
    log_limits,
    on_branch,
    on_log_axis,
    unrolled,
    whole,
)
from trackmetrics.report.layout import Frame
from trackmetrics.report.scene import (
    Band,
    Event,
    Floats,
    Heading,
    Level,
    Line,
    Mark,
    Panel,
    Points,
    Rectangle,
    Text,
)
from trackmetrics.report.track_view import Subject

TWO_SIDED = 1.96
"""Standard deviations within which 95 % of honest errors lie."""
EDGE = 6.0
"""Errors beyond so many claimed deviations are drawn as arrows at the edge."""

HEIGHT, GAP = 118.0, 34.0

Maker = Callable[[Subject, int, Rectangle], Panel]


def state_block(
    subject: Subject, frame: Frame, top: float
) -> tuple[list[Panel], tuple[Heading, ...], float]:
    """The panels of all states below ``top``, the words above their columns, and where they end."""
    makers = [maker for maker in _HEADINGS if _any(subject, maker)]
    states = [i for i in range(len(subject.states)) if any(_has(subject, m, i) for m in makers)]
    cells = [(maker, state) for state in states for maker in makers]
    columns = len(makers) if len(makers) > 1 else min(3, len(cells))
    if not cells:
        return [], (), top
    panels = []
    for i, (maker, state) in enumerate(cells):
        y = top + i // columns * (HEIGHT + GAP)
        place = frame.columns(y, HEIGHT, columns)[i % columns]
        panels.append(_cell(subject, maker, state, place, last=i + columns >= len(cells)))
    places = frame.columns(top - 28.0, 0.0, columns)
    heads = (Heading(p.left, p.top, _HEADINGS[m]) for p, m in zip(places, makers, strict=False))
    return panels, tuple(heads), panels[-1].place.top + HEIGHT


def _cell(subject: Subject, maker: Maker, state: int, place: Rectangle, last: bool) -> Panel:
    panel = maker(subject, state, place) if _has(subject, maker, state) else _empty(subject, place)
    return replace(panel, x_label=subject.clock.label) if last else panel


def _any(subject: Subject, maker: Maker) -> bool:
    return any(_has(subject, maker, i) for i in range(len(subject.states)))


def _has(subject: Subject, maker: Maker, state: int) -> bool:
    """Whether the log holds what this panel shows of this state."""
    needed = _NEEDED[maker]
    return all(subject.state_column(name, state) is not None for name in needed)


def _empty(subject: Subject, place: Rectangle) -> Panel:
    limits = subject.x_limits
    middle = 0.5 * (limits[0] + limits[1])
    words = Text(middle, 0.5, "not in the log", "muted", "center")
    return Panel(place, (words,), x_limits=limits, y_limits=(0.0, 1.0), ticks=())


def _label(state: State) -> str:
    return f"{state.name} ({state.unit})" if state.unit else state.name


def _weak(subject: Subject, state: State) -> str:
    return ", the weakest state" if subject.track.weakest_state == state.name else ""


def _diagnosed(subject: Subject, state: int) -> StateDiagnosis | None:
    name = subject.states[state].name
    return next((s for s in subject.track.states if s.state == name), None)


def _value(subject: Subject, index: int, place: Rectangle) -> Panel:
    """Measured, estimated and true values, with two claimed standard deviations."""
    state, x = subject.states[index], subject.minutes
    estimate, truth = subject.state_column("x", index), subject.state_column("truth", index)
    assert estimate is not None
    if state.period is not None:
        base = estimate if truth is None else np.where(np.isfinite(truth), truth, estimate)
        base = unrolled(base, state.period)
        estimate = on_branch(estimate, base, state.period)
        truth = None if truth is None else on_branch(truth, base, state.period)
    std, measured = subject.state_column("std", index), _measured(subject, index, estimate)
    marks: list[Mark] = []
    if std is not None:
        bx, by, bs = broken(*whole(x, estimate, std), period=state.period)
        marks.append(Band(bx, by - 2 * bs, by + 2 * bs, f"{subject.style.colour}/0.18", "±2 σ"))
    if truth is not None:
        tx, ty = whole(x, truth)
        marks.append(Line(tx, ty, "ink", 1.3, "dash", "truth"))
    ex, ey = broken(*whole(x, estimate), period=state.period)
    marks.append(Line(ex, ey, subject.style.colour, 1.8, name="estimate"))
    return _value_panel(subject, state, place, (*marks, *measured))


def _value_panel(
    subject: Subject, state: State, place: Rectangle, marks: tuple[Mark, ...]
) -> Panel:
    heights = [m.y for m in marks if isinstance(m, (Line, Points))]
    heights += [side for m in marks if isinstance(m, Band) for side in (m.low, m.high)]
    limits, ticks = linear_limits(heights), None
    if state.period is not None:
        column = subject.state_column("x", subject.states.index(state))
        signed = column is not None and bool(np.nanmin(column) < 0)
        ticks = tuple(angle_ticks(limits, state.period, signed))
    return Panel(
        place,
        marks,
        title=f"{state.name}{_weak(subject, state)}",
        y_label=_label(state),
        x_limits=subject.x_limits,
        y_limits=limits,
        ticks=ticks,
    )


def _measured(subject: Subject, index: int, estimate: Floats) -> list[Points]:
    """What was measured of a state, one symbol a measurement type."""
    if subject.rows is None or subject.rows.z is None or subject.rows.observed is None:
        return []
    width = min(subject.rows.z.shape[1], subject.rows.observed.shape[1])
    hits = subject.rows.observed[:, :width] == index
    value = np.where(hits, subject.rows.z[:, :width], np.nan)
    seen = np.isfinite(value).any(axis=1)
    z = np.where(hits & np.isfinite(value), value, 0.0).sum(axis=1)
    period = subject.states[index].period
    if period is not None:
        z = on_branch(z, np.where(np.isfinite(estimate), estimate, z), period)
    points = []
    for kind, symbol, hollow, rows in subject.kinds():
        chosen = rows & seen
        if chosen.any():
            x, y = subject.minutes[chosen], z[chosen]
            points.append(Points(x, y, "ink", symbol, hollow, 4.5, f"measured, {kind}"))
    return points


def _claim(subject: Subject, index: int, place: Rectangle) -> Panel:
    """The claimed standard deviation as a ratio to its reference."""
    state, std = subject.states[index], subject.state_column("std", index)
    diagnosed = _diagnosed(subject, index)
    assert std is not None
    reference = _reference(std, diagnosed)
    doubled = None if diagnosed is None else diagnosed.growth_onset_time
    limits = log_limits([std / reference], names=int(doubled is not None))
    marks: list[Mark] = [Level(1.0, "muted/0.8")]
    ratio = on_log_axis(std / reference, limits)
    minutes, line = whole(subject.minutes, ratio)
    marks.append(Line(minutes, line, subject.style.colour, 1.8, name="claimed σ"))
    marks += _points(subject, ratio, 4.0)
    if doubled is not None:
        marks.append(_doubled(subject, doubled))
    unit = f" {state.unit}" if state.unit else ""
    return Panel(
        place,
        tuple(marks),
        title=f"{state.name}{_weak(subject, state)}: 1 = {reference:.3g}{unit}",
        y_label="σ / reference",
        log=True,
        x_limits=subject.x_limits,
        y_limits=limits,
    )


def _doubled(subject: Subject, time: float) -> Event:
    minute = subject.clock.at(time)
    return Event(minute, "doubled", "warning", left=minute > 0.7 * subject.span[1])


def _reference(std: Floats, diagnosed: StateDiagnosis | None) -> float:
    if diagnosed is not None and np.isfinite(diagnosed.reference_std):
        return diagnosed.reference_std
    return float(std[np.isfinite(std)][0])


def _error(subject: Subject, index: int, place: Rectangle) -> Panel:
    """The error in claimed standard deviations, with the band that 95 % of honest ones keep to."""
    state = subject.states[index]
    error, std = subject.state_column("error", index), subject.state_column("std", index)
    assert error is not None
    assert std is not None
    ratio = error / std
    inside = np.where(np.abs(ratio) > EDGE, np.nan, ratio)
    minutes, line = whole(subject.minutes, np.clip(ratio, -EDGE, EDGE))
    marks: list[Mark] = [
        Level(-TWO_SIDED, "band/0.22", top=TWO_SIDED),
        Level(0.0, "muted/0.8"),
        Line(minutes, line, f"{subject.style.colour}/0.6", 1.2),
        *_points(subject, inside, 4.5),
        *_beyond(subject, ratio),
    ]
    return Panel(
        place,
        tuple(marks),
        title=f"{state.name}{_weak(subject, state)}",
        y_label="error / σ",
        x_limits=subject.x_limits,
        y_limits=_error_limits(ratio),
    )


def _error_limits(ratio: Floats) -> Limits:
    low, high = linear_limits([np.clip(ratio, -EDGE, EDGE)], (-3.0, 3.0))
    return max(low, -EDGE - 0.6), min(high, EDGE + 0.6)


def _beyond(subject: Subject, ratio: Floats) -> list[Mark]:
    """Arrows at the edge for errors that are far beyond the band."""
    marks: list[Mark] = []
    for beyond, y, symbol in (
        (ratio > EDGE, EDGE, "triangle-up"),
        (ratio < -EDGE, -EDGE, "triangle-down"),
    ):
        if beyond.any():
            name = f"beyond {y:+g} σ, up to {np.abs(ratio[beyond]).max():.3g} σ"
            x = subject.minutes[beyond]
            marks.append(Points(x, np.full(len(x), y), "high", symbol, False, 9.0, name))
    return marks


def _points(subject: Subject, values: Floats, size: float) -> list[Mark]:
    marks: list[Mark] = []
    for kind, symbol, hollow, rows in subject.kinds():
        chosen = rows & np.isfinite(values)
        if chosen.any():
            x, y = subject.minutes[chosen], values[chosen]
            marks.append(Points(x, y, subject.style.colour, symbol, hollow, size, kind))
    return marks


_HEADINGS: dict[Maker, str] = {
    _value: "estimate with ±2 σ, truth dashed, measurements as symbols",
    _claim: "claimed σ over its reference",
    _error: "error over claimed σ (shaded: 95 %)",
}
_NEEDED: dict[Maker, tuple[str, ...]] = {
    _value: ("x",),
    _claim: ("std",),
    _error: ("error", "std"),
}
