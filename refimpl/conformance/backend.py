"""Another implementation: a mapping of operation names to callables, and what it declares of itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import fnmatch
import importlib
import os
import sys

from . import operations_holden, operations_nn, operations_torresani

TOLERANCES = {"float64": 1e-12, "float32": 1e-5}                 # relative to the largest element of the expected array


class BackendError(ValueError):
    """What was named as a backend is none; the message says what was found and what is needed."""


@dataclass(frozen=True)
class Backend:
    """functions : {name: callable}, gradients as name + "_backward";  tolerances : {"float64": ..., "float32": ...};  name : for reports."""

    functions: Mapping = field(repr=False)
    tolerances: Mapping = field(default_factory=lambda: dict(TOLERANCES))
    name: str = "backend"


def reference():
    """The package itself as a backend."""
    functions = {}
    for operation in operations_nn.OPERATIONS + operations_holden.OPERATIONS + operations_torresani.OPERATIONS:
        functions[operation.name] = operation.f
        if operation.backward:
            functions[f"{operation.name}_backward"] = operation.backward
    return Backend(functions, dict(TOLERANCES), "refimpl")


def as_backend(thing, name="backend"):
    """A Backend from a mapping of callables (with an optional key "tolerances"), from a module or object with such attributes, or from a Backend."""
    if isinstance(thing, Backend):
        return thing
    if isinstance(thing, Mapping):
        functions, tolerances = {k: v for k, v in thing.items() if callable(v)}, thing.get("tolerances", {})
    else:
        known = reference().functions
        functions = {k: getattr(thing, k) for k in known if callable(getattr(thing, k, None))}
        tolerances = getattr(thing, "tolerances", {})
    if not isinstance(tolerances, Mapping) or set(tolerances) - set(TOLERANCES) or not all(
            isinstance(t, (int, float)) and t >= 0 for t in tolerances.values()):
        raise BackendError(f"{name}: found tolerances {tolerances!r}, needed numbers from 0 on for {' or '.join(TOLERANCES)}")
    if not set(functions) & set(reference().functions):
        raise BackendError(f"{name}: found no operation among {', '.join(map(str, list(functions)[:8])) or 'nothing callable'}, "
                           f"needed callables named like {', '.join(list(reference().functions)[:4])} ...")
    return Backend(functions, {**TOLERANCES, **tolerances}, name)


def load_backend(words):
    """ "module:object" (or "module" alone) to a Backend; the current folder is searched as well.   Raises BackendError."""
    module, _, attribute = words.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        thing = importlib.import_module(module)
    except ImportError as error:
        raise BackendError(f"{words}: found no module to import ({error}), needed module:object that Python can import from here") from None
    for part in filter(None, attribute.split(".")):
        if not hasattr(thing, part):
            raise BackendError(f"{words}: found no {part!r} in {getattr(thing, '__name__', thing)}, needed module:object")
        thing = getattr(thing, part)
    return as_backend(thing, words)


def read_expected_failures(path):
    """Patterns of case ids that are known to fail, one a line; `#` begins a comment.   ->  list of str"""
    with open(path, encoding="utf-8") as file:
        lines = [line.split("#")[0].strip() for line in file]
    return [line for line in lines if line]


def is_expected_failure(identity, patterns):
    return any(fnmatch.fnmatchcase(identity, pattern) for pattern in patterns)


