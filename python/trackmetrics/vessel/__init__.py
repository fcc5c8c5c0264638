"""The vessel estimator: five states, AIS and positions, many vessels, simulated and real.

>>> from trackmetrics import vessel
>>> log = vessel.three_ships(seed=0).track()
>>> log.tracks
('MV Iron Falcon2', 'SS Iron Aurora1', 'SS Northern Star0')
"""

from trackmetrics import _deprecated
from trackmetrics.vessel.ais import read_ais
from trackmetrics.vessel.holdout import HeldOutResult, predictive_nis
from trackmetrics.vessel.published_run import THREE_SHIPS, three_ships
from trackmetrics.vessel.reports import Reports, thin
from trackmetrics.vessel.screening import Recording, RejectedRow, screen_rows
from trackmetrics.vessel.settings import REPORT_TYPES, STATES, Noise, Settings
from trackmetrics.vessel.simulation import (
    Ship,
    Simulation,
    Turn,
    fleet,
    simulate,
)
from trackmetrics.vessel.tracker import Tracker, VesselTrack

__all__ = [
    "REPORT_TYPES",
    "STATES",
    "THREE_SHIPS",
    "HeldOutResult",
    "Noise",
    "Recording",
    "RejectedRow",
    "Reports",
    "Settings",
    "Ship",
    "Simulation",
    "Tracker",
    "Turn",
    "VesselTrack",
    "fleet",
    "predictive_nis",
    "read_ais",
    "screen_rows",
    "simulate",
    "thin",
    "three_ships",
]

__getattr__ = _deprecated.module_getattr(__name__)
