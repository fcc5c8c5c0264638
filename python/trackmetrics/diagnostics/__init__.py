"""Diagnosis of an estimator's log: is the filter consistent, since when not, and which state?"""

from trackmetrics import _deprecated
from trackmetrics.diagnostics.diagnose import diagnose
from trackmetrics.diagnostics.live import LiveMonitor, LiveStatus
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
    "LiveMonitor",
    "LiveStatus",
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "StateDiagnosis",
    "TrackDiagnosis",
    "Whiteness",
    "diagnose",
]

__getattr__ = _deprecated.module_getattr(__name__)
