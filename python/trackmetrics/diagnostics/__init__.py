"""Is the filter honest, since when, and which state? A log of an estimator, and its diagnosis."""

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
    "Outlier",
    "QuantityVerdict",
    "Segment",
    "State",
    "StateDiagnosis",
    "TrackDiagnosis",
    "Whiteness",
    "read_log",
]
