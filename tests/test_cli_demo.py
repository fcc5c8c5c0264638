"""The demo: the same numbers for the same seed, with either backend."""

import csv
import io

import pytest

import trackmetrics
from trackmetrics.cli import main

SMALL = ["demo", "--scene", "targets", "--runs", "3", "--targets", "4", "--scans", "30"]


def scores(capsys, *arguments):
    """The printed values by the name of their score."""
    assert main([*SMALL, "--format", "csv", *arguments]) == 0
    rows = csv.DictReader(io.StringIO(capsys.readouterr().out))
    return {row["score"]: row["value"] for row in rows}


def rounded(values):
    """The values, numbers with ten digits."""
    return {k: v if "[" in v else f"{float(v):.10g}" for k, v in values.items()}


def test_both_backends_print_the_same_scores(capsys):
    here = rounded(scores(capsys))
    assert len(here) == 13
    other = "numpy" if trackmetrics.backend() == "native" else "native"
    with trackmetrics.use_backend(other):
        assert rounded(scores(capsys)) == here


def test_the_filter_of_the_demo_is_consistent(capsys):
    values = scores(capsys, "--runs", "6", "--targets", "10", "--scans", "60")
    assert float(values["mean NIS"]) == pytest.approx(2.0, abs=0.15)
    assert float(values["mean NEES"]) == pytest.approx(4.0, abs=0.5)
    assert float(values["OSPA"]) < 20.0


@pytest.mark.parametrize("name", ["runs", "targets", "scans"])
def test_nothing_to_simulate_is_an_error(capsys, name):
    assert main(["demo", "--scene", "targets", f"--{name}", "0"]) == 2
    assert f"--{name} must be at least 1, got 0" in capsys.readouterr().err
