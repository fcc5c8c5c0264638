"""``trackmetrics diagnose``: a log in, verdicts and a page out."""

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
