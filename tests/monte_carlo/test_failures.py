"""Runs that fail in every way, checkpoints of edited simulations, damaged and forged bytes."""

import importlib.util
import json
import os
import pickle
import struct
import sys
import zlib
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackmetrics.monte_carlo import (
    ConsistencyAccumulator,
    LabelAccumulator,
    PointSetAccumulator,
    ScoreAccumulator,
    sweep,
)
from trackmetrics.monte_carlo.serialization import _FIXED, MAGIC, VERSION
from trackmetrics.monte_carlo.setting_state import SettingState

WHERE = [{}, {"chunk": 1}, {"chunk": 7}, {"executor": "threads", "workers": 2, "chunk": 3}]


def run_of(rng):
    return rng.bit_generator.seed_seq.spawn_key[-1]


class OddError(Exception):
    """Can be pickled, and not unpickled."""

    def __init__(self, first, second):
        super().__init__(first)


class OddAccumulator(ScoreAccumulator):
    kind = "OddAccumulator"

    def __getstate__(self):
        if any(first <= 3 < stop for first, stop in self.intervals):
            raise TypeError("holds a lock")
        return self.__dict__


def misbehaving(rng, how="exit", run=5):
    """Goes wrong in one run, in one way."""
    if run_of(rng) == run:
        if how == "exit":
            sys.exit(0)
        if how == "interrupt":
            raise KeyboardInterrupt
        if how == "kill":
            os.kill(os.getpid(), 9)
        if how == "odd":
            raise OddError(1, 2)
        if how == "shape":
            return _errors(rng, 4)
        if how == "names":
            return {"other": 1.0}
    return _errors(rng, 6)


def _errors(rng, steps):
    e = rng.normal(size=(steps, 2))
    return {"truth": 0 * e, "estimates": e, "covariances": np.tile(np.eye(2), (steps, 1, 1))}


def with_accumulator(rng):
    inner = OddAccumulator()
    inner.update({"y": [rng.random()]}, 0)
    return {"inner": inner}


@pytest.mark.parametrize("options", WHERE)
@pytest.mark.parametrize("run", [0, 5, 19])
@pytest.mark.parametrize("how", ["shape", "names"])
def test_a_run_of_another_shape_is_listed(how, run, options):
    grid = {"how": [how], "run": [run]}
    arguments = {"seed": 1, "grid": grid, "progress": False, "on_error": "collect"}
    result = sweep(misbehaving, 20, **arguments, **options)
    # What the first runs return is right, so that run 0 decides against all others.
    failed = list(range(1, 20)) if run == 0 else [run]
    assert [failure.run for failure in result.failures] == failed
    assert result.to_bytes() == sweep(misbehaving, 20, **arguments).to_bytes()


@pytest.mark.parametrize("executor", [None, "threads", "processes"])
@pytest.mark.parametrize(
    ("how", "error"),
    [
        ("exit", "RuntimeError: simulate called sys.exit(0)"),
        ("interrupt", "RuntimeError: simulate raised KeyboardInterrupt"),
        ("odd", "OddError: 1"),
    ],
)
def test_a_run_that_ends_the_program_only_fails(how, error, executor):
    if how == "interrupt" and executor is None:
        return  # in this process it is the user's
    arguments = {"seed": 1, "grid": {"how": [how]}, "progress": False, "executor": executor}
    result = sweep(misbehaving, 20, on_error="collect", workers=2, **arguments)
    assert [failure.run for failure in result.failures] == [5]
    assert result.failures[0].error.endswith(error)
    assert result.complete
    with pytest.raises((RuntimeError, OddError)) as raised:
        sweep(misbehaving, 20, workers=2, **arguments)
    assert "in run 5 of seed 1" in " ".join(raised.value.__notes__)


def test_a_killed_worker_costs_its_run_only():
    arguments = {"seed": 1, "grid": {"how": ["kill"]}, "progress": False, "workers": 2}
    result = sweep(misbehaving, 30, executor="processes", on_error="collect", **arguments)
    assert [failure.run for failure in result.failures] == [5]
    assert "its worker process died, twice" in result.failures[0].error
    with pytest.raises(RuntimeError, match=r"^run 5 of seed 1 with how='kill': its worker"):
        sweep(misbehaving, 30, executor="processes", **arguments)


def test_an_executor_of_others_cannot_be_restarted():
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.raises(RuntimeError, match="worker of the given executor died"),
    ):
        sweep(misbehaving, 10, seed=1, grid={"how": ["kill"]}, executor=pool, progress=False)


def test_a_result_that_cannot_be_sent_back_is_listed():
    arguments = {"seed": 1, "progress": False, "executor": "processes", "workers": 2}
    result = sweep(with_accumulator, 10, on_error="collect", chunk=4, **arguments)
    assert [failure.run for failure in result.failures] == [3]
    assert "holds a lock" in result.failures[0].error


# ------------------------------------------------------------------ checkpoints


def module_with(tmp_path, text):
    path = tmp_path / "simulation_of_test.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location("simulation_of_test", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["simulation_of_test"] = module
    spec.loader.exec_module(module)
    import linecache

    linecache.checkcache(str(path))
    return module


SOURCE = """
STD = 1.0
def simulate(rng): return {"s": STD * float(rng.normal())}
"""


@pytest.mark.parametrize("edit", [("return", "return  "), ("STD = 1.0", "STD = 2.0")])
def test_an_edited_simulation_is_refused(tmp_path, edit):
    arguments = {"seed": 1, "progress": False, "checkpoint": tmp_path / "c"}
    sweep(module_with(tmp_path, SOURCE).simulate, 5, **arguments)
    assert sweep(module_with(tmp_path, SOURCE).simulate, 8, **arguments).complete
    edited = module_with(tmp_path, SOURCE.replace(*edit)).simulate
    with pytest.raises(ValueError, match="another source of simulation_of_test:simulate") as error:
        sweep(edited, 10, **arguments)
    assert len(str(error.value)) < 300 + len(str(tmp_path))
    source = json.loads((tmp_path / "c" / "sweep.json").read_text())["source"]
    assert f"version='{source}'" in str(error.value)
    assert sweep(edited, 10, version=source, **arguments).complete


def test_a_version_stands_for_the_source(tmp_path):
    arguments = {"seed": 1, "progress": False, "checkpoint": tmp_path / "c", "version": 3}
    sweep(module_with(tmp_path, SOURCE).simulate, 5, **arguments)
    sweep(module_with(tmp_path, SOURCE + "# a remark").simulate, 6, **arguments)
    with pytest.raises(ValueError, match="version was 3, is 4"):
        sweep(module_with(tmp_path, SOURCE).simulate, 7, **(arguments | {"version": 4}))


def test_a_simulation_without_source_is_known_by_its_code(tmp_path):
    for edit, fails in (("", False), ("+ 100", True)):
        space = {"__name__": "nowhere"}
        exec(f"def simulate(rng): return {{'s': float(rng.normal()) {edit}}}", space)
        arguments = {"seed": 1, "progress": False, "checkpoint": tmp_path / "c"}
        if fails:
            with pytest.raises(ValueError, match="another source of nowhere:simulate"):
                sweep(space["simulate"], 10, **arguments)
        else:
            sweep(space["simulate"], 5, **arguments)


def test_a_damaged_header_of_a_checkpoint_is_named(tmp_path):
    arguments = {"seed": 1, "progress": False, "checkpoint": tmp_path / "c"}
    sweep(misbehaving, 3, **arguments)
    for text in ("{", "[]", "[" * 100_000):
        (tmp_path / "c" / "sweep.json").write_text(text)
        with pytest.raises(ValueError, match=r"sweep.json is damaged; give another checkpoint="):
            sweep(misbehaving, 3, **arguments)


# ------------------------------------------------------------------ bytes


def _examples():
    rng = np.random.default_rng(0)
    consistency = ConsistencyAccumulator(angles={1: 360.0})
    errors = [_errors(rng, 3) for _ in range(5)]
    consistency.update({n: np.stack([e[n] for e in errors]) for n in errors[0]}, 2)
    scores = ScoreAccumulator(1)
    scores.update({"a": [1.0, np.nan, 3.0]}, 0)
    labels = LabelAccumulator()
    labels.update({"truth": [1, 2], "misses": [0, 1]}, 0)
    points = PointSetAccumulator(c=10.0)
    points.update({"truth": [[np.zeros((1, 2))]], "estimates": [[np.ones((1, 2))]]}, 0)
    state = sweep(
        misbehaving, 8, seed=1, grid={"how": ["exit"]}, progress=False, on_error="collect"
    ).setting_states[0]
    return [consistency, scores, labels, points, state]


EXAMPLES = _examples()


def forged(content, header_length):
    return MAGIC + _FIXED.pack(VERSION, zlib.crc32(content), header_length) + content


def read(kind, data):
    """Either an accumulator that can be written again, or one clear error."""
    try:
        made = kind.from_bytes(data)
    except ValueError as raised:
        error = str(raised)
    else:
        made.to_bytes()
        return
    assert error.startswith("these bytes")
    assert len(error) < 300


@given(st.data())
@settings(max_examples=300, deadline=2000)
def test_any_bytes_are_read_or_refused(data):
    example = data.draw(st.sampled_from(EXAMPLES))
    raw = bytearray(example.to_bytes())
    start = len(MAGIC) + _FIXED.size
    length = struct.unpack_from("<Q", raw, start - 8)[0]
    # Mostly in the header of JSON, where the sizes are; with a right checksum.
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(start, start + length - 1) | st.integers(start, len(raw) - 1))
        raw[place] = data.draw(st.sampled_from(b'0123456789[]{},-"enull') | st.integers(0, 255))
    stop = data.draw(st.integers(start, len(raw)) | st.just(len(raw)))
    read(type(example), forged(bytes(raw[start:stop]), length))
    read(type(example), bytes(raw[:stop]))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda e: type(e).__name__)
@pytest.mark.parametrize("number", [-1, 2**31, 2**63, 10**30, 1e300, None, "x", [], {}])
def test_forged_numbers_of_a_header_are_refused(example, number):
    raw = example.to_bytes()
    start = len(MAGIC) + _FIXED.size
    length = struct.unpack_from("<Q", raw, start - 8)[0]
    header, body = json.loads(raw[start : start + length]), raw[start + length :]
    for path in _numbers(header):
        changed = json.loads(json.dumps(header))
        place = changed
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = number
        text = json.dumps(changed).encode()
        read(type(example), forged(text + body, len(text)))


def _numbers(value, path=()):
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        if isinstance(item, dict | list):
            yield from _numbers(item, (*path, key))
        elif isinstance(item, int):
            yield (*path, key)


def test_a_small_file_cannot_ask_for_much_memory():
    packed = zlib.compress(bytes(1 << 26), 9)
    arrays = [["nodes", "i8", [1 << 23], len(packed)], ["rows", "f8", [0, 2], 0]]
    inner = {"settings": {}, "shape": {"names": ["s"]}, "skipped": 0, "top": 0}
    header = {"kind": "ScoreAccumulator", "header": inner, "arrays": arrays}
    text = json.dumps(header).encode()
    with pytest.raises(ValueError, match="array nodes would take 67108864 bytes"):
        ScoreAccumulator.from_bytes(forged(text + packed, len(text)))
    arrays[0][2] = [3]
    text = json.dumps(header).encode()
    with pytest.raises(ValueError, match="array nodes has 25 bytes, its shape 24"):
        ScoreAccumulator.from_bytes(forged(text + packed, len(text)))


def test_forged_runs_end_at_once():
    for covered in ([[0, 10**40]], [[5, 3]], [[0, 5], [3, 8]], [[0, 2**63]], "x", [[0]]):
        header = {"kind": "Tally", "cells": [], "failures": [], "covered": covered}
        text = json.dumps(header).encode()
        with pytest.raises(ValueError, match="these bytes are damaged"):
            SettingState.from_bytes(forged(text, len(text)))
    deep = b'{"kind": ' + b"[" * 200_000
    with pytest.raises(ValueError, match="these bytes are damaged"):
        SettingState.from_bytes(forged(deep, len(deep)))


def test_two_merges_of_which_one_fails_change_nothing():
    state, other = EXAMPLES[-1], sweep(misbehaving, 8, seed=1, progress=False, grid={"run": [9]})
    before = state.to_bytes()
    with pytest.raises(ValueError, match="are in both"):
        state.merge(other.setting_states[0])
    assert state.to_bytes() == before
    assert pickle.loads(pickle.dumps(state)).to_bytes() == before


# ------------------------------------------------------------------ arguments


@pytest.mark.parametrize(
    "wrong",
    [
        {"runs": True}, {"runs": 0}, {"runs": "3"}, {"chunk": False}, {"workers": 0.5},
        {"seed": True}, {"seed": []}, {"seed": None}, {"progress": "no"}, {"grid": {1: [2]}},
        {"worker_threads": -1}, {"checkpoint": 5}, {"executor": "process"},
    ],
)  # fmt: skip
def test_wrong_arguments_are_named(wrong):
    arguments = {"runs": 3, "seed": 1, "progress": False, "on_error": "collect"} | wrong
    with pytest.raises((TypeError, ValueError), match=next(iter(wrong))):
        sweep(misbehaving, **arguments)


def test_whole_floats_count():
    assert sweep(misbehaving, 4.0, seed=1, progress=False, chunk=2.0).completed_runs == [4]


def test_a_value_of_the_grid_that_cannot_be_sent_is_named():
    with pytest.raises(TypeError, match="a value of grid cannot be sent"):
        sweep(
            misbehaving, 5, seed=1, progress=False, executor="processes", grid={"how": [lambda: 0]}
        )


def killed_once(rng, folder):
    mark = Path(folder) / "killed"
    if run_of(rng) == 17 and not mark.exists():
        Path(mark).touch()
        os.kill(os.getpid(), 9)
    return {"s": float(rng.normal())}


def test_a_worker_that_the_system_kills_once_loses_nothing(tmp_path):
    arguments = {"seed": 1, "progress": False, "grid": {"folder": [str(tmp_path)]}}
    result = sweep(killed_once, 40, executor="processes", workers=2, chunk=8, **arguments)
    assert result.complete
    assert not result.failures
    assert list(tmp_path.iterdir())
    assert result.to_bytes() == sweep(killed_once, 40, **arguments).to_bytes()


def deadly(rng):
    if run_of(rng) == 1500:
        os.kill(os.getpid(), 9)
    return {"s": float(rng.normal())}


def test_the_run_at_fault_is_found_in_few_steps():
    """Not one job for each of the thousands of runs that were under way."""
    result = sweep(
        deadly, 4000, seed=1, progress=False, executor="processes", workers=2, chunk=1000,
        on_error="collect",
    )  # fmt: skip
    assert [failure.run for failure in result.failures] == [1500]
    assert result.complete
