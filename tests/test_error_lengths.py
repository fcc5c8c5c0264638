"""No error message is longer than 300 characters, whatever came in."""

import numpy as np
import pytest

import trackmetrics
from trackmetrics import vessel
from trackmetrics.diagnostics import LiveMonitor, diagnose
from trackmetrics.logs import EstimatorLog, read_log
from trackmetrics.monte_carlo import ConsistencyAccumulator, ScoreAccumulator
from trackmetrics.tracks import read_mot_challenge

LONG = "x" * 5000
WRONG = {
    "text": LONG,
    "list of text": [LONG] * 1000,
    "list of lists": [["a" * 100] * 100] * 100,
    "dictionary": {LONG: [LONG] * 100},
    "ragged": [[1.0] * k for k in range(200)],
    "many axes": np.ones((1,) * 9),
    "huge number": 10**2000,
    "object": np.array([{LONG: LONG}] * 50, object),
    "complex": np.full((100, 100), 1j),
    "bytes": b"y" * 301,
}
FUNCTIONS = {
    **{
        name: getattr(trackmetrics, name)
        for name in (
            *("ospa", "gospa", "ospa_over_time", "gospa_over_time", "ospa2", "trajectory_gospa"),
            *("nees", "nis", "nees_sequence", "rmse", "mot_metrics", "track_purity"),
            *("identity_switches", "covariance_scale", "covariance_test", "hotelling_test"),
            *("correlation_time", "whiteness", "coverage", "pit_test", "anees"),
        )
    },
    "average_nis": lambda a, b: trackmetrics.average_nis(a, dof=b),
    "diagnose": lambda a, b: diagnose(a, alpha=b),
    "from_columns": lambda a, b: EstimatorLog.from_columns(nis=a, nis_dof=b),
    "from_columns S": lambda a, b: EstimatorLog.from_columns(innovation=a, S=b),
    "unknown column": lambda a, _: EstimatorLog.from_columns(**{LONG: a}),
    "states": lambda a, b: EstimatorLog.from_columns(nis=[1.0], nis_dof=2, states=a, angles=b),
    "from_frame": lambda a, _: EstimatorLog.from_frame(a),
    "LiveMonitor": lambda a, b: LiveMonitor(horizon=a, alpha=b),
    "Reports": lambda a, b: vessel.Reports.from_columns(time=a, lat=b, lon=b),
    "Settings": lambda a, b: vessel.Settings(max_speed=a, num_tentative=b),
    "screen_rows": lambda a, _: vessel.screen_rows(
        [{"time": a, "vessel": "1", "lat": a, "lon": a}]
    ),
    "fleet": lambda a, b: vessel.fleet(2, type_shares=a, seed=b),
    "three_ships": lambda a, _: vessel.three_ships(noise=a),
    "ConsistencyAccumulator": lambda a, _: ConsistencyAccumulator(probabilities=a),
    "ScoreAccumulator": lambda a, _: ScoreAccumulator().add_empty_runs(a),
}


def message_of(call):
    """The message of the error that a call ends in; empty if it has none."""
    try:
        call()
    except Exception as error:
        return str(error)
    return ""


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("function", FUNCTIONS)
def test_arguments(function, wrong):
    message = message_of(lambda: FUNCTIONS[function](WRONG[wrong], WRONG[wrong]))
    assert len(message) <= 300, message[:600]


FILES = {
    "one long line": LONG,
    "many headings": ",".join(f"heading_{i}" for i in range(2000)) + "\n" + ",".join("1" * 2000),
    "a long heading": f"time,nis,nis_dof,{LONG}\n0,1,2,3\n0,{LONG},2,3\n",
    "a long value": f"time,nis,nis_dof\n{LONG},1,2\n",
    "a long text": f"time,nis,nis_dof\n0,{LONG},2\n",
    "a long row": "time,nis,nis_dof\n" + ",".join("1" * 3000) + "\n",
    "json": '{"time": 0, "nis": ' + "[" * 300 + "]" * 300 + "}\n",
    "json text": '{"time": 0, "nis": "' + LONG + '", "nis_dof": 2}\n',
    "json keys": "{" + ",".join(f'"key {i}": 1' for i in range(2000)) + "}\n",
    "schema": '{"schema": "' + LONG + '", "states": []}\n',
}


@pytest.mark.parametrize("text", FILES)
@pytest.mark.parametrize("reader", [read_log, vessel.read_ais, read_mot_challenge])
@pytest.mark.parametrize("suffix", [".csv", ".jsonl", ".txt"])
def test_files(tmp_path, monkeypatch, text, reader, suffix):
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"run{suffix}").write_text(FILES[text])
    message = message_of(lambda: reader(f"run{suffix}"))
    assert len(message) <= 300, message[:600]
