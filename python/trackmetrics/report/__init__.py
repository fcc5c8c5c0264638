"""Look, don't read: figures of a diagnosis and of metrics, and one self-contained page.

Needs the extra ``report`` (matplotlib, plotly, Jinja2).
"""

from trackmetrics.report.figures import comparison_figure, overview_figure, track_figure
from trackmetrics.report.page import page, write_page

__all__ = ["comparison_figure", "overview_figure", "page", "track_figure", "write_page"]
