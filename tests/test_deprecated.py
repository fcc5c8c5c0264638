"""Old public names keep working and say the new one."""

import subprocess
import sys
import warnings
from importlib import import_module

import pytest

from trackmetrics import _deprecated


def find(name):
    place, _, attribute = name.rpartition(".")
    return getattr(import_module(place), attribute)


@pytest.mark.parametrize(("old", "new"), _deprecated.RENAMED.items())
def test_an_old_name_is_the_new_object_and_says_so(old, new):
    place, _, attribute = old.rpartition(".")
    module = import_module(place)
    with pytest.warns(DeprecationWarning, match=rf"{old} is now {new}"):
        found = getattr(module, attribute)
    assert found is find(new)


def test_an_unknown_name_is_still_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        import_module("trackmetrics.io").nothing  # noqa: B018


def test_a_renamed_parameter_is_passed_on():
    @_deprecated.parameters(level="alpha")
    def function(*, alpha=0.0):
        return alpha

    with pytest.warns(DeprecationWarning, match=r"function\(level=\) is now function\(alpha=\)"):
        assert function(level=0.5) == 0.5
    with pytest.raises(TypeError, match="both 'alpha' and 'level'"):
        function(level=0.5, alpha=0.5)
    assert function(alpha=0.25) == 0.25


def test_a_renamed_attribute_is_readable():
    class Thing:
        new = 3
        old = _deprecated.attribute("new")

    with pytest.warns(DeprecationWarning, match=r"Thing\.old is now Thing\.new"):
        assert Thing().old == 3


def test_no_module_of_the_package_uses_an_old_name():
    """Importing all of it warns of nothing."""
    script = (
        "import warnings; warnings.simplefilter('error', DeprecationWarning)\n"
        "import trackmetrics.cli, trackmetrics.diagnostics, trackmetrics.logs\n"
        "import trackmetrics.monte_carlo, trackmetrics.tracks, trackmetrics.vessel\n"
    )
    with warnings.catch_warnings():
        subprocess.run([sys.executable, "-c", script], check=True)
