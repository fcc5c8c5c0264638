"""The two backends have the same kernels: names, parameters, order, documentation."""

import inspect

import pytest

from trackmetrics import _native, _numpy

KERNELS = sorted(name for name in dir(_native) if not name.startswith("_"))


def test_every_kernel_has_a_reference_and_every_reference_a_kernel():
    assert sorted(name for name in _numpy.__all__ if not name.startswith("_")) == KERNELS


@pytest.mark.parametrize("name", KERNELS)
def test_parameters_are_the_same(name):
    kernel = inspect.signature(getattr(_native, name))
    reference = inspect.signature(getattr(_numpy, name))
    assert [(p.name, p.kind.name, p.default) for p in kernel.parameters.values()] == [
        (p.name, p.kind.name, p.default) for p in reference.parameters.values()
    ]


@pytest.mark.parametrize("name", KERNELS)
def test_both_are_documented(name):
    assert getattr(_native, name).__doc__
    assert getattr(_numpy, name).__doc__
