"""Old place of :mod:`trackmetrics.tracks`."""

from trackmetrics import _deprecated

__getattr__ = _deprecated.module_getattr(__name__)
