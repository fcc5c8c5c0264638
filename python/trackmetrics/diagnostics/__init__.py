"""Diagnosis of an estimator's log: is the filter consistent, since when not, and which state?"""

from trackmetrics import _deprecated
from trackmetrics.diagnostics._noise_model import LinearModel
from trackmetrics.diagnostics.diagnose import diagnose
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
from trackmetrics.diagnostics.noise import Factor, NoiseEstimate, estimate_noise
from trackmetrics.diagnostics.results import (
    VERDICTS,
    Bias,
    InnovationCorrelation,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
)
from trackmetrics.diagnostics.track import Diagnosis, TrackDiagnosis
from trackmetrics.diagnostics.whatif import WhatIf, whatif

__all__ = [
    "VERDICTS",
    "Bias",
    "Diagnosis",
    "EstimatorLog",  # _deprecated.
    "Factor",
    "InnovationCorrelation",
    "LinearModel",
    "LiveMonitor",
    "LiveStatus",
    "NoiseEstimate",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "State",  # _deprecated.
    "StateDiagnosis",
    "TrackDiagnosis",
    "WhatIf",
    "diagnose",
    "estimate_noise",
    "read_log",  # _deprecated.
    "whatif",
]

__getattr__ = _deprecated.module_getattr(__name__)
