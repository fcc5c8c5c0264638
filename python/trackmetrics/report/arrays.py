"""What a trace of plotly holds for an array: the numbers, or a reference to a packed column."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from trackmetrics.report.axes import finite_runs
from trackmetrics.report.scene import Floats

Json = dict[str, Any]
Rows = NDArray[np.bool_]


class Arrays(Protocol):
    """What turns arrays into what a trace holds."""

    def values(self, values: Floats, log: bool, rows: Rows | None = None) -> Any:
        """Values of the y axis."""

    def times(self, values: Floats, rows: Rows | None = None) -> Any:
        """Values of the x axis."""

    def band(self, x: Floats, low: Floats, high: Floats, log: bool) -> Json:
        """The content of a band between two lines."""

    def std_band(self, x: Floats, centre: Floats, std: Floats, factor: float) -> Json:
        """The content of a band around a line."""


class PlainArrays:
    """Gives plotly the numbers themselves; :class:`packing.PackedArrays` gives references."""

    def values(self, values: Floats, log: bool, rows: Rows | None = None) -> Any:
        """The values, restricted to ``rows``."""
        return values if rows is None else values[rows]

    def times(self, values: Floats, rows: Rows | None = None) -> Any:
        """The times, restricted to ``rows``."""
        return values if rows is None else values[rows]

    def band(self, x: Floats, low: Floats, high: Floats, log: bool) -> Json:
        """The outline of each run without gaps: along the upper side, back along the lower."""
        xs, ys = [np.empty(0)], [np.empty(0)]
        for part in finite_runs(x, low, high):
            xs += [x[part], x[part][::-1], np.array([np.nan])]
            ys += [high[part], low[part][::-1], np.array([np.nan])]
        return {"x": np.concatenate(xs)[:-1], "y": np.concatenate(ys)[:-1]}

    def std_band(self, x: Floats, centre: Floats, std: Floats, factor: float) -> Json:
        """As :meth:`band`."""
        return self.band(x, centre - factor * std, centre + factor * std, False)
