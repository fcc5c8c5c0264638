"""The estimator's log: forms, order, repeated rows, what is computed, files, other libraries."""

import datetime
import json

import numpy as np
import pytest

from trackmetrics.logs import EstimatorLog, State, read_log


def full_log(rows=6, seed=0):
    """Two tracks with every column, angles and measurements of two lengths."""
    rng = np.random.default_rng(seed)
    n = 2 * rows

    def covariance(d):
        a = rng.normal(size=(d, d))
        return a @ a.T + np.eye(d)

    dims = [2 if k % 3 else 1 for k in range(n)]
    return EstimatorLog.from_columns(
        track=["a"] * rows + ["b"] * rows,
        time=[10.0 * k for k in range(rows)] * 2,
        status=(["tentative"] + ["active"] * (rows - 1)) * 2,
        measurement_type=["full" if d == 2 else "part" for d in dims],
        observed=[["east", "course"][:d] for d in dims],
        z=[rng.normal(size=d) for d in dims],
        x_pred=rng.normal(size=(n, 3)),
        P_pred=[covariance(3) for _ in range(n)],
        R=[covariance(d) for d in dims],
        x=rng.normal(size=(n, 3)),
        P=[covariance(3) for _ in range(n)],
        A=rng.normal(size=(n, 3, 3)),
        truth=rng.normal(size=(n, 3)) + 300,
        states=[State("east", "m"), State("course", "deg", 360.0), State("rate", "deg/s")],
    )


def assert_same(a, b):
    assert (a.tracks, a.starts, a.states) == (b.tracks, b.starts, b.states)
    for name in ("time", "nis", "nis_dof", "nees", "z", "S", "P", "A", "error", "innovation"):
        np.testing.assert_array_equal(getattr(a.columns, name), getattr(b.columns, name), name)
    assert list(a.columns.measurement_type) == list(b.columns.measurement_type)


def test_everything_that_follows_is_computed():
    log = full_log()
    c = log.columns
    for k in range(len(log)):
        observed = [i for i in c.observed[k] if i >= 0]
        m = len(observed)
        innovation = c.z[k, :m] - c.x_pred[k, observed]
        s = c.P_pred[k][np.ix_(observed, observed)] + c.R[k, :m, :m]
        error = c.x[k] - c.truth[k]
        error[1] = (error[1] + 180) % 360 - 180
        assert c.nis_dof[k] == m
        np.testing.assert_allclose(c.nis[k], innovation @ np.linalg.solve(s, innovation))
        np.testing.assert_allclose(c.error[k], error)
        np.testing.assert_allclose(c.nees[k], error @ np.linalg.solve(c.P[k], error))
    assert not log.was_logged("nis").any()
    assert log.was_logged("z").all()


def test_logged_values_are_kept():
    log = EstimatorLog.from_columns(
        nis=[9.0, None], innovation=[[1.0], [2.0]], S=[[[1.0]], [[1.0]]]
    )
    assert log.columns.nis.tolist() == [9.0, 4.0]
    assert log.was_logged("nis").tolist() == [True, False]
    assert log.columns.nis_dof.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("ending", ["jsonl", "csv", "parquet"])
def test_a_log_comes_back_from_its_file(tmp_path, ending):
    log = full_log()
    log.write(tmp_path / f"log.{ending}")
    assert_same(read_log(tmp_path / f"log.{ending}"), log)


@pytest.mark.parametrize("library", ["pandas", "polars", "pyarrow"])
def test_a_log_from_a_data_frame(library):
    table = {"who": ["a", "a", "b"], "nis": [1.0, 2.0, 3.0], "df": [2, 2, 4], "s0": [1.0, 2.0, 3.0]}
    module = pytest.importorskip(library)
    frame = module.table(table) if library == "pyarrow" else module.DataFrame(table)
    names = {"track": "who", "nis_dof": "df", "std": ["s0"]}
    with pytest.raises(ValueError, match=r"no column time .*time='row'"):
        EstimatorLog.from_frame(frame, columns=names, states=["s"])
    log = EstimatorLog.from_frame(frame, columns=names, states=["s"], time="row")
    assert log.tracks == ("a", "b")
    assert log["b"].nis_dof.tolist() == [4.0]
    assert log["a"].std.tolist() == [[1.0], [2.0]]


def test_two_updates_at_one_time_are_two_updates():
    log = EstimatorLog.from_columns(
        time=[0, 1, 1, 2], nis=[1.0, 2.0, 3.0, 4.0], nis_dof=[2, 2, 1, 2]
    )
    assert log.columns.time.tolist() == [0.0, 1.0, 1.0, 2.0]
    assert log.columns.nis.tolist() == [1.0, 2.0, 3.0, 4.0]


def test_repeated_rows_are_dropped_and_counted():
    log = EstimatorLog.from_columns(
        track=list("aababb"),
        time=[0, 0, 0, 1, 1, 1],
        nis=[1.0, 1.0, 2.0, 1.0, 3.0, 3.0],
        nis_dof=2,
    )
    assert log["a"].nis.tolist() == [1.0, 1.0]
    assert log["b"].nis.tolist() == [2.0, 3.0]
    assert log.repeated == (1, 1)


def test_a_state_that_stands_still_at_another_time_is_frozen_and_a_nis_is_not():
    frozen = EstimatorLog.from_columns(time=[0, 1, 2], x=[[1.0, 2.0]] * 2 + [[3.0, 2.0]])
    assert frozen.columns.time.tolist() == [0.0, 2.0]
    assert len(EstimatorLog.from_columns(time=[0, 1, 2], nis=[1.0] * 3, nis_dof=2)) == 3


def test_tracks_may_be_interleaved_and_times_default_to_counts():
    log = EstimatorLog.from_columns(track=list("abab"), nis=[1.0, 2.0, 3.0, 4.0], nis_dof=1)
    assert log["a"].nis.tolist() == [1.0, 3.0]
    assert log.columns.time.tolist() == [0.0, 1.0, 0.0, 1.0]
    assert log["b"].row.tolist() == [1, 3]


def test_triangles_and_flat_matrices():
    p = [[[2.0, 0.5], [0.5, 1.0]]]
    for form in (p, [[2.0, 0.5, 1.0]], [[2.0, 0.5, 0.5, 1.0]], np.array(p)):
        log = EstimatorLog.from_columns(error=[[1.0, 1.0]], P=form)
        np.testing.assert_array_equal(log.columns.P, p)


BAD = {
    "empty": ({"nis": [], "nis_dof": 2}, "the log is empty"),
    "NaN row": ({"nis": [1.0, np.nan], "nis_dof": 2}, r"row 1 holds no value \(nis missing\)"),
    "NaN inside a matrix": (
        {"error": [[1.0, 2.0]], "P": [[[1.0, np.nan], [np.nan, 1.0]]]},
        r"P\[0\]\[0\]\[1\] is not finite: nan",
    ),
    "NaN variance": (
        {"error": [[1.0, 2.0]], "P": [[[1.0, 0.0], [0.0, np.nan]]]},
        r"P\[0\]\[1\]\[1\] is not finite: nan",
    ),
    "NaN in a transition": (
        {"x": [[1.0, 2.0]], "A": [[[1.0, np.nan], [np.nan, np.nan]]]},
        r"A\[0\]\[0\]\[1\] is not finite: nan",
    ),
    "infinite": ({"nis": [1.0, np.inf], "nis_dof": 2}, r"nis\[1\] is not finite: inf"),
    "NaN time": (
        {"nis": [1.0, 2.0], "nis_dof": 2, "time": [0.0, np.nan]},
        r"time\[1\] is not finite",
    ),
    "negative": ({"nis": [1.0, -2.0], "nis_dof": 2}, r"nis\[1\] must be at least 0, got -2.0"),
    "no dof": ({"nis": [1.0, 2.0]}, "nis needs its degrees of freedom"),
    "dof 0": ({"nis": [1.0, 2.0], "nis_dof": [2, 0]}, r"nis_dof\[1\] must be positive, got 0.0"),
    "dof missing": ({"nis": [1.0, 2.0], "nis_dof": [2, None]}, r"nis_dof\[1\] is missing"),
    "falling": (
        {"nis": [1.0] * 3, "nis_dof": 2, "time": [0, 2, 1]},
        "row 2 is at 1.0, row 1 at 2.0",
    ),
    "length": ({"nis": [1.0, 2.0], "nis_dof": [2]}, "nis_dof has 1 rows, the log has 2"),
    "state": ({"x": [[1.0]], "angles": {"cog": 360.0}}, r"no state 'cog'; the log has x\[0\]"),
    "observed": ({"x": [[1.0]], "observed": [["cog"]]}, r"observed\[0\]: no state 'cog'"),
    "column": ({"nis": [1.0], "nis_dof": 1, "nus": [1.0]}, "unknown column 'nus'"),
    "status": (
        {"nis": [1.0], "nis_dof": 1, "status": ["lost"]},
        r"status\[0\] must be 'tentative', 'active' or 'rejected', got",
    ),
    "no n": ({"nees": [1.0]}, "nees needs the number of states"),
    "NEES dof 0": ({"nees": [1.0], "nees_dof": 0}, r"nees_dof\[0\] must be positive, got 0.0"),
    "width": ({"x": [[1.0, 2.0]], "state_dim": 1}, r"x\[0\] has 2 components, expected 1"),
    "not symmetric": (
        {"error": [[1.0, 1.0]], "P": [[[1.0, 0.5], [0.4, 1.0]]]},
        r"P\[0\] is not symmetric: elements \[0, 1\] and \[1, 0\] differ",
    ),
    "text": ({"nis": ["high"], "nis_dof": 1}, r"nis\[0\] must be a number, got 'high'"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_columns_are_named(case):
    columns, message = BAD[case]
    with pytest.raises(ValueError, match=message):
        EstimatorLog.from_columns(**columns)


def test_a_covariance_that_is_not_positive_definite_is_named_by_its_row():
    with pytest.raises(np.linalg.LinAlgError, match=r"P\[3\] is not positive definite .*minor 2"):
        EstimatorLog.from_columns(
            track=list("abab"), error=np.ones((4, 2)), P=[np.eye(2)] * 3 + [[1.0, 2.0, 1.0]]
        )


def test_a_truncated_line_is_named(tmp_path):
    path = tmp_path / "cut.jsonl"
    path.write_text('{"nis": 1.0, "nis_dof": 2}\n{"nis": 2.0, "ni')
    with pytest.raises(ValueError, match=r"cut\.jsonl, line 2: not a JSON record.*cut off"):
        read_log(path)


def test_bad_files_are_named(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("nis,nis_dof\n1,2\n3\n")
    with pytest.raises(ValueError, match=r"log\.csv, row 1: 1 cells, the header has 2"):
        read_log(path)
    path.write_text("nis,nis_dof\n1,2\nx,2\n")
    with pytest.raises(ValueError, match=r"log\.csv: nis\[1\] must be a number, got 'x'"):
        read_log(path, time="row")
    path.write_text("time,nis,nis_dof\n")
    with pytest.raises(ValueError, match=r"log\.csv: the log is empty"):
        read_log(path)
    other = tmp_path / "log.jsonl"
    other.write_text(json.dumps({"schema": "another/9", "states": []}) + "\n")
    with pytest.raises(ValueError, match="schema 'another/9', expected 'trackmetrics-log/1'"):
        read_log(other)
    (tmp_path / "log.tab").write_text("time,nis,nis_dof\n0,1,2\n")
    with pytest.raises(ValueError, match=r"path must end in \.jsonl, \.csv, .*got 'log\.tab'"):
        read_log(tmp_path / "log.tab")


@pytest.mark.peers
@pytest.mark.filterwarnings("ignore")
def test_filterpy_savers():
    from filterpy.common import Saver
    from filterpy.kalman import KalmanFilter

    kf = KalmanFilter(dim_x=2, dim_z=1)
    kf.F = np.array([[1.0, 1.0], [0.0, 1.0]])
    kf.H = np.array([[1.0, 0.0]])
    kf.Q, kf.R = 0.1 * np.eye(2), np.array([[2.0]])
    saver, nis = Saver(kf), []
    for k in range(20):
        kf.predict()
        kf.update(np.array([np.sin(k)]) if k != 7 else None)
        saver.save()
        nis.append(kf.y[0, 0] ** 2 / kf.S[0, 0] if k != 7 else np.nan)
    log = EstimatorLog.from_filterpy(
        saver, states=["position", "velocity"], truth=np.zeros((20, 2))
    )
    np.testing.assert_allclose(log.columns.nis, nis)
    np.testing.assert_allclose(log.columns.A[3], (np.eye(2) - saver.K[3] @ kf.H) @ kf.F)
    assert log.columns.status[7] == "tentative"
    assert np.isfinite(log.columns.nees).all()


@pytest.mark.peers
@pytest.mark.filterwarnings("ignore")
def test_stone_soup_tracks():
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import ConstantVelocity
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.detection import Detection
    from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
    from stonesoup.types.hypothesis import SingleHypothesis
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track
    from stonesoup.updater.kalman import KalmanUpdater

    start = datetime.datetime(2026, 1, 1)
    model = LinearGaussian(2, (0,), np.array([[2.0]]))
    predictor, updater = KalmanPredictor(ConstantVelocity(0.1)), KalmanUpdater(model)
    state = GaussianState([[0.0], [1.0]], np.eye(2), timestamp=start)
    track, truth, nis = Track([state]), GroundTruthPath([]), []
    for k in range(1, 8):
        when = start + datetime.timedelta(seconds=5 * k)
        truth.append(GroundTruthState([[k], [1.0]], timestamp=when))
        detection = Detection([[k + 0.3]], timestamp=when, measurement_model=model)
        prediction = predictor.predict(track.state, timestamp=when)
        predicted = updater.predict_measurement(prediction)
        nis.append(float((k + 0.3 - predicted.mean[0, 0]) ** 2 / predicted.covar[0, 0]))
        track.append(updater.update(SingleHypothesis(prediction, detection, predicted)))
    log = EstimatorLog.from_stone_soup([track], truths={track.id: truth}, states=["x", "vx"])
    np.testing.assert_allclose(log.columns.nis, nis)
    assert log.columns.time.tolist() == [5.0 * k for k in range(7)]
    assert set(log.columns.measurement_type) == {"LinearGaussian"}
    assert np.isfinite(log.columns.nees).all()
