"""Diagnosis of an estimator's log: is the filter consistent, since when not, and which state?"""

from trackmetrics import _deprecated
from trackmetrics.diagnostics._noise_model import LinearModel
from trackmetrics.diagnostics.diagnose import diagnose
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
from trackmetrics.diagnostics.noise import (
    Factor,
    NoiseEstimate,
    estimate_noise,
)
from trackmetrics.diagnostics.records import (
    VERDICTS,
    Bias,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
    Whiteness,
)
from trackmetrics.diagnostics.results import Diagnosis, TrackDiagnosis
from trackmetrics.diagnostics.whatif import WhatIf, whatif

__all__ = [
    "VERDICTS",
    "Bias",
    "Diagnosis",
    "Factor",
    "LinearModel",
    "LiveMonitor",
    "LiveStatus",
    "NoiseEstimate",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "StateDiagnosis",
    "TrackDiagnosis",
    "WhatIf",
    "Whiteness",
    "diagnose",
    "estimate_noise",
    "whatif",
]

__getattr__ = _deprecated.module_getattr(__name__)
