"""The figures: the same scene in both libraries, with labels, units and every update drawn."""

import re

import numpy as np
import pytest

from trackmetrics import report
from trackmetrics.diagnostics import Diagnosis, diagnose
from trackmetrics.logs import EstimatorLog
from trackmetrics.report import draw_plotly, theme
from trackmetrics.report.scene import Points
from trackmetrics.report.track_scene import track_scene
from trackmetrics.report.track_view import track_views

BACKENDS = ("matplotlib", "plotly")


def axes_labels(figure, backend):
    """The x and y labels of a figure of either library."""
    if backend == "matplotlib":
        return [a.get_xlabel() for a in figure.axes], [a.get_ylabel() for a in figure.axes]
    layout = figure.to_dict()["layout"]
    of = lambda axis: [v["title"].get("text") for k, v in layout.items() if k.startswith(axis)]  # noqa: E731
    return of("xaxis"), of("yaxis")


def words_of(figure, backend):
    """Every text in a figure."""
    if backend == "plotly":
        return [a["text"] for a in figure.to_dict()["layout"]["annotations"]]
    texts = [*figure.texts, *(t for a in figure.axes for t in a.texts)]
    return [t.get_text() for t in texts] + [a.get_title(loc="left") for a in figure.axes]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("dark", [False, True])
def test_a_track_shows_everything_with_its_units(small, backend, dark):
    log, diagnosis = small
    figure = report.track_figure(diagnosis, log, "vessel 000", backend=backend, dark=dark)
    x, y = axes_labels(figure, backend)
    assert {"NIS / dof", "NEES / 5", "type", "sog (kt)", "turn_rate (deg/s)"} <= set(y)
    assert y.count("σ / reference") == y.count("error / σ") == 5
    assert "minutes since start, 2023-11-14 22:16:20 UTC" in x
    said = " ".join(words_of(figure, backend))
    for words in ("late divergence", "onset", "alarm", "8.1×", "the weakest state", "observes lat"):
        assert words in said


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_axes_of_consistency_are_logarithmic(small, backend):
    log, diagnosis = small
    figure = report.track_figure(diagnosis, log, "vessel 001", backend=backend)
    if backend == "matplotlib":
        scales = [a.get_yscale() for a in figure.axes[:2]]
    else:
        scales = [figure.layout.yaxis.type, figure.layout.yaxis2.type]
    assert scales == ["log", "log"]


def test_both_libraries_draw_every_update_once(small):
    log, diagnosis = small
    for name in log:
        matplotlib = report.track_figure(diagnosis, log, name)
        plotly = report.track_figure(diagnosis, log, name, backend="plotly")
        rows = log[name]
        wanted = int(np.isfinite(rows.nis).sum())
        nis = [
            line
            for line in matplotlib.axes[0].lines
            if line.get_linestyle() == "None" and line.get_markersize() < 8
        ]
        assert sum(len(line.get_xdata()) for line in nis) == wanted
        of_nis = [t for t in plotly.data if t.yaxis == "y" and t.mode == "markers"]
        assert sum(len(t.x) for t in of_nis if t.name not in ("outlier", "95 % interval")) == wanted


def test_values_and_intervals_are_those_of_the_log(small):
    log, diagnosis = small
    view = track_views(diagnosis, log)[0]
    panel = track_scene(view).panels[0]
    rows = log[view.track.track]
    good = np.isfinite(rows.nis)
    drawn = [m for m in panel.primitives if isinstance(m, Points) and m.name != "outlier"]
    x, y = (np.concatenate(values) for values in zip(*(m.drawn() for m in drawn), strict=True))
    order = np.argsort(x)
    np.testing.assert_allclose(y[order], (rows.nis / rows.nis_dof)[good])
    np.testing.assert_allclose(x[order], (rows.time[good] - log.columns.time.min()) / 60)
    bars = next(m for m in panel.primitives if type(m).__name__ == "ErrorBars")
    four = rows.nis_dof[good] == 4
    np.testing.assert_allclose(bars.high[good][four], 11.143286781877796 / 4)
    np.testing.assert_allclose(bars.low[good][~four], 0.05063561596857975 / 2)


def test_tentative_updates_are_hollow(small):
    log, diagnosis = small
    panels = track_scene(track_views(diagnosis, log)[0]).panels
    hollow = [m for m in panels[1].primitives if isinstance(m, Points) and m.hollow]
    assert sum(len(m.drawn()[0]) for m in hollow) == 2


def test_angles_are_drawn_without_jumps_and_named_within_one_turn(small):
    log, diagnosis = small
    figure = report.track_figure(diagnosis, log, "vessel 000", backend="plotly")
    layout = figure.to_dict()["layout"]
    axis = next(v for v in layout.values() if "cog (deg)" in str(v) and "tickvals" in v)
    assert {"330", "0"} <= set(axis["ticktext"])
    assert all(0 <= float(name) < 360 for name in axis["ticktext"])
    assert axis["range"][1] - axis["range"][0] < 300


def test_a_log_of_nis_alone_and_no_log_at_all(small):
    log, diagnosis = small
    bare = EstimatorLog.from_columns(
        track=["vessel 000"] * 3,
        time=[1.7e9, 1.7e9 + 60, 1.7e9 + 120],
        nis=[1.0, 0.0, 9.0],
        nis_dof=2,
    )
    for given in (bare, None):
        for backend in BACKENDS:
            figure = report.track_figure(diagnosis, given, "vessel 000", backend=backend)
            assert "8.1×" in " ".join(words_of(figure, backend))
    with pytest.raises(KeyError, match="no track 'x'"):
        report.track_figure(diagnosis, log, "x")
    with pytest.raises(ValueError, match="backend must be 'matplotlib' or 'plotly', got 'bokeh'"):
        report.overview_figure(diagnosis, log, backend="bokeh")


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_overview_is_sorted_by_severity(small, backend):
    log, diagnosis = small
    figure = report.overview_figure(diagnosis, log, backend=backend)
    names = [track.track for track in diagnosis.by_severity()]
    if backend == "matplotlib":
        ticks = [t.get_text() for t in figure.axes[0].get_yticklabels()]
        heights = figure.axes[0].get_yticks()
    else:
        ticks, heights = list(figure.layout.yaxis.ticktext), figure.layout.yaxis.tickvals
    assert ticks == names
    assert list(heights) == [-0.0, -1.0, -2.0, -3.0]
    assert "▲ late divergence" in words_of(figure, backend)
    if backend == "plotly":  # which hides words beyond the axis, unless they stand in its domain
        beside = [a for a in figure.layout.annotations if a.xref == "x domain"]
        assert len(beside) == 4
        assert all(a.x > 1 for a in beside)


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_comparison_lists_at_most_eight_tracks(fleet, backend):
    log, diagnosis = fleet
    figure = report.comparison_figure(diagnosis, log, backend=backend)
    if backend == "matplotlib":
        listed = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    else:
        listed = [t.name for t in figure.data if t.showlegend]
    assert listed == [track.track for track in diagnosis.by_severity()[:8]]


def test_an_empty_diagnosis_has_an_overview():
    for backend in BACKENDS:
        report.overview_figure(Diagnosis(()), backend=backend)


def test_figures_do_not_touch_the_state_of_pyplot(small):
    import matplotlib

    before = dict(matplotlib.rcParams)
    report.track_figure(small[1], small[0], "vessel 000")
    assert dict(matplotlib.rcParams) == before


def test_plotly_figures_hold_colours_and_no_roles(small):
    text = report.track_figure(small[1], small[0], "vessel 000", backend="plotly").to_json()
    assert not re.search(r'"@[a-z]', text)
    scene = track_scene(track_views(small[1], small[0])[0])
    roles = set(re.findall(r'"@([a-z0-9-]+)', str(draw_plotly.figure(scene)).replace("'", '"')))
    assert roles <= set(theme.LIGHT.colours)
    assert theme.LIGHT.colours.keys() == theme.DARK.colours.keys()


def test_names_are_shown_as_they_are():
    name = "<b>a & b</b> %{x}"
    log = EstimatorLog.from_columns(track=[name] * 9, nis=[1.0, 2.0, 3.0] * 3, nis_dof=2)
    figure = report.overview_figure(diagnose(log), log, backend="plotly")
    assert list(figure.layout.yaxis.ticktext) == ["&lt;b&gt;a &amp; b&lt;/b&gt; %&#123;x}"]
    assert "<b>a" not in report.render_page(diagnose(log), log)


@pytest.mark.parametrize("backend", BACKENDS)
def test_names_are_neither_roles_nor_formulas(backend):
    for name in ("@ship", "$x_{", "a_b$c$"):
        log = EstimatorLog.from_columns(track=[name] * 9, nis=[1.0, 2.0, 3.0] * 3, nis_dof=2)
        diagnosis = diagnose(log)
        for figure in (
            report.track_figure(diagnosis, log, name, backend=backend),
            report.comparison_figure(diagnosis, log, backend=backend),
        ):
            if backend == "matplotlib":
                figure.canvas.draw()
