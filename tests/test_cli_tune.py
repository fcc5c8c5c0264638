"""``trackmetrics tune``: a row for each noise, and what to change."""

import json

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.logs import EstimatorLog


@pytest.fixture
def path(tmp_path):
    """A random walk whose gauge has four times the variance claimed."""
    rng = np.random.default_rng(0)
    truth = np.cumsum(rng.normal(size=80))
    x, P, rows = 0.0, 10.0, []
    for z in truth + 2 * rng.normal(size=80):
        P_pred, nu = P + 1, z - x
        K = P_pred / (P_pred + 1)
        x, P = x + K * nu, (1 - K) * P_pred
        rows.append(([nu], [[P_pred + 1]], [[P_pred]], [[P]], [[1 - K]], [[1.0]]))
    names = ("innovation", "S", "P_pred", "P", "A", "H")
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    log = EstimatorLog.from_columns(states=["level"], measurement_type=["gauge"] * 80, **columns)
    log.write(tmp_path / "log.jsonl")
    return str(tmp_path / "log.jsonl")


def test_the_table_says_what_to_change(path, capsys):
    assert main(["tune", path]) == 0
    out = capsys.readouterr().out
    assert "process all" in out
    assert "multiply R of gauge by" in out
    assert out.splitlines()[-1] == "change: measurement gauge"


def test_json_holds_the_estimate(path, capsys):
    assert main(["tune", path, "--by", "all", "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["measurement"]["all"]["factor"] == pytest.approx(4, rel=0.6)


def test_a_log_that_is_too_poor_gives_a_direction(tmp_path, capsys):
    nu = np.random.default_rng(0).normal(size=(50, 1))
    EstimatorLog.from_columns(innovation=nu, S=np.ones((50, 1, 1))).write(tmp_path / "poor.jsonl")
    assert main(["tune", str(tmp_path / "poor.jsonl")]) == 0
    assert "Direction: no direction is significant." in capsys.readouterr().out
