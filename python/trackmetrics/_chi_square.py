"""Quantiles of chi-square: what an honest filter's NIS and NEES lie between."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def interval(dof: Any, confidence: float = 0.95) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The central interval of a chi-square value of each of these degrees of freedom.

    >>> low, high = interval([2.0, 4.0])
    >>> [round(float(value), 3) for value in high]
    [7.378, 11.143]
    """
    from scipy.special import chdtri

    tail = (1 - confidence) / 2
    degrees = np.asarray(dof, np.float64)
    return chdtri(degrees, 1 - tail), chdtri(degrees, tail)
