"""What a simulation takes, checked before anything is drawn: every message names the field."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from trackmetrics import _check, errors
from trackmetrics.vessel.settings import REPORT_TYPES

STEP = 10.0
"""Seconds between two kicks of the true motion; the shortest fleet is one step long."""


def check_simulation(
    ships: Sequence[Any], settings: Mapping[str, Any], begin: float, end: float, seed: int
) -> None:
    """The arguments of ``simulate``."""
    _finite("begin", begin)
    _finite("end", end)
    if not begin < end:
        raise errors.parameter("end", f"after begin, {float(begin)!r}", end)
    _check.count("seed", seed, 0)
    for k, ship in enumerate(ships):
        _check_ship(f"ships[{k}]", ship, begin, end)
        if ship.name not in settings:
            raise ValueError(f"settings has no entry for ships[{k}], {ship.name!r}")


def check_fleet(
    ships: int, duration: float, type_shares: Sequence[float], centre: Sequence[float], seed: int
) -> None:
    """The arguments of ``fleet`` that it does not hand on."""
    if not _check.number("ships", ships) >= 1:
        raise errors.parameter("ships", "at least 1", ships)
    _check.whole("ships", ships)
    _check.count("seed", seed, 0)
    if not STEP <= _check.number("duration", duration) < math.inf:
        raise errors.parameter("duration", f"at least {STEP:g} and finite", duration)
    for k, share in enumerate(type_shares):
        _finite(f"type_shares[{k}]", share)
    if len(type_shares) != 3 or abs(sum(type_shares) - 1) > 1e-9 or min(type_shares) < 0:
        raise ValueError(
            f"type_shares must be at least 0 and add up to 1, got {tuple(type_shares)}"
        )
    _place("centre", centre)


def _check_ship(name: str, ship: Any, begin: float, end: float) -> None:
    if not isinstance(ship.name, str) or not ship.name:
        raise TypeError(f"{name}.name must be text, got {ship.name!r}")
    if len(ship.start) != 4:
        raise ValueError(f"{name}.start has {len(ship.start)} numbers, expected 4")
    for i, value in enumerate(ship.start):
        _finite(f"{name}.start[{i}]", value)
    _place(f"{name}.start", ship.start)
    if ship.start[2] < 0:
        raise errors.element(f"{name}.start", [2], "at least 0", ship.start[2])
    _check_times(name, ship.times, begin, end)
    if len(ship.kinds) != len(ship.times):
        raise errors.length(f"{name}.kinds", len(ship.kinds), "times", len(ship.times), "reports")
    for i, kind in enumerate(ship.kinds):
        if isinstance(kind, bool) or not 0 <= _check.whole(f"{name}.kinds[{i}]", kind) < (
            len(REPORT_TYPES)
        ):
            raise ValueError(f"{name}.kinds[{i}] must be 0, 1, 2 or 3, got {kind!r}")
    for i, turn in enumerate(ship.turns):
        for field in ("start", "stop", "rate"):
            _finite(f"{name}.turns[{i}].{field}", getattr(turn, field))
        if not turn.start <= turn.stop:
            raise errors.parameter(f"{name}.turns[{i}].stop", "at or after start", turn.stop)


def _check_times(name: str, times: Sequence[float], begin: float, end: float) -> None:
    for i, time in enumerate(times):
        _finite(f"{name}.times[{i}]", time)
        if not begin <= time <= end:
            raise errors.element(f"{name}.times", [i], "between begin and end", time)
        if i and time < times[i - 1]:
            raise errors.element(f"{name}.times", [i], "at or after the time before it", time)


def _place(name: str, place: Sequence[float]) -> None:
    """Latitude and longitude in degrees."""
    for i, limit in enumerate((90, 360)):
        _finite(f"{name}[{i}]", place[i])
        if not -limit <= place[i] <= limit:
            raise errors.element(name, [i], f"between -{limit} and {limit}", place[i])


def _finite(name: str, value: Any) -> None:
    if isinstance(value, bool):
        raise TypeError(f"{name} must be a real number, got {value!r}")
    if not math.isfinite(_check.number(name, value)):
        raise errors.not_finite(name, [], value)
