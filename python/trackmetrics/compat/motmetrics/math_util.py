"""Division as py-motmetrics divides."""

from typing import Any

import numpy as np


def quiet_divide(a: Any, b: Any) -> Any:
    """``a / b`` without warnings: ``0 / 0`` is NaN and ``1 / 0`` is infinite."""
    with np.errstate(all="ignore"):
        return np.true_divide(a, b)
