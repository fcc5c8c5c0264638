"""Runs other libraries' own tests on our functions.

    python tools/peer_tests.py [PEER ...] [--original]

The tests are taken from the installed distribution into a temporary directory, where the peer's
name is ours; ``--original`` runs them on the peer itself. Exit status 1 where a test fails that is
not in the list of expected failures, or one of that list passes.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path


@dataclass(frozen=True)
class Peer:
    """Where a library's tests are, and how it becomes ours."""

    folders: tuple[str, ...]
    """Folders of the package that are copied; the first holds the tests."""
    replace: str
    """Python that puts our modules under the peer's names."""
    prepare: str = ""
    """Python that gives the tests names that they use and NumPy or pandas no longer have."""
    expected: dict[str, str] = field(default_factory=dict)
    """Tests that fail on our functions, each with its reason."""


PEERS = {
    "motmetrics": Peer(
        folders=("tests", "data"),
        replace="""
import sys
import trackmetrics.compat.motmetrics as ours
from trackmetrics.compat.motmetrics import mot
sys.modules["motmetrics"] = ours
for name in ("distances", "io", "lap", "math_util", "metrics", "mot", "preprocess", "utils"):
    sys.modules["motmetrics." + name] = getattr(ours, name)
""",
        prepare="""
import types
import numpy, pandas, pytest
numpy.asfarray = getattr(numpy, "asfarray", lambda values: numpy.asarray(values, dtype=float))
if not hasattr(pandas.util, "testing"):
    pandas.util.testing = types.SimpleNamespace(
        assert_frame_equal=pandas.testing.assert_frame_equal
    )

@pytest.fixture
def benchmark():
    return lambda function, *arguments: function(*arguments)
""",
        expected={
            "test_mot.py::test_merge_dataframes": (
                "the test writes text into a column of numbers, which pandas 3 refuses"
            )
        },
    )
}

OUTCOME = re.compile(r"^(\S+::.*?) (PASSED|FAILED|ERROR)", re.MULTILINE)


def run(name, peer, original):
    """Outcome of each test."""
    package = Path(find_spec(name).origin).parent
    with tempfile.TemporaryDirectory() as folder:
        for part in peer.folders:
            shutil.copytree(package / part, Path(folder, part))
        tests = Path(folder, peer.folders[0])
        (tests / "__init__.py").unlink(missing_ok=True)
        text = peer.prepare + ("" if original else peer.replace)
        (tests / "conftest.py").write_text(text, encoding="utf-8")
        (tests / "pytest.ini").write_text("[pytest]\n", encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-v", "--tb=short", "-p", "no:cacheprovider"]
        result = subprocess.run([*command, "."], cwd=tests, capture_output=True, text=True)
    found = dict(OUTCOME.findall(result.stdout))
    if not found:
        raise SystemExit(f"{name}: no test ran\n{result.stdout}{result.stderr}")
    return found


def report(name, original):
    """Print the outcomes; whether they are as expected."""
    outcomes, expected = run(name, PEERS[name], original), PEERS[name].expected
    failed = {test for test, outcome in outcomes.items() if outcome != "PASSED"}
    print(f"{name}: {len(outcomes) - len(failed)} of {len(outcomes)} tests pass")
    if original:
        print("\n".join(f"  fails on the original: {test}" for test in sorted(failed)))
        return True
    for test in sorted(failed):
        print(f"  {test}: {expected.get(test, 'NOT EXPECTED')}")
    for test in sorted(expected.keys() - failed):
        print(f"  {test}: passes, but is listed as a failure")
    return failed == expected.keys()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("peers", nargs="*", default=list(PEERS), metavar="PEER")
    parser.add_argument("--original", action="store_true")
    arguments = parser.parse_args()
    results = [report(name, arguments.original) for name in arguments.peers]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
