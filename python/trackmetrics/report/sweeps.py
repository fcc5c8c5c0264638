"""Old place of the figures of sweeps, which are now in :mod:`trackmetrics.report`."""

from trackmetrics import _deprecated

__getattr__ = _deprecated.module_getattr(__name__)
