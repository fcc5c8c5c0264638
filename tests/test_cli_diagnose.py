"""``trackmetrics diagnose``: table, JSON, page, exit status, messages."""

import json

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.logs import EstimatorLog


@pytest.fixture
def logs(tmp_path):
    rng = np.random.default_rng(0)
    consistent = rng.chisquare(2, 60)
    late = np.where(np.arange(60) < 40, consistent, 9 * consistent)
    for name, nis in (("consistent", consistent), ("late", late)):
        EstimatorLog.from_columns(nis=nis, nis_dof=2).write(tmp_path / f"{name}.jsonl")
    return tmp_path


def test_the_table_has_a_line_and_a_paragraph_a_track(logs, capsys):
    assert main(["diagnose", str(logs / "late.jsonl")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:5] == ["track", "verdict", "since", "weakest", "state"]
    assert lines[1].split()[:4] == ["track", "late_divergence", "40", "s"]
    assert lines[3].startswith("track: late divergence")


def test_times_count_from_the_start_of_the_log(tmp_path, capsys):
    rng = np.random.default_rng(0)
    nis = rng.chisquare(2, 60) * np.where(np.arange(60) < 40, 1, 9)
    log = EstimatorLog.from_columns(nis=nis, nis_dof=2, time=1771931555.5 + 10 * np.arange(60))
    log.write(tmp_path / "epoch.jsonl")
    assert main(["diagnose", str(tmp_path / "epoch.jsonl")]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[1].split()[2:4] == ["400", "s"]
    assert out.count("Times count from the start of the log, 2026-02-24 11:12:35 UTC.") == 1
    assert "17719" not in out


def test_json_is_json_and_has_no_nan(logs, capsys):
    assert main(["diagnose", str(logs / "consistent.jsonl"), "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["tracks"]["track"]["verdict"] == "consistent"


def test_check_fails_where_a_track_is_not_consistent(logs, capsys):
    assert main(["diagnose", str(logs / "consistent.jsonl"), "--fail-on-inconsistent"]) == 0
    assert main(["diagnose", str(logs / "late.jsonl"), "--fail-on-inconsistent"]) == 1


def test_the_page_is_written(logs, capsys):
    page = logs / "page.html"
    assert main(["diagnose", str(logs / "late.jsonl"), "--html", str(page)]) == 0
    assert "late" in page.read_text(encoding="utf-8")


def test_columns_states_and_angles_are_named(tmp_path, capsys):
    path = tmp_path / "foreign.csv"
    rows = "\n".join(f"{k},{k},{350 + k},1,9,{2 * k},{352 + k}" for k in range(9))
    path.write_text(f"t,e,c,s0,s1,te,tc\n{rows}\n")
    arguments = ["--rename", "time=t", "--rename", "x=e,c", "--rename", "std=s0,s1"]
    arguments += ["--rename", "truth=te,tc", "--states", "east,course", "--angle", "course=360"]
    assert main(["diagnose", str(path), *arguments]) == 0
    assert "insufficient" in capsys.readouterr().out


def test_bad_input_is_one_line_and_status_2(tmp_path, capsys):
    path = tmp_path / "cut.jsonl"
    path.write_text('{"nis": 1.0, "nis_dof": 2}\n{"nis": 2.0, "ni')
    assert main(["diagnose", str(path)]) == 2
    message = capsys.readouterr().err
    assert message.startswith("trackmetrics diagnose: cut.jsonl, line 2: not a JSON record")
    assert main(["diagnose", str(path), "--rename", "nis"]) == 2
    assert "expected NAME=VALUE, got 'nis'" in capsys.readouterr().err


def test_a_log_without_times_says_how_to_ask_for_row_numbers(tmp_path, capsys):
    path = tmp_path / "log.csv"
    path.write_text("nis,nis_dof\n" + "2,2\n" * 20)
    assert main(["diagnose", str(path)]) == 2
    assert "time='row'" in capsys.readouterr().err
    assert main(["diagnose", str(path), "--time", "row"]) == 0
    assert "consistent" in capsys.readouterr().out


def test_the_options_of_reading_reach_the_log(tmp_path, capsys):
    path = tmp_path / "log.csv"
    rows = [f"01/02/2024 00:00:{k:02d},{k % 3 + 0.5},2" for k in range(30)]
    path.write_text("time,nis,nis_dof\n" + "\n".join(rows) + "\n")
    assert main(["diagnose", str(path)]) == 2
    assert "date_order='dmy'" in capsys.readouterr().err
    assert main(["diagnose", str(path), "--date-order", "dmy", "--format", "csv"]) == 0
