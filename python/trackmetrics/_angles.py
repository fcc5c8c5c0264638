"""Differences of angles."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def wrap(differences: Any, periods: Any) -> NDArray[np.float64]:
    """Differences of angles in (-period/2, period/2]; a period of NaN marks what is no angle.

    Half a period stays positive: 180 degrees is 180, and -180 becomes 180.
    """
    differences, periods = np.asarray(differences), np.asarray(periods)
    if np.isnan(periods).all():
        return np.broadcast_to(
            differences, np.broadcast_shapes(differences.shape, periods.shape)
        ).astype(np.float64)
    turns = np.ceil(differences / periods - 0.5)
    wrapped: NDArray[np.float64] = np.where(
        np.isnan(periods), differences, differences - np.nan_to_num(turns * periods)
    )
    return wrapped
