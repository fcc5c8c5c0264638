"""The three ships of a published run of a vessel estimator, simulated.

Reports have the times and types of the 63 updates of that run ("Multi Object Tracking framework
diagnostics", read from the exported plots). The third ship turns while there is no report.
"""

from dataclasses import replace
from typing import Any

from trackmetrics import _deprecated
from trackmetrics._tables.errors import value
from trackmetrics.vessel.settings import AIS, POSITION, TRUNCATED_AIS, Noise, Settings
from trackmetrics.vessel.simulation import Ship, Simulation, Turn, simulate

_LETTERS = {"A": AIS, "T": TRUNCATED_AIS, "P": POSITION}


def _seen(minutes: str, letters: str) -> dict[str, Any]:
    times = tuple(60.0 * int(minute) for minute in minutes.split())
    return {"times": times, "kinds": tuple(_LETTERS[letter] for letter in letters)}


THREE_SHIPS = (
    Ship(
        "MV Iron Falcon2",
        (72.04, 30.0, 10.0, 45.0),
        **_seen(
            "0 5 13 25 28 33 36 53 59 65 73 78 79 88 94 96 103 109 111 117 119 125 129 133 141"
            " 161 165 169",
            "TAAAAAAPPAPPPPPPAPPAAPPAAAAA",
        ),
    ),
    Ship(
        "SS Iron Aurora1",
        (74.53, 32.0, 10.0, 45.0),
        **_seen(
            "5 20 29 37 50 54 59 64 66 74 83 89 98 104 108 113 117 120 125 129 137 145 149 169",
            "TAAPPAPPPPPPPPPAAAPAPAAA",
        ),
    ),
    Ship(
        "SS Northern Star0",
        (73.60, 35.0, 25.0, 180.0),
        **_seen("5 36 50 54 64 69 72 78 81 113 120", "AAPPPPPPPAA"),
        turns=(Turn(5100.0, 6900.0, 0.10),),
    ),
)
"""The ships of the published run: minutes and kinds of its 63 updates (A AIS, T truncated AIS,
P position), starts near its own. Northern Star0's turn falls into the silence of the run from 4860
to 6780 s; the published run has no such turn, but breaks at the same update."""

ACCELERATION, TURN = 1e-4, 1e-7

CONSISTENT = Settings(
    ais=Noise(350.0, 1.25, 2.0),
    truncated_ais=Noise(150.0),
    position=Noise(350.0),
    acceleration_density=ACCELERATION,
    turn_density=TURN,
)
"""Sensor noise as it is: what the published run's reports show against its truth."""
PUBLISHED = replace(CONSISTENT, ais=Noise(600.0, 2.0, 3.0), position=Noise(600.0))
"""Sensor noise as the published run's filter claims it."""


def three_ships(seed: int = 0, noise: str = "consistent") -> Simulation:
    """The three ships of the published run.

    Parameters
    ----------
    seed : int
        The same seed gives the same run.
    noise : str
        ``"consistent"``: the filter assumes the noise that there is. ``"published"``: it
        assumes what the published filter did, and expects twice the true deviations of acceleration
        and turn.

    Returns
    -------
    Simulation
        Falcon2 starts from a speed of 0 and a course of 360, taken for known although they are not,
        as in the published run.

    Examples
    --------
    >>> log = three_ships(seed=1).track()
    >>> len(log), float(log["SS Northern Star0"].time[-1])
    (63, 7200.0)
    """
    if noise in _deprecated.RENAMED_NOISE:
        renamed = _deprecated.RENAMED_NOISE[noise]
        _deprecated.warn(f"three_ships(noise={noise!r})", f"three_ships(noise={renamed!r})")
        noise = renamed
    if noise not in ("consistent", "published"):
        raise ValueError(f"noise must be 'consistent' or 'published', got {value(noise)}")
    share = 1.0 if noise == "consistent" else 0.25
    settings = CONSISTENT if noise == "consistent" else PUBLISHED
    falcon = replace(settings, trust_missing_values=True, num_tentative=1)
    true = replace(
        CONSISTENT,
        acceleration_density=ACCELERATION * share,
        turn_density=TURN * share,
    )
    each = {ship.name: settings for ship in THREE_SHIPS} | {THREE_SHIPS[0].name: falcon}
    return simulate(THREE_SHIPS, true, each, begin=-420.0, end=10_320.0, seed=seed)
