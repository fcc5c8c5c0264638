"""A child forked while other threads change the number of threads computes and never waits."""

import os
import subprocess
import sys

import pytest

ROUNDS = 60
SCRIPT = f"""
import os, random, signal, threading, time
import numpy as np, trackmetrics as tm
X = np.random.default_rng(0).uniform(0, 100, (2000, 8, 2))
work = lambda: tm.ospa_over_time(X, X + 1, c=10)
def set_widths():
    r = random.Random(9)
    while True:
        tm.set_threads(r.choice([0, 2, 3, 7]))
        time.sleep(0.001)
def compute():
    while True:
        work()
expected = work().tobytes()
for target in (set_widths, compute, compute):
    threading.Thread(target=target, daemon=True).start()
failed = []
for _ in range({ROUNDS}):
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        os._exit(0 if work().tobytes() == expected else 7)
    failed += [os.waitpid(child, 0)[1]]
print(set(failed), flush=True)
os._exit(0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_no_child_waits_for_a_lock_of_its_parent():
    command = [sys.executable, "-W", "ignore", "-c", SCRIPT]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout.strip() == "{0}", done.stderr[-500:]
