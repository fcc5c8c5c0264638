"""The module path of pytcl's MOSPA functions: the same objects as in :mod:`trackmetrics`."""

from trackmetrics.point_sets.mmospa import calc_mospa_error, mmospa2tar_2d, mmospa_approx

__all__ = ["calc_mospa_error", "mmospa2tar_2d", "mmospa_approx"]
