"""Is the filter honest, since when, and which state? A log of an estimator, and its diagnosis."""

from trackmetrics.diagnostics.diagnosing import diagnose
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
from trackmetrics.diagnostics.log import EstimatorLog, State
from trackmetrics.diagnostics.reading import read_log
from trackmetrics.diagnostics.results import (
    VERDICTS,
    Bias,
    Diagnosis,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
    TrackDiagnosis,
    Whiteness,
)

__all__ = [
    "VERDICTS",
    "Bias",
    "Diagnosis",
    "EstimatorLog",
    "LiveMonitor",
    "LiveStatus",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "State",
    "StateDiagnosis",
    "TrackDiagnosis",
    "Whiteness",
    "diagnose",
    "read_log",
]
