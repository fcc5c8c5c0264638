"""Draws a scene with one of the two libraries, matplotlib or plotly."""

from typing import Any, Literal

from trackmetrics.report.scene import Scene
from trackmetrics.report.theme import theme

Backend = Literal["matplotlib", "plotly"]


def draw(scene: Scene, backend: str, dark: bool) -> Any:
    """Returns the scene as a figure of the library that ``backend`` names."""
    if backend == "matplotlib":
        from trackmetrics.report import draw_matplotlib

        return draw_matplotlib.draw(scene, theme(dark))
    if backend == "plotly":
        from trackmetrics.report import draw_plotly

        return draw_plotly.draw(scene, theme(dark))
    raise ValueError(f"backend must be 'matplotlib' or 'plotly', got {backend!r}")
