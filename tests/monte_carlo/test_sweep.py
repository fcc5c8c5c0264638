"""Sweeps: the same bytes wherever and however they ran; nothing lost; what is found is right."""

import concurrent.futures
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import trackmetrics
from trackmetrics.monte_carlo import ScoreAccumulator, SweepInterrupted, sweep
from trackmetrics.monte_carlo.jobs import generator

HERE = str(Path(__file__).parent)
sys.path.insert(0, HERE)
import monte_carlo_cases as cases  # noqa: E402 - workers import it by this name

RUNS = 60


def run_cases(*words, **options):
    """A function of the cases in a fresh interpreter."""
    path = os.pathsep.join([HERE, os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, str(Path(HERE) / "monte_carlo_cases.py"), *map(str, words)]
    return subprocess.Popen(
        command,
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        text=True,
        **options,
    )


def cases_say(*words):
    child = run_cases(*words)
    said, _ = child.communicate(timeout=300)
    assert child.returncode == 0
    return json.loads(said)


@pytest.fixture(scope="module")
def whole():
    return sweep(cases.consistent, RUNS, seed=7, grid=cases.GRID, progress=False)


def again(**options):
    return sweep(cases.consistent, RUNS, seed=7, grid=cases.GRID, progress=False, **options)


@pytest.mark.parametrize("chunk", [1, 7, 1000])
def test_the_chunk_does_not_change_a_byte(whole, chunk):
    assert again(chunk=chunk).to_bytes() == whole.to_bytes()


@pytest.mark.parametrize("executor", ["threads", "processes"])
def test_the_executor_does_not_change_a_byte(whole, executor):
    before = trackmetrics.threads()
    assert again(executor=executor, workers=2).to_bytes() == whole.to_bytes()
    assert trackmetrics.threads() == before


def test_an_executor_of_ones_own_stays_open(whole):
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        assert again(executor=pool, chunk=4).to_bytes() == whole.to_bytes()
        assert pool.submit(abs, -1).result() == 1


def test_a_checkpoint_is_gone_on_from(whole, tmp_path):
    path = tmp_path / "s.ckpt"
    first = sweep(
        cases.consistent, 25, seed=7, grid=cases.GRID, progress=False, checkpoint=path, chunk=3
    )
    assert first.completed_runs == [25] * 3
    resumed = again(checkpoint=path, chunk=10)
    assert resumed.to_bytes() == whole.to_bytes()
    told = []
    ended = sweep(
        cases.consistent, RUNS, seed=7, grid=cases.GRID, checkpoint=path,
        progress=lambda *now: told.append(now),
    )  # fmt: skip
    assert told == []
    assert ended.to_bytes() == whole.to_bytes()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seed": 8}, "seed was 7, is 8"),
        ({"grid": {"claimed": [0.5, 1.0, 3.0]}}, "grid was .*'2.0'.* is .*'3.0'"),
        ({"version": "b"}, "version was 'a', is 'b'"),
        ({"simulate": cases.failing}, "simulate was '.*consistent', is '.*failing'"),
        ({"angles": {1: 360.0}}, "angles was None, is"),
        ({"runs": 10}, "the checkpoint already holds 20 runs, more than runs=10"),
    ],
)
def test_a_checkpoint_of_another_sweep_is_refused(tmp_path, changes, message):
    arguments = {"simulate": cases.consistent, "runs": 20, "seed": 7, "grid": cases.GRID}
    arguments |= {"version": "a", "checkpoint": tmp_path / "c", "progress": False}
    sweep(**arguments)
    with pytest.raises(ValueError, match=message):
        sweep(**{**arguments, **changes})


def test_a_checkpoint_of_another_release_or_backend_is_refused(tmp_path):
    arguments = {"seed": 7, "checkpoint": tmp_path / "c", "progress": False}
    sweep(cases.consistent, 5, **arguments)
    header = tmp_path / "c" / "sweep.json"
    header.write_text(header.read_text().replace(trackmetrics.__version__, "0.0.9"))
    with pytest.raises(ValueError, match=r"trackmetrics was '0\.0\.9', is"):
        sweep(cases.consistent, 5, **arguments)
    header.write_text(header.read_text().replace("0.0.9", trackmetrics.__version__))
    ours = trackmetrics.backend()
    other = {"native": "numpy", "numpy": "native"}[ours]
    with (
        trackmetrics.use_backend(other),
        pytest.raises(ValueError, match=f"backend was '{ours}', is '{other}'"),
    ):
        sweep(cases.consistent, 5, **arguments)


def test_what_is_no_checkpoint_is_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ValueError, match="a folder with other things in it"):
        sweep(cases.consistent, 5, seed=1, checkpoint=tmp_path, progress=False)
    with pytest.raises(ValueError, match="is a file, expected a folder or nothing"):
        sweep(cases.consistent, 5, seed=1, checkpoint=tmp_path / "notes.txt", progress=False)


def test_a_damaged_file_is_named(tmp_path):
    arguments = {"seed": 7, "checkpoint": tmp_path / "c", "progress": False}
    whole = sweep(cases.consistent, 30, **arguments)
    file = tmp_path / "c" / "0000.tally"
    file.write_bytes(file.read_bytes()[:-3])
    with pytest.raises(ValueError, match=r"0000\.tally: these bytes are damaged or cut short"):
        sweep(cases.consistent, 30, **arguments)
    file.unlink()
    assert sweep(cases.consistent, 30, **arguments).to_bytes() == whole.to_bytes()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_a_sweep_can_be_killed_at_any_moment(tmp_path):
    done, same = cases_say("kill_at_random_moments", tmp_path / "s.ckpt", 20)
    assert done == sorted(done)
    assert done[-1] > 0
    assert same


def test_memory_does_not_grow_with_the_runs():
    few, many = cases_say("memory", 1_000), cases_say("memory", 100_000)
    assert many < 1.15 * few


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send to a child")
@pytest.mark.parametrize("executor", ["None", "threads", "processes"])
def test_ctrl_c_stops_within_a_second_and_keeps_what_was_done(executor):
    with run_cases("interrupted", executor, start_new_session=True) as child:
        assert child.stdout.readline() == "under way\n"
        start = time.perf_counter()
        os.killpg(child.pid, signal.SIGINT)
        lines = [line for line in child.stdout if line != "under way\n"]
        assert time.perf_counter() - start < 1.0
    assert child.returncode == 0
    word, kept, shape = lines[0].split(maxsplit=2)
    assert (word, shape) == ("kept", "(1, 6)\n")
    assert int(kept) > 20


def test_interrupted_in_this_process():
    def interrupt(done, total):
        if done >= 30:
            raise KeyboardInterrupt

    with pytest.raises(SweepInterrupted, match=r"after 3\d of 300 runs") as stop:
        sweep(cases.consistent, 300, seed=7, chunk=5, progress=interrupt)
    partial = stop.value.result
    assert not partial.complete
    full = sweep(cases.consistent, sum(partial.completed_runs), seed=7, progress=False)
    assert partial.to_bytes() == full.to_bytes()


@pytest.mark.parametrize("options", [{}, {"executor": "processes", "workers": 2}, {"chunk": 3}])
def test_a_run_that_fails_is_recorded_and_the_others_go_on(options):
    result = sweep(
        cases.failing, 80, seed=5, grid=cases.GRID, on_error="collect", progress=False, **options
    )
    diverged = [run for run in range(80) if _diverges(run)]
    indefinite = [run for run in range(80) if run not in diverged and _indefinite(run)]
    for k, settings in enumerate(result.grid):
        found = {f.run: f for f in result.failures if f.settings == settings}
        assert sorted(found) == sorted(diverged + indefinite)
        assert all("ArithmeticError: the filter diverged" in found[r].error for r in diverged)
        assert all("in failing" in found[r].traceback for r in diverged)
        assert all(
            "LinAlgError: covariances[0][0] is not positive definite" in found[r].error
            for r in indefinite
        )
        assert result.consistency[k].runs == 80 - len(found)
    assert result.complete
    assert f"failed={len(result.failures)}" in repr(result)


def _diverges(run):
    rng = generator(5, run)
    cases.consistent(rng)
    return rng.random() < 0.1


def _indefinite(run):
    rng = generator(5, run)
    cases.consistent(rng)
    rng.random()
    return rng.random() < 0.1


@pytest.mark.parametrize("executor", [None, "threads", "processes"])
def test_a_run_that_fails_ends_the_sweep_and_is_named(executor):
    with pytest.raises((ArithmeticError, np.linalg.LinAlgError)) as error:
        sweep(cases.failing, 80, seed=5, grid=cases.GRID, executor=executor, progress=False)
    notes = " ".join(error.value.__notes__)
    assert "in run " in notes
    assert "of seed 5 with claimed=" in notes


@pytest.mark.parametrize(
    ("output", "message"),
    [
        (3.0, "must return a mapping of names, got float"),
        ({}, "returned nothing"),
        ({"x": "far"}, "'x' of type str: expected one of truth, .*, a number, or an accumulator"),
        ({"x": np.zeros(3)}, "'x' of type ndarray: expected one of"),
        ({"truth": np.zeros((3, 2))}, "batch has truth but not estimates and covariances"),
        ({"x": float("inf")}, "x.0. is not finite: inf"),
    ],
)
def test_what_a_run_may_not_return_is_named(output, message):
    with pytest.raises((TypeError, ValueError), match=message):
        sweep(lambda rng: output, 2, seed=1, progress=False)


def test_runs_must_agree_in_what_they_return():
    def simulate(rng):
        return {"a": 1.0} if rng.random() < 0.5 else {"b": 1.0}

    with pytest.raises(ValueError, match=r"names is \[.[ab].\], expected \[.[ab].\]"):
        sweep(simulate, 20, seed=1, chunk=20, progress=False)
    with pytest.raises(ValueError, match="names is"):
        sweep(simulate, 20, seed=1, chunk=1, progress=False)

    def growing(rng):
        steps = 3 + int(rng.random() < 0.5)
        return {
            name: array[:steps]
            for name, array in cases.consistent(rng).items()
            if name != "distance"
        }

    with pytest.raises(ValueError, match=r"has shape \(\d, 2\), that of run 0|other shapes"):
        sweep(growing, 20, seed=1, progress=False)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"runs": 0}, ValueError, "runs must be a whole number, at least 1, got 0"),
        ({"chunk": 0}, ValueError, "chunk must be a whole number"),
        ({"on_error": "ignore"}, ValueError, "on_error must be 'raise' or 'collect', got 'ignore'"),
        ({"executor": "cluster"}, TypeError, "executor must be None, 'threads', 'processes'"),
        ({"grid": {"claimed": []}}, ValueError, r"grid\['claimed'\] is empty"),
        ({"grid": {"claimed": 3.0}}, TypeError, r"grid\['claimed'\] must be a sequence"),
        ({"grid": []}, ValueError, "grid must hold at least one setting"),
        ({"executor": "processes", "simulate": lambda rng: {}}, TypeError, "top of a module"),
    ],
)
def test_wrong_arguments_are_named(arguments, error, message):
    defaults = {"simulate": cases.consistent, "runs": 3, "seed": 1, "progress": False}
    with pytest.raises(error, match=message):
        sweep(**{**defaults, **arguments})


def test_the_random_numbers_of_a_run_belong_to_the_run(whole):
    seen = {}

    def simulate(rng, k):
        seen.setdefault(k, []).append(rng.random())
        return {"x": k}

    sweep(simulate, 5, seed=[1, 2], grid={"k": [0.0, 1.0]}, progress=False)
    expected = [
        np.random.default_rng(np.random.SeedSequence([1, 2], spawn_key=(run,))).random()
        for run in range(5)
    ]
    assert seen == {0.0: expected, 1.0: expected}


def test_a_result_is_what_a_loop_finds(whole):
    runs = [cases.consistent(generator(7, run)) for run in range(RUNS)]
    e = np.array([run["truth"] - run["estimates"] for run in runs])
    q = (e**2).sum(-1)
    assert whole.anees == pytest.approx(q.mean(0) / 2 / np.array([[0.5], [1.0], [2.0]]), rel=1e-12)
    low, high = stats.chi2.ppf([0.025, 0.975], 2 * RUNS) / (2 * RUNS)
    assert whole.anees_interval == pytest.approx([low, high])
    assert whole.rmse == pytest.approx(np.array([np.sqrt((e**2).mean(0))] * 3), rel=1e-12)
    assert whole.rmse_interval.shape == (3, 6, 2, 2)
    assert whole.coverage[0.9][1] == pytest.approx((q <= stats.chi2.ppf(0.9, 2)).mean(0))
    assert whole.scores["distance"] == pytest.approx([np.abs(e).sum((1, 2)).mean()] * 3)
    assert whole.scores["nees"] == pytest.approx(q.mean() / 2 / np.array([0.5, 1.0, 2.0]))
    assert np.isnan(whole.anis[:, ::3]).all()
    assert np.isfinite(whole.anis[:, 1]).all()


def test_tables_are_tidy(whole, tmp_path):
    frame = whole.to_pandas()
    assert len(frame) == 3 * 6
    assert frame["claimed"].tolist() == [0.5] * 6 + [1.0] * 6 + [2.0] * 6
    assert frame["anees"].to_numpy() == pytest.approx(whole.anees.ravel())
    assert frame["rmse_1"].to_numpy() == pytest.approx(whole.rmse[..., 1].ravel())
    whole.to_parquet(tmp_path / "steps.parquet")
    import polars as pl

    read = pl.read_parquet(tmp_path / "steps.parquet")
    assert read.columns == whole.to_polars().columns == list(frame.columns)
    assert read["step"].to_list() == list(range(6)) * 3
    settings = whole.to_polars("settings")
    assert settings["runs"].to_list() == [RUNS] * 3
    assert (settings["nees_low"] < settings["nees"]).all()
    assert whole.to_dict()["settings"]["claimed"] == [0.5, 1.0, 2.0]


def test_the_best_setting_by_consistency(whole):
    best = whole.best()
    assert best.settings == {"claimed": 1.0}
    assert best.interval[0] == 0.0 <= best.value <= best.interval[1]
    assert best.significant
    assert best.difference_interval[0] <= best.difference <= best.difference_interval[1]
    assert best.to_dict()["criterion"] == "|ln anees|"
    assert not whole.best("distance").significant
    assert whole.best("rmse", states=[1]).difference == 0.0
    with pytest.raises(ValueError, match="no score 'ospa', there are nees"):
        whole.best("ospa")
    assert whole.best("nees", maximize=True).settings == {"claimed": 0.5}


def test_paired_differences_are_those_of_the_runs():
    def simulate(rng, offset):
        base = rng.normal(10.0, 5.0)
        return {"x": base + offset + 0.1 * rng.normal() * offset}

    result = sweep(simulate, 200, seed=1, grid={"offset": [0.0, 0.1]}, progress=False)
    best = result.best("x")
    values = np.array([[simulate(generator(1, r), k)["x"] for r in range(200)] for k in (0.0, 0.1)])
    d = values[1] - values[0]
    half = stats.t.ppf(0.975, 199) * d.std(ddof=1) / np.sqrt(200)
    assert best.difference == pytest.approx(d.mean(), rel=1e-9)
    assert best.difference_interval == pytest.approx((d.mean() - half, d.mean() + half))
    assert best.significant
    wide = stats.t.ppf(0.975, 199) * values[0].std(ddof=1) / np.sqrt(200)
    assert best.interval[1] - best.interval[0] == pytest.approx(2 * wide)


def test_accumulators_of_runs_are_merged():
    def simulate(rng):
        inner = ScoreAccumulator()
        inner.update({"y": [rng.random()]}, 0)
        return {"inner": inner, "x": 1.0}

    result = sweep(simulate, 30, seed=2, progress=False)
    expected = np.mean([generator(2, run).random() for run in range(30)])
    assert result["inner"][0]["y"] == pytest.approx(expected)
    assert sweep(simulate, 30, seed=2, chunk=4, progress=False).to_bytes() == result.to_bytes()
    with pytest.raises(KeyError):
        result["outer"]
    with pytest.raises(ValueError, match="no run gave truth"):
        _ = result.anees


def test_a_consistent_filter_lies_in_its_interval_as_often_as_it_should():
    """ANEES of one step over 10 runs, in 2000 small sweeps: 95 % +- 2."""
    inside = 0
    for seed in range(2000):
        result = sweep(_one_step, 10, seed=seed, chunk=10, progress=False)
        low, high = result.anees_interval
        inside += bool(low <= result.anees[0, 0] <= high)
    assert 0.93 <= inside / 2000 <= 0.97


def _one_step(rng):
    return {
        "truth": np.zeros((1, 2)),
        "estimates": rng.normal(size=(1, 2)),
        "covariances": [np.eye(2)],
    }


def test_a_bar_is_shown_where_someone_watches(monkeypatch, capsys):
    told = []
    sweep(cases.consistent, 12, seed=1, chunk=5, progress=lambda *now: told.append(now))
    assert told == [(5, 12), (10, 12), (12, 12)]
    sweep(cases.consistent, 3, seed=1, progress=True)
    assert "run" not in capsys.readouterr().out


def test_workers_bound_what_is_in_flight():
    pending, most, lock = [0], [0], threading.Lock()

    class Counting(concurrent.futures.ThreadPoolExecutor):
        def submit(self, *arguments):
            with lock:
                pending[0] += 1
                most[0] = max(most[0], pending[0])
            future = super().submit(*arguments)
            future.add_done_callback(lambda _: pending.__setitem__(0, pending[0] - 1))
            return future

    with Counting(2) as pool:
        sweep(cases.slow, 100, seed=1, executor=pool, chunk=2, progress=False)
    assert most[0] <= 4


def test_dask_gives_the_same_bytes_though_a_worker_dies(tmp_path):
    import distributed

    arguments = {"seed": 7, "grid": {"folder": [str(tmp_path)], "pid": [os.getpid()]}}
    expected = sweep(cases.once_deadly, 100, progress=False, **arguments)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0",
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip
        found = sweep(cases.once_deadly, 100, executor=client, chunk=5, progress=False, **arguments)
    assert (tmp_path / "killed").exists()
    assert found.to_bytes() == expected.to_bytes()


def test_a_result_can_be_kept(whole):
    assert pickle.loads(pickle.dumps(whole)).to_bytes() == whole.to_bytes()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"simulate": 5}, "simulate must be a function, got int"),
        ({"runs": "a"}, "runs must be a whole number, at least 1, got 'a'"),
        ({"seed": "x"}, "seed must be a whole number, at least 0, or several, got 'x'"),
        ({"seed": -1}, "seed must be a whole number, at least 0, or several, got -1"),
        ({"seed": None}, "seed must be a whole number, at least 0, or several, got None"),
        ({"grid": 5}, "grid must be a mapping of names to values, or settings, got 5"),
        ({"grid": [3]}, r"grid must be a mapping of names to values, or settings, got \[3\]"),
        ({"checkpoint": 5}, "checkpoint must be a path, got 5"),
        ({"angles": [1]}, r"angles must map components to periods, got \[1\]"),
    ],
)
def test_the_wrong_argument_is_named(changes, message):
    arguments = {"simulate": cases.consistent, "runs": 3, "seed": 1, "progress": False} | changes
    with pytest.raises((TypeError, ValueError), match=f"^{message}$"):
        sweep(**arguments)
