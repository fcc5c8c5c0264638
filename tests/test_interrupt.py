"""Ctrl-C stops a long kernel within a second."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import trackmetrics
from trackmetrics import _native


def slow_costs(n):
    """Products of rising numbers: the longest paths there can be, at every row."""
    return np.arange(1.0, n + 1)[:, None] * np.arange(1.0, n + 1)


def interrupted_after(seconds, call):
    """Seconds from Ctrl-C to the exception."""
    sent = []

    def send():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(seconds, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            call()
        return time.perf_counter() - sent[0]
    finally:
        timer.join()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send to oneself")
def test_the_assignment_of_one_large_matrix():
    costs = slow_costs(3000)
    assert interrupted_after(0.3, lambda: _native.linear_sum_assignment(costs, False)) < 1.0
    pairs = trackmetrics.linear_sum_assignment(costs[:50, :50])
    assert pairs[1].tolist() == list(range(49, -1, -1))


def test_what_a_signal_handler_raises_is_raised():
    class EnoughError(Exception):
        pass

    def handler(*_):
        # The kernel that waits for the answer has put its workspace aside.
        _native.linear_sum_assignment(np.eye(3), False)
        raise EnoughError

    before = signal.signal(signal.SIGINT, handler)
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        with pytest.raises(EnoughError):
            _native.linear_sum_assignment(slow_costs(3000), False)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
