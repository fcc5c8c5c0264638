"""Threads and forks: the same bits, and never a hang."""

import multiprocessing
import threading

import numpy as np
import pytest

import trackmetrics as tm
from trackmetrics import _native

RNG = np.random.default_rng(7)
STATES = RNG.normal(size=(200_000, 4))
ESTIMATES = STATES + RNG.normal(size=STATES.shape)
FACTORS = RNG.normal(size=(len(STATES), 4, 4))
COVARIANCES = FACTORS @ FACTORS.transpose(0, 2, 1) + np.eye(4)


def total():
    """A NEES large enough to run in parallel."""
    return tm.nees_sequence(STATES, ESTIMATES, COVARIANCES).sum()


def in_child(queue):
    queue.put(total())


@pytest.fixture
def two_threads():
    """Two threads for a kernel, whatever the machine has."""
    before = _native.threads()
    _native.set_threads(2)
    yield
    _native.set_threads(before)


def test_one_thread_and_two_give_the_same_bits(two_threads):
    with tm.use_backend("native"):
        parallel = tm.nees_sequence(STATES, ESTIMATES, COVARIANCES)
        _native.set_threads(1)
        assert np.array_equal(tm.nees_sequence(STATES, ESTIMATES, COVARIANCES), parallel)


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_forked_child_computes_after_its_parent(two_threads):
    """The parent's pool has no threads in the child: a call there must not wait for them."""
    expected = total()
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    child = context.Process(target=in_child, args=(queue,))
    child.start()
    child.join(timeout=60)
    alive = child.is_alive()
    if alive:
        child.kill()
    assert not alive
    assert queue.get() == expected


def test_many_threads_may_call_at_once(two_threads):
    expected = total()
    results = []
    workers = [threading.Thread(target=lambda: results.append(total())) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(timeout=60)
    assert results == [expected] * 4
