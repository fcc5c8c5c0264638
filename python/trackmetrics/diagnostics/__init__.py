"""Is the filter honest, since when, and which state? A log of an estimator, and its diagnosis."""

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
from trackmetrics.logs.header import State
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.logs.read import read_log

__all__ = [
    "VERDICTS",
    "Bias",
    "Diagnosis",
    "EstimatorLog",
    "Factor",
    "LinearModel",
    "LiveMonitor",
    "LiveStatus",
    "NoiseEstimate",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "State",
    "StateDiagnosis",
    "TrackDiagnosis",
    "WhatIf",
    "Whiteness",
    "diagnose",
    "estimate_noise",
    "read_log",
    "whatif",
]
