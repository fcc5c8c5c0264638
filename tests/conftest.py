"""What every test shares: hypothesis profiles, the real recordings, the two backends."""

import os
import signal
from pathlib import Path

import hypothesis
import pytest

hypothesis.settings.register_profile("quick", max_examples=50, deadline=None)
hypothesis.settings.register_profile("ci", max_examples=100, deadline=None, derandomize=True)
hypothesis.settings.register_profile("deep", max_examples=5000, deadline=None)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))

# A shell that runs the tests in its background lets them ignore Ctrl-C, which some of them send.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

_DATA = os.environ.get("TRACKMETRICS_TEST_DATA")


def pytest_collection_modifyitems(config, items):
    """Without the recordings the tests that read them are deselected; in CI that is a failure."""
    if _DATA and Path(_DATA).is_dir():
        return
    marked = [item for item in items if item.get_closest_marker("data")]
    if not marked:
        return
    if os.environ.get("CI"):
        raise pytest.UsageError("TRACKMETRICS_TEST_DATA does not name the folder of recordings")
    config.hook.pytest_deselected(items=marked)
    items[:] = [item for item in items if item not in marked]
    config.get_terminal_writer().line("no TRACKMETRICS_TEST_DATA: tests on recordings deselected")


@pytest.fixture
def data() -> Path:
    """The folder of real recordings and oracle values."""
    return Path(_DATA)
