"""Figures of OSPA, GOSPA, RMSE and coverage, in both libraries."""

from types import SimpleNamespace

import numpy as np
import pytest

from trackmetrics import ospa, report
from trackmetrics.logs import State
from trackmetrics.report.scene import Band, Line
from trackmetrics.report.score_scenes import gospa_scene

BACKENDS = ("matplotlib", "plotly")


def labels(figure, backend):
    """The x and y labels of a figure that has them, from top to bottom."""
    if backend == "matplotlib":
        x, y = [a.get_xlabel() for a in figure.axes], [a.get_ylabel() for a in figure.axes]
    else:
        layout = figure.to_dict()["layout"]
        x, y = (
            [v["title"]["text"] for k, v in layout.items() if k.startswith(axis)]
            for axis in ("xaxis", "yaxis")
        )
    return [text for text in x if text], y


def listed(figure, backend):
    """The names in the legend."""
    if backend == "plotly":
        return [t.name for t in figure.data if t.showlegend]
    return [t.get_text() for a in figure.axes if a.get_legend() for t in a.get_legend().get_texts()]


def gospa(steps=6):
    """A sequence whose parts are known."""
    parts = {"localization": np.arange(1.0, steps + 1), "missed": np.full(steps, 2.0)}
    parts["false"] = np.where(np.arange(steps) == 3, 2.0, 0.0)
    return SimpleNamespace(distance=np.sqrt(sum(parts.values())), **parts)


@pytest.mark.parametrize("backend", BACKENDS)
def test_ospa(backend):
    results = [ospa([[0.0, 0.0]], [[0.5 * k, 0.0]], c=10, p=2) for k in range(4)]
    figure = report.ospa_figure(results, times=[5, 65, 125, 185], backend=backend, unit="km")
    assert labels(figure, backend) == (["minutes since start"], ["OSPA (km)", "parts (km)"])
    assert listed(figure, backend) == ["localization", "cardinality"]
    line = figure.axes[0].lines[0] if backend == "matplotlib" else figure.data[0]
    x, y = (line.get_xdata(), line.get_ydata()) if backend == "matplotlib" else (line.x, line.y)
    assert list(x) == [0, 1, 2, 3]
    assert list(y) == [0, 0.5, 1, 1.5]
    steps = report.ospa_figure(results, backend=backend)
    assert labels(steps, backend)[0] == ["frame"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_gospa(backend):
    figure = report.gospa_figure(gospa(), backend=backend, dark=True)
    assert labels(figure, backend) == (["frame"], ["GOSPA (m)", "parts (m²)"])
    assert listed(figure, backend) == ["localization", "missed", "false"]


def test_the_parts_of_gospa_stand_on_each_other():
    scene = gospa_scene(gospa(), None, "m", 2.0, "")
    bands = [primitive for primitive in scene.panels[1].primitives if isinstance(primitive, Band)]
    np.testing.assert_allclose(bands[1].low, bands[0].high)
    np.testing.assert_allclose(bands[2].low, bands[1].high)
    np.testing.assert_allclose(np.sqrt(bands[2].high), gospa().distance)
    each = [SimpleNamespace(distance=2.0, localization=4.0, missed=0.0, false=0.0)] * 3
    assert len(gospa_scene(each, None, "m", 2.0, "").panels[0].primitives[0].y) == 3


@pytest.mark.parametrize("backend", BACKENDS)
def test_rmse(backend):
    rmse = np.array([[1.0, 0.1], [2.0, 0.2], [1.5, 0.3]])
    statistics = SimpleNamespace(
        rmse=rmse,
        rmse_interval=np.stack([0.9 * rmse, 1.2 * rmse], -1),
        runs=np.array([40, 50, 50]),
        confidence=0.9,
    )
    states = [State("x", "m"), "gain"]
    figure = report.rmse_figure(statistics, states=states, times=[0, 6, 12], backend=backend)
    assert labels(figure, backend) == (["minutes since start"], ["x (m)", "gain"])
    assert listed(figure, backend) == ["90 % interval", "RMSE"]
    with pytest.raises(ValueError, match="states has 1 names, the RMSE has 2 components"):
        report.rmse_figure(statistics, states=["x"], backend=backend)
    with pytest.raises(ValueError, match="times has 2 steps, the results have 3"):
        report.rmse_figure(statistics, states=states, times=[0, 1], backend=backend)


@pytest.mark.parametrize("backend", BACKENDS)
def test_coverage(backend):
    p = np.arange(1, 100) / 100
    curve = SimpleNamespace(probability=p, share=p**1.2, lower=p - 0.1, upper=p + 0.1, count=300)
    figure = report.coverage_figure(curve, backend=backend)
    wanted = (["nominal probability"], ["fraction of errors inside"])
    assert labels(figure, backend) == wanted
    assert listed(figure, backend) == ["interval", "consistent", "observed"]


def test_lines_keep_their_gaps():
    results = gospa()
    results.distance[2] = np.nan
    scene = gospa_scene(results, None, "m", 2.0, "")
    (line,) = [primitive for primitive in scene.panels[0].primitives if isinstance(primitive, Line)]
    assert np.isnan(line.y[2])
    for backend in BACKENDS:
        report.gospa_figure(results, backend=backend)
