"""Another implementation: a mapping of operation names to callables, and what it declares of
itself."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
import difflib
import fnmatch
import importlib
import inspect
import itertools
import os
import sys
from typing import Any

from . import (operations_2016, operations_holden, operations_nn, operations_phrases,
               operations_rotation, operations_torresani, operations_transfer, operations_whole)
from .capabilities import mistake
from .specification import as_tuple

OPERATIONS = {operation.name: operation for operation in (
    operations_nn.OPERATIONS + operations_holden.OPERATIONS + operations_2016.OPERATIONS
    + operations_torresani.OPERATIONS + operations_phrases.OPERATIONS
    + operations_transfer.OPERATIONS + operations_rotation.OPERATIONS
    + operations_whole.OPERATIONS)}
TOLERANCES = {"float64": 1e-12, "float32": 2e-6}     # of what an element sums (`yardstick`)
# what a backend says of itself, beside functions
DECLARED = "tolerances", "lacks"
MOST = 1000                        # names that a backend may have; there may be no end of them
LOOSEST = 0.1                      # that a backend may declare; beyond it nothing is judged


class BackendError(ValueError):
    """What was named as a backend is none; the message says what was found and what is needed."""


class NoAnswer(Exception):
    """A backend's function raised something, or tried to leave the program, instead of
    answering."""

    def __init__(self, error: BaseException):
        self.error = error
        super().__init__(f"raised {type(error).__name__}: {words_of(error)}")


@dataclass(frozen=True)
class Backend:
    """Another implementation.

    functions : {name: callable}, gradients as name + "_backward";  tolerances : {"float64": ...,
    "float32": ...};  name : for reports;  unknown : ((name, nearest known name or ""), ...), what
    it offers that is no operation;  loaded : whether `load_backend(name)` finds it again
    lacks : what it says that it has not (`capabilities`)
    """

    functions: Mapping[str, Callable] = field(repr=False)
    tolerances: Mapping[str, float] = field(default_factory=lambda: dict(TOLERANCES))
    name: str = "backend"
    unknown: tuple[tuple[str, str], ...] = ()
    loaded: bool = False
    lacks: tuple[str, ...] = ()


def reference() -> Backend:
    """The package itself as a backend.

    >>> sorted(name for name in reference().functions if name.startswith("gram"))
    ['gram', 'gram_backward']
    """
    functions = {}
    for operation in OPERATIONS.values():
        functions[operation.name] = operation.f
        if operation.backward:
            functions[f"{operation.name}_backward"] = operation.backward
    return Backend(functions, dict(TOLERANCES), "refimpl")


def ask(function: Callable, arguments: Iterable, attributes: Mapping) -> tuple:
    """Call a backend's function.   ->  its outputs as a tuple of arrays (None where there is none)

    Raises NoAnswer for whatever it raises, `sys.exit` included: a backend may end a call, never the
    judge. Only Ctrl-C goes through.
    """
    try:
        return as_tuple(function(*arguments, **attributes))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise NoAnswer(error) from None


def words_of(error: BaseException) -> str:
    """An error's own words in one line of at most 300 characters, even if it cannot tell them."""
    try:
        return " ".join(str(error).split())[:300]
    except BaseException as other:
        return f"(its words cannot be read: {type(other).__name__})"


def nearest(name: str, known: Iterable[str]) -> str:
    """The known name that a misspelt one is likely to mean, "" when none is near.

    >>> nearest("conv1d_bakward", ["conv1d", "conv1d_backward", "gram"])
    'conv1d_backward'
    """
    lower = {k.lower().replace("_", ""): k for k in known}
    found = difflib.get_close_matches(name.lower().replace("_", "").replace(" ", ""), lower, 1, 0.6)
    return lower[found[0]] if found else ""


def meant(name: str, known: Iterable[str]) -> str:
    """The end of a message: "; do you mean gram?" where a known name is near, else "".

    >>> meant("Gram", ["gram", "relu"])
    '; do you mean gram?'
    """
    near = nearest(name, known)
    return f"; do you mean {near}?" if near else ""


def as_backend(thing: Any, name: str = "backend", loaded: bool = False) -> Backend:
    """A Backend from a mapping of callables, from a module or object with such attributes, or from
    a Backend.

    A key (or attribute) "tolerances" may declare its own bounds, {"float32": 1e-4}, at most 0.1;
    "lacks" what it has not, ["float64", "avg_pool1d ceil_mode"].
    Names that are no operation are kept in `unknown`.   Raises BackendError.
    """
    if isinstance(thing, Backend):
        return thing
    known = reference().functions
    try:
        if isinstance(thing, Mapping):
            offered = {str(key): thing[key] for key in itertools.islice(thing, MOST + 1)}
            if len(offered) > MOST:
                raise BackendError(f"{name}: found more than {MOST} names, needed a mapping of "
                                   "operation names to callables")
            unknown = [key for key in offered if key not in known and key not in DECLARED]
        elif isinstance(thing, (str, bytes, int, float, list, tuple, set)) or thing is None:
            raise BackendError(f"{name}: found {type(thing).__name__}, needed a mapping of "
                               "operation names to callables, or a module with such functions")
        else:
            offered = {key: getattr(thing, key) for key in [*known, *DECLARED]
                       if hasattr(thing, key)}
            unknown = [key for key in dir(thing) if key not in known and key[:1] != "_"
                       and difflib.get_close_matches(
                           key, [k for k in known if k not in offered], 1, 0.85)]
    except (BackendError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise BackendError(f"{name}: found something that cannot be read ({type(error).__name__}: "
                           f"{words_of(error)}), needed a mapping of operation names to "
                           "callables") from None
    tolerances = _tolerances(name, offered.pop("tolerances", {}))
    lacks = offered.pop("lacks", ())
    wrong = mistake(lacks, known, _arguments()) if lacks != () else ""
    if wrong:
        raise BackendError(f"{name}: {wrong}")
    functions = {key: value for key, value in offered.items() if key in known}
    for key, value in functions.items():
        if not callable(value):
            raise BackendError(f"{name}: found {key} of type {type(value).__name__}, needed a "
                               "callable")
    misspelt = tuple((key, nearest(key, [*known, *DECLARED])) for key in unknown)
    if not functions:
        meant = [f"{key!r} (do you mean {near}?)" if near else repr(key)
                 for key, near in misspelt[:8]]
        raise BackendError(f"{name}: found no operation among "
                           f"{', '.join(meant) or 'nothing callable'}, needed callables named like "
                           f"{', '.join(list(known)[:4])} ...")
    return Backend(functions, {**TOLERANCES, **tolerances}, name, misspelt, loaded,
                   tuple(map(str, lacks)))


def _arguments():
    """Names of the arguments and options.   ->  {function: list of str}"""
    found = {}
    for operation in OPERATIONS.values():
        options = [p.name for p in inspect.signature(operation.f).parameters.values()
                   if p.kind is not p.VAR_POSITIONAL and p.name not in operation.arguments]
        for function in (operation.name, f"{operation.name}_backward"):
            found[function] = [*operation.arguments, *options]
    return found


def _tolerances(name, declared):
    """Checked: a number from 0 to LOOSEST for each precision."""
    good = isinstance(declared, Mapping) and set(declared) <= set(TOLERANCES) and all(
        isinstance(t, (int, float)) and not isinstance(t, bool) and 0 <= t <= LOOSEST
        for t in declared.values())
    if not good:
        raise BackendError(f"{name}: found tolerances {repr(declared)[:200]}, needed numbers from "
                           f"0 to {LOOSEST} for {' or '.join(TOLERANCES)}, relative to the largest "
                           "element; beyond that nothing would be judged")
    return dict(declared)


def load_backend(words: str) -> Backend:
    """ "module:object" (or "module" alone) to a Backend; the current folder is searched as well.

    Raises BackendError, also for a module that raises or leaves the program while it is imported.
    """
    module, _, attribute = words.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        thing = importlib.import_module(module)
        for part in filter(None, attribute.split(".")):
            if not hasattr(thing, part):
                raise BackendError(f"{words}: found no {part!r} in "
                                   f"{getattr(thing, '__name__', thing)}, needed module:object")
            thing = getattr(thing, part)
    except (BackendError, KeyboardInterrupt):
        raise
    except ImportError as error:
        raise BackendError(f"{words}: found no module to import ({words_of(error)}), needed "
                           "module:object that Python can import from here") from None
    except BaseException as error:
        raise BackendError(f"{words}: found a module that cannot be imported "
                           f"({type(error).__name__}: {words_of(error)}), needed "
                           "module:object") from None
    return as_backend(thing, words, loaded=True)


def read_expected_failures(path: str) -> list[str]:
    """Patterns of case ids that are known to fail, one a line; `#` begins a comment.

    ->  list of str
    """
    with open(path, encoding="utf-8") as file:
        lines = [line.split("#")[0].strip() for line in file]
    return [line for line in lines if line]


def is_expected_failure(identity: str, patterns: Iterable[str]) -> bool:
    """Whether a case's id matches one of the patterns.

    >>> is_expected_failure("gram/plain/forward/float32", ["gram/*/float32"])
    True
    """
    return any(fnmatch.fnmatchcase(identity, pattern) for pattern in patterns)
