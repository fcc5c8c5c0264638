"""Is a filter honest about its own uncertainty?"""

from trackmetrics.consistency.chi_square import consistency_test, credibility_interval
from trackmetrics.consistency.forms import (
    average_nees,
    nees,
    nees_sequence,
    nis,
    nis_sequence,
)

__all__ = [
    "average_nees",
    "consistency_test",
    "credibility_interval",
    "nees",
    "nees_sequence",
    "nis",
    "nis_sequence",
]
