"""Every documented function of ``pytcl.performance_evaluation`` is here, under every path."""

import inspect
from importlib import import_module

import pytcl.performance_evaluation as pytcl
import pytest

import trackmetrics

MODULES = ["track_metrics", "estimation_metrics", "mospa"]


@pytest.mark.peers
@pytest.mark.parametrize("name", pytcl.__all__)
def test_the_signature_is_pytcls(name):
    ours, theirs = getattr(trackmetrics, name), getattr(pytcl, name)
    if inspect.isclass(theirs):
        assert ours._fields == theirs._fields
        return
    parameters = list(inspect.signature(ours).parameters.values())
    positional = [(p.name, p.default) for p in parameters if p.kind is not p.KEYWORD_ONLY]
    expected = inspect.signature(theirs).parameters.values()
    assert positional == [(p.name, p.default) for p in expected]


@pytest.mark.peers
@pytest.mark.parametrize("module", MODULES)
def test_pytcls_module_paths_hold_the_same_objects(module):
    ours = import_module(f"trackmetrics.{module}")
    theirs = import_module(f"pytcl.performance_evaluation.{module}")
    names = [n for n in pytcl.__all__ if getattr(theirs, n, None) is getattr(pytcl, n)]
    assert names
    for name in names:
        assert getattr(ours, name) is getattr(trackmetrics, name)


@pytest.mark.parametrize("name", trackmetrics.__all__)
def test_every_public_name_is_documented(name):
    value = getattr(trackmetrics, name)
    assert name == "__version__" or inspect.getdoc(value)
