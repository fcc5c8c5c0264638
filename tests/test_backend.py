"""Choosing a backend: by name, for a block, and never in silence."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import trackmetrics
from trackmetrics import _backend, _native, _numpy

ROOT = Path(__file__).parents[1]


def run(code, **environment):
    """Runs ``code`` in a fresh interpreter."""
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("name", ["native", "numpy"])
def test_the_environment_chooses(name):
    done = run("import trackmetrics; print(trackmetrics.backend())", TRACKMETRICS_BACKEND=name)
    assert done.stdout.strip() == name


def test_an_unknown_backend_is_an_error():
    done = run("import trackmetrics", TRACKMETRICS_BACKEND="fortran")
    assert "backend must be one of ['native', 'numpy'], got 'fortran'" in done.stderr
    with pytest.raises(ValueError, match="got 'fortran'"), trackmetrics.use_backend("fortran"):
        pass


WITHOUT_EXTENSION = """
import sys
sys.modules["trackmetrics._native"] = None
import trackmetrics
print(trackmetrics.backend())
"""


def test_a_build_without_an_extension_computes_with_the_references():
    assert run(WITHOUT_EXTENSION, TRACKMETRICS_BACKEND="").stdout.strip() == "numpy"
    asked_for = run(WITHOUT_EXTENSION, TRACKMETRICS_BACKEND="native")
    assert "ModuleNotFoundError" in asked_for.stderr


def test_a_block_ends_where_it_began():
    before = trackmetrics.backend()
    with trackmetrics.use_backend("numpy"):
        assert _backend.kernels is _numpy
        with trackmetrics.use_backend("native"):
            assert _backend.kernels is _native
        assert trackmetrics.backend() == "numpy"
    with pytest.raises(KeyError), trackmetrics.use_backend("numpy"):
        raise KeyError
    assert trackmetrics.backend() == before


def test_an_extension_of_another_build_is_refused(monkeypatch):
    monkeypatch.setattr(_native, "__version__", "0.0.0")
    with (
        pytest.raises(ImportError, match=r"_native is version 0\.0\.0.*install trackmetrics again"),
        trackmetrics.use_backend("native"),
    ):
        pass


def test_the_version_is_the_same_everywhere():
    cargo = tomllib.loads((ROOT / "Cargo.toml").read_text())
    assert cargo["workspace"]["package"]["version"] == trackmetrics.__version__
    assert _native.__version__ == trackmetrics.__version__


def test_importing_the_package_imports_nothing_heavy():
    heavy = "scipy matplotlib plotly pandas polars dask importlib.metadata"
    code = f"import sys, trackmetrics; print([m for m in '{heavy}'.split() if m in sys.modules])"
    numpy_alone = run(code.replace("trackmetrics", "numpy")).stdout
    assert run(code).stdout == numpy_alone


def test_the_number_of_threads_is_a_setting():
    done = run("import trackmetrics; print(trackmetrics.threads())", TRACKMETRICS_THREADS="3")
    assert done.stdout.strip() == ("3" if trackmetrics.backend() == "native" else "1")
    before = trackmetrics.threads()
    try:
        trackmetrics.set_threads(1)
        assert trackmetrics.threads() == 1
    finally:
        trackmetrics.set_threads(before)
    for wrong, error in ((-1, ValueError), (1.5, TypeError)):
        with pytest.raises(error, match="count must be a whole number"):
            trackmetrics.set_threads(wrong)
