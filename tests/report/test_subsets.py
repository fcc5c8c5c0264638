"""Scenes, tables and pages of logs with every subset of columns.

A log may hold any of its columns, whole or with gaps; each of them must be drawn.
"""

import itertools

import numpy as np
import pytest

from trackmetrics import report
from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog
from trackmetrics.report.comparison_scene import comparison_scene
from trackmetrics.report.overview_scene import overview_scene
from trackmetrics.report.packing import PackedArrays
from trackmetrics.report.page_tables import (
    first_event,
    quantity_verdicts,
    timeline_bars,
    track_tables,
    update_table,
)
from trackmetrics.report.track_scene import track_scene
from trackmetrics.report.track_view import track_views

UPDATES = 24
_RNG = np.random.default_rng(0)
_X = _RNG.normal(size=(UPDATES, 2))
GROUPS = {
    "nis": {"nis": _RNG.chisquare(2, UPDATES), "nis_dof": np.full(UPDATES, 2.0)},
    "nees": {"nees": _RNG.chisquare(2, UPDATES), "nees_dof": np.full(UPDATES, 2.0)},
    "innovation": {"innovation": _X + 0.1},
    "S": {"S": np.tile(np.eye(2), (UPDATES, 1, 1))},
    "z": {"z": _X + 1},
    "x": {"x": _X},
    "P": {"P": np.tile(np.eye(2), (UPDATES, 1, 1))},
    "std": {"std": np.ones((UPDATES, 2))},
    "truth": {"truth": np.zeros((UPDATES, 2))},
    "error": {"error": _X},
    "measurement_type": {"measurement_type": ["radar", "lidar", None] * (UPDATES // 3)},
}
"""Columns that come together."""
SUBSETS = [
    subset
    for size in range(1, len(GROUPS) + 1)
    for subset in itertools.combinations(GROUPS, size)
    if "nis" in subset
    or "nees" in subset
    or {"innovation", "S"} <= set(subset)
    or ({"P", "error"} <= set(subset) or {"x", "P", "truth"} <= set(subset))
]
"""Every subset that can be diagnosed."""


def log_of(subset, gaps=False):
    """A log of two tracks with these columns; with gaps, a third of each column is missing."""
    columns = {name: values for group in subset for name, values in GROUPS[group].items()}
    if gaps:
        columns = {name: with_gaps(values) for name, values in columns.items()}
        columns["status"] = ["active", "tentative", "active"] * (UPDATES // 3)
    track = np.repeat(["a", "b"], UPDATES // 2)
    time = np.tile(np.arange(UPDATES // 2) * 10.0, 2)
    return EstimatorLog.from_columns(track=track, time=time, states=["east", "north"], **columns)


def with_gaps(values):
    """The same without every third row."""
    if isinstance(values, list) or values.ndim == 3:
        return values
    gaps = np.arange(len(values)) % 3 == 1
    return np.where(gaps.reshape(-1, *[1] * (values.ndim - 1)), np.nan, values)


def draw_scenes(log):
    """Everything that figures and pages are made of, without drawing it."""
    diagnosis = diagnose(log)
    views = track_views(diagnosis, log)
    for view in views:
        arrays = PackedArrays()
        arrays.begin_track()
        assert track_scene(view).panels
        assert update_table(view, arrays)
        assert quantity_verdicts(view)
        for of_track in (timeline_bars, first_event, track_tables):
            of_track(view)
        assert arrays.payload({})
    assert overview_scene(views, "").panels
    assert comparison_scene(views).panels
    return diagnosis


def test_there_are_many_subsets():
    assert len(SUBSETS) > 1500


@pytest.mark.parametrize("first", GROUPS)
def test_every_subset_of_columns_is_drawn(first):
    for subset in SUBSETS:
        if subset[0] == first:
            draw_scenes(log_of(subset))


@pytest.mark.parametrize("group", GROUPS)
def test_columns_with_gaps_are_drawn(group):
    rest = tuple(name for name in GROUPS if name != group)
    for subset in ((group, "nis"), (group, "nees"), rest, tuple(GROUPS)):
        draw_scenes(log_of(tuple(dict.fromkeys(subset)), gaps=True))


@pytest.mark.parametrize(
    "subset",
    [
        ("nis",),
        ("nees",),
        ("x", "P", "truth"),
        ("nis", "x", "measurement_type"),
        ("innovation", "S", "z", "std"),
        ("nees", "error"),
        tuple(GROUPS),
    ],
)
@pytest.mark.parametrize("gaps", [False, True])
def test_figures_and_pages_of_a_sample(subset, gaps):
    log = log_of(subset, gaps)
    diagnosis = draw_scenes(log)
    for backend in ("matplotlib", "plotly"):
        report.track_figure(diagnosis, log, "a", backend=backend)
        report.overview_figure(diagnosis, log, backend=backend)
        report.comparison_figure(diagnosis, log, backend=backend)
    assert "data-0" in report.render_page(diagnosis, log)
