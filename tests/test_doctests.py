"""The examples in the docstrings give what they print."""

import doctest
import importlib
import pkgutil

import pytest

import refimpl

# These import a library that is no dependency of the package.
ELSEWHERE = ("refimpl.experiments.peer_torch", "refimpl.experiments.peer_onnx",
             "refimpl.__main__", "refimpl.adapters.torch", "refimpl.adapters.jax")
MODULES = [m.name for m in pkgutil.walk_packages(refimpl.__path__, "refimpl.")
           if m.name not in ELSEWHERE]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0


def test_an_example_that_lies_is_noticed():
    def lying():
        """
        >>> 1 + 1
        3
        """
    runner = doctest.DocTestRunner(verbose=False)
    for example in doctest.DocTestFinder().find(lying, globs={}):
        runner.run(example, out=lambda text: None)
    assert runner.failures == 1
