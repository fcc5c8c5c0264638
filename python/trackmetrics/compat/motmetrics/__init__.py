"""py-motmetrics over our kernels: ``import trackmetrics.compat.motmetrics as mm``.

The names, arguments, frames and numbers of py-motmetrics 1.4.0, on current NumPy and pandas. Frames
need pandas (extra ``motmetrics``).

>>> import trackmetrics.compat.motmetrics as mm
>>> acc = mm.MOTAccumulator(auto_id=True)
>>> acc.update([1, 2], [7, 8], [[0.1, 0.9], [0.7, 0.2]])
0
>>> acc.update([1, 2], [7], [[0.2], [float("nan")]])
1
>>> mm.metrics.create().compute(acc, metrics=["mota", "idf1"], return_dataframe=False)["mota"]
np.float64(0.75)
"""

from trackmetrics.compat.motmetrics import distances, io, lap, math_util, metrics, preprocess, utils
from trackmetrics.compat.motmetrics.mot import MOTAccumulator

__all__ = [
    "MOTAccumulator",
    "distances",
    "io",
    "lap",
    "math_util",
    "metrics",
    "preprocess",
    "utils",
]

__version__ = "1.4.0"
"""The release of py-motmetrics whose behaviour this is."""
