"""The demo: the same numbers for the same seed, with either backend."""

import re

import pytest

import trackmetrics
from trackmetrics.cli import main

SMALL = [
    "demo",
    "--scene",
    "targets",
    "--runs",
    "3",
    "--targets",
    "4",
    "--scans",
    "30",
    "--seed",
    "5",
]


def table(capsys):
    """The lines of the table without their times: name, value and meaning."""
    lines = capsys.readouterr().out.splitlines()
    return [re.sub(r"\s+[\d.]+ ms\s+", "  ", line) for line in lines[2:-2]]


def test_both_backends_print_the_same_scores(capsys):
    assert main(SMALL) == 0
    here = table(capsys)
    assert len(here) == 13
    assert here[0].startswith("OSPA")
    other = "numpy" if trackmetrics.backend() == "native" else "native"
    with trackmetrics.use_backend(other):
        assert main(SMALL) == 0
    assert table(capsys) == here


def test_the_filter_of_the_demo_is_honest(capsys):
    main(["demo", "--scene", "targets", "--runs", "6", "--scans", "60"])
    values = {line[:18].strip(): line[18:].split() for line in table(capsys)}
    assert float(values["mean NIS"][0]) == pytest.approx(2.0, abs=0.15)
    assert float(values["mean NEES"][0]) == pytest.approx(4.0, abs=0.5)
    assert float(values["OSPA"][0]) < 20.0


@pytest.mark.parametrize("name", ["runs", "targets", "scans"])
def test_nothing_to_simulate_is_said(capsys, name):
    assert main(["demo", "--scene", "targets", f"--{name}", "0"]) == 2
    assert f"--{name} must be at least 1, got 0" in capsys.readouterr().err
