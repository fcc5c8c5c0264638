"""Distances between sets of trajectories."""

from trackmetrics.trajectories.functions import ospa2, trajectory_gospa

__all__ = ["ospa2", "trajectory_gospa"]
