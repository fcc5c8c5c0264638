"""Distances between finite sets of points."""

from trackmetrics.point_sets.distances import Mahalanobis
from trackmetrics.point_sets.gospa import gospa, gospa_from_distances, gospa_over_time
from trackmetrics.point_sets.mmospa import calc_mospa_error, mmospa2tar_2d, mmospa_approx
from trackmetrics.point_sets.ospa import (
    ospa,
    ospa_assignment,
    ospa_from_distances,
    ospa_over_time,
)

__all__ = [
    "Mahalanobis",
    "calc_mospa_error",
    "gospa",
    "gospa_from_distances",
    "gospa_over_time",
    "mmospa2tar_2d",
    "mmospa_approx",
    "ospa",
    "ospa_assignment",
    "ospa_from_distances",
    "ospa_over_time",
]
