"""Tracks and truth as tables, from files and objects and back."""

from trackmetrics.tracks.mot_challenge import Boxes, read_mot_challenge
from trackmetrics.tracks.read import read_tracks
from trackmetrics.tracks.table import TrackTable

__all__ = ["Boxes", "TrackTable", "read_mot_challenge", "read_tracks"]
