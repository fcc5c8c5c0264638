"""Where panels stand: rows of given heights over columns, in pixels."""

from collections.abc import Sequence
from dataclasses import dataclass

from trackmetrics.report.scene import Bounds

LEGEND_COLUMNS = 6
"""Names side by side in a legend."""


@dataclass(frozen=True)
class Frame:
    """The margins of a figure and the gaps between its panels, in pixels."""

    width: float = 1180.0
    left: float = 66.0
    right: float = 18.0
    bottom: float = 50.0
    column_gap: float = 64.0

    def rows(self, top: float, heights: Sequence[float], gap: float) -> list[Bounds]:
        """Panels of the whole width, one under the other."""
        all_bounds = []
        for height in heights:
            all_bounds.append(Bounds(self.left, top, self.width - self.left - self.right, height))
            top += height + gap
        return all_bounds

    def columns(self, top: float, height: float, count: int) -> list[Bounds]:
        """Panels side by side."""
        free = self.width - self.left - self.right - (count - 1) * self.column_gap
        each = free / count
        step = each + self.column_gap
        return [Bounds(self.left + i * step, top, each, height) for i in range(count)]
