"""Distances between finite sets of points."""

from trackmetrics.point_sets.distances import Mahalanobis
from trackmetrics.point_sets.functions import (
    gospa,
    gospa_from_distances,
    gospa_over_time,
    ospa,
    ospa_assignment,
    ospa_from_distances,
    ospa_over_time,
)

__all__ = [
    "Mahalanobis",
    "gospa",
    "gospa_from_distances",
    "gospa_over_time",
    "ospa",
    "ospa_assignment",
    "ospa_from_distances",
    "ospa_over_time",
]
