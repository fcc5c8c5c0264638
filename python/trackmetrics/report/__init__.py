"""Figures of diagnoses, scores and sweeps, and self-contained HTML pages.

Needs the extra ``report`` (matplotlib, plotly, Jinja2); each is imported where it is first used.
"""

from trackmetrics import _deprecated
from trackmetrics.report.diagnosis_figures import comparison_figure, overview_figure, track_figure
from trackmetrics.report.diagnosis_page import render_page, write_page
from trackmetrics.report.score_figures import (
    coverage_figure,
    gospa_figure,
    ospa_figure,
    rmse_figure,
)
from trackmetrics.report.sweep_figures import heatmap_figure, sweep_figure
from trackmetrics.report.sweep_page import render_sweep_page, write_sweep_page

__all__ = [
    "comparison_figure",
    "coverage_figure",
    "gospa_figure",
    "heatmap_figure",
    "ospa_figure",
    "overview_figure",
    "render_page",
    "render_sweep_page",
    "rmse_figure",
    "sweep_figure",
    "track_figure",
    "write_page",
    "write_sweep_page",
]

__getattr__ = _deprecated.module_getattr(__name__)
