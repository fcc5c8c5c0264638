"""Distances on the sphere, and the knot."""

from typing import Any

import numpy as np

KNOT = 1852.0 / 3600.0
"""One knot in metres per second."""
EARTH_RADIUS = 6_371_008.8
"""Mean radius of the Earth in metres (IUGG), for distances between reports."""


def metres_between(lat0: Any, lon0: Any, lat1: Any, lon1: Any) -> Any:
    """Great-circle distance in metres between points in degrees (haversine), element by element."""
    phi0, phi1 = np.radians(lat0), np.radians(lat1)
    half = np.sin((phi1 - phi0) / 2) ** 2
    half = half + np.cos(phi0) * np.cos(phi1) * np.sin(np.radians(np.subtract(lon1, lon0)) / 2) ** 2
    return 2 * EARTH_RADIUS * np.arcsin(np.sqrt(np.minimum(half, 1.0)))
