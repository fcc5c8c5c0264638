"""Tables in and out."""

from trackmetrics.tracks.mot_challenge import Boxes, read_mot_challenge

__all__ = ["Boxes", "read_mot_challenge"]
