"""Is a filter honest about its own uncertainty?"""

from typing import Any

import numpy as np

from trackmetrics import _backend, _check


def nees(true_state: Any, estimated_state: Any, covariance: Any) -> Any:
    """Normalised estimation error squared."""
    e = np.atleast_2d(_check.floats("e", true_state) - _check.floats("e", estimated_state))
    p = _check.floats("covariance", covariance).reshape(-1, e.shape[1], e.shape[1])
    return float(_backend.kernels.nees(e, p)[0])
