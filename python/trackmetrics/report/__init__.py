"""Look, don't read: figures of a diagnosis and of scores, and one self-contained page.

Needs the extra ``report`` (matplotlib, plotly, Jinja2), each imported where it is first used.
"""

from trackmetrics.report.diagnosis_figures import comparison_figure, overview_figure, track_figure
from trackmetrics.report.diagnosis_page import page, write_page
from trackmetrics.report.score_figures import (
    coverage_figure,
    gospa_figure,
    ospa_figure,
    rmse_figure,
)

__all__ = [
    "comparison_figure",
    "coverage_figure",
    "gospa_figure",
    "ospa_figure",
    "overview_figure",
    "page",
    "rmse_figure",
    "track_figure",
    "write_page",
]
