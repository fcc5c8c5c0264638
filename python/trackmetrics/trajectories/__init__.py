"""Distances between sets of trajectories."""

from trackmetrics.trajectories.gospa import trajectory_gospa
from trackmetrics.trajectories.ospa2 import ospa2

__all__ = ["ospa2", "trajectory_gospa"]
