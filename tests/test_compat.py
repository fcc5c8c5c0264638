"""Patching pytcl: every name, once, and back."""

import sys
from importlib import import_module

import pytest

import trackmetrics
from trackmetrics.compat import pytcl

pytestmark = pytest.mark.peers

PACKAGE = "pytcl.performance_evaluation"


@pytest.fixture
def peer():
    """pytcl's package, its own functions put back afterwards."""
    package = import_module(PACKAGE)
    originals = {name: getattr(package, name) for name in package.__all__}
    yield package, originals
    trackmetrics.unpatch_pytcl()
    assert {name: getattr(package, name) for name in package.__all__} == originals


def holders(name, value):
    """The modules of pytcl in which ``name`` is ``value``."""
    modules = [m for key, m in sys.modules.items() if key.partition(".")[0] == "pytcl"]
    return {m.__name__ for m in modules if vars(m).get(name) is value}


def test_every_module_that_re_exports_is_patched_and_restored(peer):
    package, originals = peer
    for name in package.__all__:
        before = holders(name, originals[name])
        assert {PACKAGE} < before
        trackmetrics.patch_pytcl()
        trackmetrics.patch_pytcl()
        assert holders(name, getattr(trackmetrics, name)) == before
        assert not holders(name, originals[name])
        trackmetrics.unpatch_pytcl()
        trackmetrics.unpatch_pytcl()
        assert holders(name, originals[name]) == before


def test_another_version_is_refused_unless_asked_for(peer, monkeypatch):
    package, originals = peer
    monkeypatch.setattr(import_module("pytcl"), "__version__", "9.9.9")
    with pytest.raises(ImportError, match=r"nrl-tracker 9\.9\.9 has not been compared"):
        trackmetrics.patch_pytcl()
    assert package.ospa is originals["ospa"]
    with pytest.raises(ValueError, match="version must be 'tested' or 'any'"):
        trackmetrics.patch_pytcl(version="all")
    trackmetrics.patch_pytcl(version="any")
    assert package.ospa is trackmetrics.ospa


def test_the_tested_version_is_the_installed_one():
    assert import_module("pytcl").__version__ in pytcl.TESTED_VERSIONS
