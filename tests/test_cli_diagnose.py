"""``trackmetrics diagnose``: a log in, verdicts and a page out."""

"""``trackmetrics diagnose``: table, JSON, page, exit status, messages."""

import json

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.diagnostics import EstimatorLog


@pytest.fixture
def logs(tmp_path):
    """Files of an honest and of a dishonest log."""
    draws = np.random.default_rng(3).chisquare(2, 200)
    time = np.arange(200.0)
    late = np.where(time < 150, 1.0, 12.0)
    paths = tmp_path / "honest.jsonl", tmp_path / "late.csv"
    for path, nis in zip(paths, (draws, draws * late), strict=True):
        EstimatorLog.from_columns(time=time, nis=nis, nis_dof=2).write(path)
    return paths


def test_verdicts_and_exit_status(logs, capsys):
    honest, late = map(str, logs)
    assert main(["diagnose", honest, "--check"]) == 0
    assert "consistent" in capsys.readouterr().out
    assert main(["diagnose", late]) == 0
    assert main(["diagnose", late, "--check"]) == 1
    assert "late_divergence" in capsys.readouterr().out


def test_json_is_json(logs, capsys):
    assert main(["diagnose", str(logs[1]), "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["tracks"]["track"]["verdict"] == "late_divergence"


def test_a_page(logs, tmp_path, capsys):
    out = tmp_path / "out.html"
    assert main(["diagnose", str(logs[1]), "--html", str(out), "--title", "Run <7>"]) == 0
    text = out.read_text(encoding="utf-8")
    assert "late divergence" in text
    assert "<h1>Run &lt;7&gt;</h1>" in text


def test_columns_by_other_names(tmp_path, capsys):
    path = tmp_path / "other.csv"
    path.write_text("time,value,df,s,v\n" + "".join(f"{k},2.0,2,1.0,0.1\n" for k in range(9)))
    columns = ["--column", "nis=value", "--column", "nis_dof=df", "--column", "std=s,v"]
    assert main(["diagnose", str(path), *columns, "--states", "x,v"]) == 0
    assert main(["diagnose", str(path), "--column", "nis"]) == 2
    assert "--column must be NAME=SOURCE, got 'nis'" in capsys.readouterr().err


def test_a_missing_file_is_one_line(capsys):
    assert main(["diagnose", "nowhere.csv"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.data
def test_the_published_run(data, tmp_path, capsys):
    columns = {
        "nis": "nis_recovered",
        "nis_dof": "nis_df",
        "std": "std_lat_deg,std_lon_deg,std_sog_kts,std_cog_deg,std_turn_rate",
    }
    flags = [word for item in columns.items() for word in ("--column", "=".join(item))]
    log = str(data / "published_run" / "updates.csv")
    page = tmp_path / "run.html"
    names = ["--states", "lat,lon,sog,cog,turn_rate"]
    assert main(["diagnose", log, *flags, *names, "--html", str(page)]) == 0
    verdicts = [line.split("  ")[:2] for line in capsys.readouterr().out.splitlines()[1:4]]
    assert verdicts[0] == ["SS Northern Star0", "late_divergence"]
    assert verdicts[1][0] == "MV Iron Falcon2"
    assert page.stat().st_size < 3e6
    rng = np.random.default_rng(0)
    honest = rng.chisquare(2, 60)
    late = np.where(np.arange(60) < 40, honest, 9 * honest)
    for name, nis in (("honest", honest), ("late", late)):
        EstimatorLog.from_columns(nis=nis, nis_dof=2).write(tmp_path / f"{name}.jsonl")
    return tmp_path


def test_the_table_has_a_line_and_a_paragraph_a_track(logs, capsys):
    assert main(["diagnose", str(logs / "late.jsonl")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == [
        "track",
        "verdict",
        "NIS",
        "NEES",
        "updates",
        "since",
        "weakest",
        "state",
    ]
    assert lines[1].split()[:4] == ["track", "late_divergence", "late_divergence", "-"]
    assert lines[3].startswith("track: late divergence, it diverges late. NIS:")


def test_json_is_json_and_has_no_nan(logs, capsys):
    assert main(["diagnose", str(logs / "honest.jsonl"), "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["tracks"]["track"]["verdict"] == "consistent"


def test_check_fails_where_a_track_is_not_consistent(logs, capsys):
    assert main(["diagnose", str(logs / "honest.jsonl"), "--check"]) == 0
    assert main(["diagnose", str(logs / "late.jsonl"), "--check"]) == 1


def test_the_page_is_written(logs, capsys):
    page = logs / "page.html"
    assert main(["diagnose", str(logs / "late.jsonl"), "--html", str(page)]) == 0
    assert "late" in page.read_text(encoding="utf-8")


def test_columns_states_and_angles_are_named(tmp_path, capsys):
    path = tmp_path / "foreign.csv"
    rows = "\n".join(f"{k},{k},{350 + k},1,9,{2 * k},{352 + k}" for k in range(9))
    path.write_text(f"t,e,c,s0,s1,te,tc\n{rows}\n")
    arguments = ["--column", "time=t", "--column", "x=e,c", "--column", "std=s0,s1"]
    arguments += ["--column", "truth=te,tc", "--states", "east,course", "--angle", "course=360"]
    assert main(["diagnose", str(path), *arguments]) == 0
    assert "insufficient" in capsys.readouterr().out


def test_bad_input_is_one_line_and_status_2(tmp_path, capsys):
    path = tmp_path / "cut.jsonl"
    path.write_text('{"nis": 1.0, "nis_dof": 2}\n{"nis": 2.0, "ni')
    assert main(["diagnose", str(path)]) == 2
    message = capsys.readouterr().err
    assert message.startswith("trackmetrics diagnose: cut.jsonl, line 2: not a JSON record")
    assert main(["diagnose", str(path), "--column", "nis"]) == 2
    assert "expected NAME=VALUE, got 'nis'" in capsys.readouterr().err
