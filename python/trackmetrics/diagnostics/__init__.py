"""Is the filter honest, since when, and which state? A log of an estimator, and its diagnosis."""

from trackmetrics.diagnostics.diagnosing import diagnose
from trackmetrics.diagnostics.header import State
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
from trackmetrics.diagnostics.log import EstimatorLog
from trackmetrics.diagnostics.reading import read_log
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
