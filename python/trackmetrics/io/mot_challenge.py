"""Old place of the reader of MOTChallenge files, which is now in :mod:`trackmetrics.tracks`."""

from trackmetrics import _deprecated

__all__ = ["Boxes", "read_mot_challenge"]  # noqa: F822 - found by __getattr__
__getattr__ = _deprecated.module_getattr(__name__)
