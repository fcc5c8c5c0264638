"""What stands around a sweep: its command, its figures, its page, and the example."""

import importlib.util
import json
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.cli.sweep import parse_grid
from trackmetrics.monte_carlo import ConsistencyAccumulator, sweep
from trackmetrics.report import heatmap_figure, render_sweep_page, sweep_figure
from trackmetrics.report.heatmap_scene import _outline, heatmap_scene
from trackmetrics.report.scene import Line, Rects
from trackmetrics.report.sweep_scenes import sweep_scene

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import monte_carlo_cases as cases  # noqa: E402

NAME = "monte_carlo_cases:consistent"
EXAMPLE = HERE.parent.parent / "examples" / "tune_cv_filter.py"


@pytest.fixture(scope="module")
def two_parameters():
    grid = {"claimed": [0.5, 1.0, 2.0], "steps": [4, 5]}
    return sweep(cases.scaled, 40, seed=1, grid=grid, progress=False)


def test_the_command_prints_each_setting_and_the_best(capsys):
    assert main(["sweep", NAME, "--runs", "80", "--seed", "3", "--grid", "claimed=0.5,1.0,2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:4] == ["claimed", "runs", "nees", "squared_error[0]"]
    assert [line.split()[0] for line in lines[1:4]] == ["0.5", "*", "2"]
    assert lines[5].startswith("* best by |ln anees|: ")
    assert lines[6].endswith(", significant")


def test_the_command_writes_json_parquet_and_a_page(capsys, tmp_path):
    words = [
        "sweep",
        "monte_carlo_cases:failing",
        "--runs",
        "30",
        "--format",
        "json",
        "--keep-going",
    ]
    words += ["--checkpoint", str(tmp_path / "s.ckpt"), "--html", str(tmp_path / "out.html")]
    words += ["--parquet", str(tmp_path / "out.parquet"), "--workers", "2", "--chunk-size", "9"]
    assert main([*words, "--grid", "claimed=1.0"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["settings"]["claimed"] == [1.0]
    assert found["best"]["criterion"] == "|ln anees|"
    assert len(found["failures"]) == found["settings"]["failed"][0] > 0
    assert (tmp_path / "s.ckpt" / "0000.tally").exists()
    assert (tmp_path / "out.parquet").stat().st_size > 0
    assert "runs failed" in (tmp_path / "out.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["consistent"], "expected MODULE:FUNCTION, got 'consistent'"),
        (["no_such_module:f"], "No module named 'no_such_module'"),
        (["monte_carlo_cases:f"], "monte_carlo_cases has no f"),
        ([NAME, "--grid", "claimed"], "--grid expects NAME=VALUE,..., got 'claimed'"),
        ([NAME, "--runs", "0"], "runs must be a whole number, at least 1, got 0"),
        ([NAME, "--runs", "2", "--rank-by", "ospa"], "there is no score 'ospa'"),
    ],
)
def test_the_command_says_what_is_wrong(capsys, words, message):
    assert main(["sweep", *words]) == 2
    assert message in capsys.readouterr().err


def test_values_of_a_grid_are_literals_or_words():
    assert parse_grid(["q=0.01,0.1,1", "motion=cv,ca", "gate=True"]) == {
        "q": [0.01, 0.1, 1],
        "motion": ["cv", "ca"],
        "gate": [True],
    }
    assert parse_grid([]) is None


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("backend", ["matplotlib", "plotly"])
def test_figures_are_drawn_by_both_libraries(two_parameters, backend, dark):
    one = sweep(cases.consistent, 20, seed=1, grid=cases.GRID, progress=False)
    options = {"backend": backend, "dark": dark}
    assert sweep_figure(one, states=["east, m", "north, m"], step=0.5, **options) is not None
    assert heatmap_figure(two_parameters, "claimed", "steps", **options) is not None
    if backend == "matplotlib":
        import matplotlib.pyplot as plt

        plt.close("all")


def test_rows_of_another_kind_are_refused(two_parameters):
    with pytest.raises(ValueError, match="rows must be 'steps' or 'settings', got 'runs'"):
        two_parameters.to_columns("runs")


def test_wrong_figures_are_named(two_parameters):
    one = sweep(cases.consistent, 3, seed=1, progress=False)
    with pytest.raises(ValueError, match="states has 3 names, the filter has 2"):
        sweep_figure(one, states=["a", "b", "c"])
    with pytest.raises(ValueError, match=r"settings must be of the 1 of the grid, got \[1\]"):
        sweep_figure(one, settings=[1])
    with pytest.raises(ValueError, match="the grid has no 'r', it has claimed, steps"):
        heatmap_figure(two_parameters, "claimed", "r")
    with pytest.raises(ValueError, match="there is no score 'ospa', there are nees"):
        heatmap_figure(two_parameters, "claimed", "steps", "ospa")


def test_the_consistent_region_is_outlined(two_parameters):
    (panel,) = heatmap_scene(two_parameters, "claimed", "steps", "nees").panels
    lines = [primitive for primitive in panel.primitives if type(primitive).__name__ == "Line"]
    assert len(lines) == 6  # the column of claimed=1 is one by two cells
    assert len(_outline({(0, 0)})) == 4
    assert len(_outline({(0, 0), (1, 0)})) == 6


def test_the_settings_nearest_to_consistent_are_drawn():
    grid = {"claimed": [8.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.9, 0.8, 0.7, 0.6]}
    result = sweep(cases.consistent, 20, seed=1, grid=grid, progress=False)
    drawn = {
        primitive.name
        for primitive in sweep_scene(result).panels[0].primitives
        if isinstance(primitive, Line)
    }
    assert len(drawn) == 8
    assert drawn.isdisjoint({"claimed=8", "claimed=4"})
    chosen = sweep_scene(result, settings=[0, 5]).panels[0].primitives
    assert {p.name for p in chosen if isinstance(p, Line)} == {
        "claimed=8",
        "claimed=1",
    }


def test_consistent_scores_are_red_above_one_and_blue_below(two_parameters):
    (panel,) = heatmap_scene(two_parameters, "claimed", "steps", "nees").panels
    colours = {float(m.name) > 1: m.colour.partition("/")[0] for m in panel.primitives
               if isinstance(m, Rects)}  # fmt: skip
    assert colours == {True: "high", False: "low"}


def test_a_page_stands_alone():
    result = sweep(cases.consistent, 20, seed=1, grid=cases.GRID, progress=False)
    page = render_sweep_page(result, title="<a & b>", best=result.best("anees"))
    addresses = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            addresses.extend(value for name, value in attrs if name in ("src", "srcset", "href"))

    Reader().feed(page)
    assert addresses
    assert all(address.startswith("data:image/svg+xml") for address in addresses)
    assert "<h1>&lt;a &amp; b&gt;</h1>" in page
    assert page.count("<tr>") == 3
    assert page.count('<tr class="best">') == 1
    assert "is best by |ln anees|" in page


def test_the_example_finds_the_true_process_noise(capsys):
    spec = importlib.util.spec_from_file_location("tune_cv_filter", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    result = example.main(runs=30)
    assert result.best().settings == {"q": 0.1}
    assert "the consistent filter has q = 0.1 (true: 0.1)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"probabilities": 0.5}, "probabilities must be a sequence of numbers, got 0.5"),
        ({"probabilities": ["a"]}, "probabilities must be a real number, got 'a'"),
        ({"angles": {0: "x"}}, r"angles\[0\] must be a real number, got 'x'"),
        ({"angles": {"a": 1.0}}, "angles must be a whole number, got 'a'"),
    ],
)
def test_wrong_options_of_an_accumulator_are_named(options, message):
    with pytest.raises(TypeError, match=f"^{message}$"):
        ConsistencyAccumulator(**options)


def test_wrong_batches_of_an_accumulator_are_named():
    with pytest.raises(TypeError, match="batch must be a mapping of names to arrays, got None"):
        ConsistencyAccumulator().update(None, 0)
    batch = {"truth": np.zeros((1, 1, 1)), "estimates": np.zeros((1, 1, 1))}
    batch["covariances"] = np.ones((1, 1, 1, 1))
    with pytest.raises(ValueError, match="first_run must be a whole number, at least 0, got 'a'"):
        ConsistencyAccumulator().update(batch, "a")


def test_a_page_without_its_libraries_is_refused_before_the_work(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    page = tmp_path / "out.html"
    words = ["sweep", NAME, "--runs", "3", "--html", str(page)]
    monkeypatch.syspath_prepend(str(Path(cases.__file__).parent))
    assert main(words) == 2
    told = capsys.readouterr()
    assert "needs matplotlib, from the extra report" in told.err
    assert not told.out
