"""What a simulated ship may be: a wrong number is refused under the name of its field."""

from dataclasses import replace

import numpy as np
import pytest

from trackmetrics.vessel import Noise, Settings, Ship, Turn, fleet, simulate

SHIP = Ship("a", (50.0, 1.0, 10.0, 90.0), (0.0, 60.0), (0, 0))
NOT_NUMBERS = [np.nan, np.inf, True, "a", None]


def run(ship=SHIP, begin=0.0, end=100.0, seed=0, settings=None):
    each = {"a": Settings()} if settings is None else settings
    return simulate([ship], Settings(), each, begin=begin, end=end, seed=seed)


CASES = [
    *((f"start[{i}]", {"start": (*SHIP.start[:i], v, *SHIP.start[i + 1 :])})
      for i in range(4) for v in NOT_NUMBERS),
    *(("times[1]", {"times": (0.0, v)}) for v in [*NOT_NUMBERS, -10.0, 110.0]),
    ("times[1]", {"times": (60.0, 0.0)}),
    *(("kinds[0]", {"kinds": (v, 0)}) for v in [4, -1, 0.5, True, "a", None]),
    ("kinds", {"kinds": (0,)}),
    ("start[2]", {"start": (50.0, 1.0, -1.0, 90.0)}),
    ("start[0]", {"start": (95.0, 1.0, 1.0, 90.0)}),
    *((f"turns[0].{f}", {"turns": (replace(Turn(0.0, 10.0, 0.1), **{f: v}),)})
      for f in ("start", "stop", "rate") for v in NOT_NUMBERS),
    ("turns[0].stop", {"turns": (Turn(20.0, 10.0, 0.1),)}),
    ("name", {"name": 3}),
]  # fmt: skip


@pytest.mark.parametrize(("field", "change"), CASES)
def test_a_ship_is_refused_under_the_name_of_its_field(field, change):
    with pytest.raises((ValueError, TypeError)) as caught:
        run(replace(SHIP, **change))
    assert f"ships[0].{field}" in str(caught.value)


@pytest.mark.parametrize("field", ["begin", "end", "seed"])
@pytest.mark.parametrize("value", [*NOT_NUMBERS[:2], "a", None])
def test_the_other_arguments_are_named(field, value):
    with pytest.raises((ValueError, TypeError), match=field):
        run(**{field: value})


def test_what_does_not_fit_together_is_named():
    for field, change in {"end": {"end": 0.0}, "settings": {"settings": {}}}.items():
        with pytest.raises(ValueError, match=field):
            run(**change)


@pytest.mark.parametrize("change", [{"centre": (95.0, 0.0)}, {"ships": 2.5}, {"seed": -1}])
def test_a_fleet_names_its_arguments(change):
    with pytest.raises((ValueError, TypeError), match=next(iter(change))):
        fleet(**{"ships": 2, **change})


NOISES = ("position", "speed", "course")
SETTINGS = ("acceleration_density", "turn_density", "turn_rate_decay", "turn_rate_std")


@pytest.mark.parametrize("value", [np.nan, -1.0, "a", True])
@pytest.mark.parametrize(("kind", "field"), [*((Noise, f) for f in NOISES),
                                            *((Settings, f) for f in SETTINGS)])  # fmt: skip
def test_noise_and_settings_are_named(kind, field, value):
    good = {"position": 10.0} if kind is Noise else {}
    with pytest.raises((ValueError, TypeError), match=field):
        kind(**{**good, field: value})
