"""Old place of the tables of boxes, which are now in :mod:`trackmetrics.tracks`."""

from trackmetrics import _deprecated

__all__ = ["Boxes", "read_mot_challenge"]
__getattr__ = _deprecated.module_getattr(__name__)
