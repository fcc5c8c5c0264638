"""Diagnosis of an estimator's log: is the filter consistent, since when not, and which state?"""

from trackmetrics import _deprecated
from trackmetrics.diagnostics.diagnose import diagnose
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
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

__all__ = [
    "VERDICTS",
    "Bias",
    "Diagnosis",
    "InnovationCorrelation",
    "LiveMonitor",
    "LiveStatus",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "StateDiagnosis",
    "TrackDiagnosis",
    "diagnose",
]

__getattr__ = _deprecated.module_getattr(__name__)
