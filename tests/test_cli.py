"""What all commands share: formats, widths, exit statuses, messages, old options, completion."""

import csv
import io
import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.cli._commands import COMMANDS
from trackmetrics.cli._renamed_options import OPTIONS, with_new_names
from trackmetrics.cli._table import Column, Table, fitting, to_text
from trackmetrics.cli._verdicts import COLUMNS, diagnosis_table, since
from trackmetrics.diagnostics import Diagnosis, diagnose
from trackmetrics.logs import EstimatorLog
from trackmetrics.logs.formats import suffixes

SWEEP = """
import numpy as np

def simulate(rng, q=1.0):
    x = rng.normal(size=(4, 1))
    return {"truth": np.zeros((4, 1)), "estimates": x, "covariances": np.ones((4, 1, 1))}
"""
BOXES = "1,1,0,0,2,2,1\n1,2,10,0,2,2,1\n2,1,1,0,2,2,1\n"


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with what each command reads."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    late = rng.chisquare(2, 60) * np.where(np.arange(60) < 40, 1, 9)
    nees = rng.chisquare(2, 60) * np.where(np.arange(60) < 20, 1, 9)
    log = EstimatorLog.from_columns(nis=late, nis_dof=2, nees=nees, nees_dof=2, track="a, |b|")
    log.write("late.jsonl")
    (tmp_path / "module_of_a_sweep.py").write_text(SWEEP)
    (tmp_path / "gt.txt").write_text(BOXES)
    rows = [f"{10 * k},1,50.0,{1 + 0.0007 * k},10,90\n" for k in range(100)]
    (tmp_path / "ais.csv").write_text("time,mmsi,lat,lon,sog,cog\n" + "".join(rows))
    return tmp_path


RUNS = {
    "demo": ["demo", "--html", ""],
    "targets": ["demo", "--scene", "targets", "--runs", "2", "--scans", "9"],
    "diagnose": ["diagnose", "late.jsonl"],
    "score": ["score", "gt.txt", "gt.txt"],
    "sweep": ["sweep", "module_of_a_sweep:simulate", "--runs", "1", "--grid", "q=1.0,2.0"],
    "vessel": ["vessel", "ais.csv", "--thin", "30"],
}
"""One call of every command that prints a table."""


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("name", RUNS)
def test_every_format_is_valid_and_nothing_else_is_on_standard_output(name, capsys):
    assert main([*RUNS[name], "--format", "json"]) == 0
    json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert main([*RUNS[name], "--format", "csv"]) == 0
    head, *rows = csv.reader(io.StringIO(capsys.readouterr().out))
    assert rows
    assert {len(row) for row in rows} == {len(head)}
    assert len(set(head)) == len(head)
    assert not any("nan" in row for row in rows)
    assert main([*RUNS[name], "--format", "markdown"]) == 0
    lines = capsys.readouterr().out.splitlines()
    table = [line for line in lines if line.startswith("| ")]
    assert len(table) == len(rows) + 2
    assert {line.replace("\\|", "").count("|") for line in table} == {table[0].count("|")}
    assert main(RUNS[name]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert len(out.splitlines()) >= len(rows) + 1
    assert all(line == line.rstrip() for line in out.splitlines())


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("name", RUNS)
def test_the_result_goes_to_a_file_and_quiet_is_quiet(name, capsys):
    assert main([*RUNS[name], "-o", "result.txt", "-q"]) == 0
    told = capsys.readouterr()
    assert told.out == told.err == ""
    with open("result.txt", encoding="utf-8") as file:
        assert len(file.read().splitlines()) > 1


class Terminal(io.StringIO):
    """Standard output of a terminal."""

    def isatty(self):
        return True


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("width", [80, 200])
def test_a_terminal_has_no_line_that_is_too_long(name, width, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setattr(sys, "stdout", terminal := Terminal())
    assert main([*RUNS[name], "-q"]) == 0
    lines = terminal.getvalue().splitlines()
    assert "\x1b" not in terminal.getvalue()
    assert max(map(len, lines)) <= width


def test_a_wide_terminal_shows_more_columns_and_a_narrow_one_names_those_left_out(
    files, monkeypatch, capsys
):
    shown = {}
    for width in (80, 160):
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setattr(sys, "stdout", terminal := Terminal())
        assert main(RUNS["diagnose"]) == 0
        shown[width] = terminal.getvalue().splitlines()[0]
        told = capsys.readouterr().err
        assert ("--format csv prints every column" in told) == (width == 80)
    assert "NEES" in shown[160]
    assert "NEES" not in shown[80]
    assert "NEES" in told or "NEES" in shown[160]


@pytest.mark.parametrize(
    ("variables", "coloured"),
    [
        ({"TERM": "xterm-256color"}, True),
        ({"TERM": "xterm-256color", "NO_COLOR": "1"}, False),
        ({"TERM": "dumb"}, False),
    ],
)
def test_colour_only_where_it_is_wanted(variables, coloured, monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR", "COLORTERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    table = Table([Column("verdict", str, style=lambda _: "red")], ["biased"])
    assert ("\x1b" in to_text(table, Terminal(), 80)) == coloured
    assert "\x1b" not in to_text(table, io.StringIO(), None)


def test_the_columns_of_the_lowest_ranks_are_kept_in_their_order():
    columns = [Column(name, str, rank=rank) for name, rank in (("a", 2), ("b", 0), ("c", 1))]
    table = Table(columns, ["12345"])
    assert [c.name for c in fitting(table, 12)] == ["b", "c"]
    assert [c.name for c in fitting(table, 3)] == ["b"]
    assert [c.name for c in fitting(table, None)] == ["a", "b", "c"]


@pytest.mark.usefixtures("files")
def test_one_onset_for_one_diagnosis(capsys):
    """The earliest onset of NIS and NEES, whichever command prints it."""
    log = EstimatorLog.from_columns(
        nis=[1.0] * 4, nis_dof=2, nees=[1.0] * 4, nees_dof=2, time=range(4)
    )
    (track,) = diagnose(log).values()
    later = replace(track, nis=replace(track.nis, onset_time=20.0))
    earlier = replace(later, nees=replace(track.nees, onset_time=10.0))
    assert since(later) == "20 s"
    assert since(earlier) == "10 s"
    settled = replace(
        track,
        nis=replace(track.nis, settling_time=3.0),
        nees=replace(track.nees, settling_time=5.0),
    )
    assert since(settled) == "until 5 s"
    table = diagnosis_table(Diagnosis((earlier,)))
    assert table.records()[0]["onset_time"] == 10.0
    main(RUNS["diagnose"])  # its NIS grows after 40 updates, its NEES after 19
    assert " 19 s " in capsys.readouterr().out.splitlines()[1]


def test_every_command_that_diagnoses_prints_the_same_columns(files, capsys):
    heads = {}
    for name in ("demo", "diagnose", "vessel"):
        assert main([*RUNS[name], "--format", "csv"]) == 0
        heads[name] = capsys.readouterr().out.splitlines()[0].split(",")[: len(COLUMNS)]
    assert heads["demo"] == heads["diagnose"] == heads["vessel"]
    assert "nis_scale_settled" in heads["demo"]


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "completion"])
def test_help_has_examples_and_fits(name, capsys):
    assert main([name, "--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "Examples:" in lines
    assert f"  trackmetrics {name} " in "\n".join(lines) or name == "demo"
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize(("name", "written"), [("diagnose", False), ("vessel", True)])
def test_help_names_every_format_of_logs(name, written, capsys):
    assert main([name, "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert suffixes(written=written) in text
    assert "{" not in text


def test_the_help_lists_commands_and_statuses(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    for expected in (*COMMANDS, "Exit statuses", "130  interrupted"):
        assert expected in text
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("trackmetrics ")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["diagnos"], "No such command 'diagnos'"),
        (["diagnose"], "Missing argument 'LOG'"),
        (["diagnose", "no.jsonl"], "no.jsonl: No such file or directory"),
        (["diagnose", "x.csv", "--format", "xml"], "'xml' is not one of"),
        (["score", "a", "b", "--order", "x"], "'x' is not a valid float"),
        (["demo", "--no-such-option"], "--no-such-option"),
    ],
)
def test_bad_input_is_one_line_and_status_2(words, message, capsys):
    assert main(words) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("trackmetrics")
    assert message in told.err
    assert told.err.count("\n") == 1


def test_an_interrupted_command_has_status_130(files, monkeypatch, capsys):
    def interrupt(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("trackmetrics.logs.read_log", interrupt)
    assert main(RUNS["diagnose"]) == 130
    assert capsys.readouterr().err.strip() == "trackmetrics diagnose: interrupted"


@pytest.mark.parametrize("command", OPTIONS)
def test_old_options_are_still_read(command, capsys):
    for old, new in OPTIONS[command].items():
        assert with_new_names(command, [command, old, "7"]) == [command, new, "7"]
        assert with_new_names(command, [command, f"{old}=7"]) == [command, f"{new}=7"]
        assert f"trackmetrics {command}: {old} is now {new}\n" in capsys.readouterr().err
        assert main([command, "--help"]) == 0
        text = capsys.readouterr().out
        assert new in text
        assert f" {old} " not in text


@pytest.mark.usefixtures("files")
def test_old_values_are_still_read(capsys):
    assert main(["vessel", "ais.csv", "--settings", "sea", "--least", "20"]) == 0
    told = capsys.readouterr().err
    for line in ("--settings is now --preset", "--preset sea is now --preset open-sea"):
        assert line in told
    assert main(["demo", "--html", "", "--noise=article"]) == 0
    assert "--noise article is now --noise published" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "_TRACKMETRICS_COMPLETE" in script
    variables = {
        "_TRACKMETRICS_COMPLETE": f"{shell}_complete",
        "COMP_WORDS": "trackmetrics diagnose --fo" if shell != "fish" else "trackmetrics diagnose",
        "COMP_CWORD": "2" if shell != "fish" else "--fo",
    }
    words = [sys.executable, "-c", "from trackmetrics.cli import main; main([])"]
    found = subprocess.run(words, env={**os.environ, **variables}, capture_output=True, text=True)
    assert "--format" in found.stdout


def run_without(library, *arguments):
    """A command in a Python that lacks a library."""
    code = (
        f"import sys; sys.modules[{library!r}] = None\n"
        f"from trackmetrics.cli import main; sys.exit(main({list(arguments)!r}))"
    )
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


def test_without_its_extra_the_command_line_names_it():
    found = run_without("click", "diagnose", "x.jsonl")
    assert found.returncode == 2
    expected = "trackmetrics: needs click, from the extra cli (pip install 'trackmetrics[cli]')\n"
    assert found.stderr == expected


def test_the_package_and_the_help_do_not_import_more_than_they_need():
    code = "import sys, trackmetrics; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert not {"click", "rich", "plotly", "matplotlib"} & set(found.stdout.split())
    code = "import sys; from trackmetrics.cli import main; main(['--help']); print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    loaded = set(found.stdout.splitlines()[-1].split())
    assert not {"rich", "plotly", "trackmetrics.vessel", "trackmetrics.diagnostics"} & loaded
