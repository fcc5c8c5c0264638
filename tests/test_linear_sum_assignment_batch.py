"""Many assignments at once are the assignments one by one."""

import math
import os
import signal
import threading
import time

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment as scipy_assignment

import trackmetrics
from trackmetrics import _native, _numpy, linear_sum_assignment_batch


@pytest.fixture(params=["native", "numpy"])
def backend(request):
    with trackmetrics.use_backend(request.param):
        yield request.param


@pytest.mark.parametrize(
    "shape", [(1, 4, 4), (30, 7, 5), (30, 5, 7), (0, 3, 4), (5, 0, 3), (5, 3, 0)]
)
@pytest.mark.parametrize("maximize", [False, True])
def test_an_array_of_matrices(backend, shape, maximize):
    costs = np.random.default_rng(2).integers(0, 4, shape).astype(float)
    for form in (costs, costs.astype(int), costs[:, :, ::-1][:, :, ::-1]):
        rows, columns = linear_sum_assignment_batch(form, maximize)
        assert rows.shape == columns.shape == (shape[0], min(shape[1:]))
        assert rows.dtype == columns.dtype == np.int64
        for b, matrix in enumerate(costs):
            expected = scipy_assignment(matrix, maximize)
            np.testing.assert_array_equal([rows[b], columns[b]], expected)


def test_a_ragged_list_of_matrices(backend):
    rng = np.random.default_rng(4)
    matrices = [rng.integers(0, 9, rng.integers(0, 9, 2)).astype(float) for _ in range(50)]
    forms = [matrices, tuple(matrices), [m.astype(int) for m in matrices], iter(matrices)]
    for form in forms:
        found = linear_sum_assignment_batch(form)
        assert type(found) is list
        for pairs, matrix in zip(found, matrices, strict=True):
            np.testing.assert_array_equal(pairs, scipy_assignment(matrix))
    assert linear_sum_assignment_batch([]) == []


def test_threads_change_nothing():
    rng = np.random.default_rng(6)
    costs = rng.integers(0, 5, (2000, 20, 20)).astype(float)
    before = trackmetrics.threads()
    try:
        found = []
        for threads in (1, 2, 5):
            trackmetrics.set_threads(threads)
            found.append(_native.linear_sum_assignment_batch(costs, False))
    finally:
        trackmetrics.set_threads(before)
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])
    for b in range(0, 2000, 97):
        np.testing.assert_array_equal(found[0][1][b], scipy_assignment(costs[b])[1])


@pytest.mark.parametrize(
    ("costs", "text"),
    [
        (np.zeros((2, 2)), r"^costs has shape \(2, 2\), expected \(B, n, m\)$"),
        (
            np.array([[[1.0]], [[math.nan]]]),
            r"^costs\[1\]: matrix contains invalid numeric entries$",
        ),
        ([[[1]], [[math.inf]], [[-math.inf]]], r"^costs\[1\]: cost matrix is infeasible$"),
        ([[[1]], [1]], r"^costs\[1\]: expected a matrix \(2-D array\), got a 1 array$"),
    ],
)
def test_errors_name_the_matrix(backend, costs, text):
    with pytest.raises(ValueError, match=text):
        linear_sum_assignment_batch(costs)


def test_the_first_error_is_named_whichever_thread_meets_it():
    costs = np.random.default_rng(1).random((3000, 20, 20))
    costs[[700, 701, 2900], 3, 3] = math.nan
    text = r"^costs\[700\]: matrix contains invalid numeric entries$"
    for kernels in (_native, _numpy):
        with pytest.raises(ValueError, match=text):
            kernels.linear_sum_assignment_batch(costs if kernels is _native else costs[:702], False)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send to oneself")
@pytest.mark.parametrize("threads", [1, 2])
def test_control_c(threads):
    slow = np.arange(1.0, 601)[:, None] * np.arange(1.0, 601)
    before = trackmetrics.threads()
    trackmetrics.set_threads(threads)
    sent = []

    def send():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            _native.linear_sum_assignment_batch([slow] * 200, False)
        assert time.perf_counter() - sent[0] < 1.0
    finally:
        timer.join()
        trackmetrics.set_threads(before)
