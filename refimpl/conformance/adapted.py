"""Functions of another library as a backend: what `refimpl.adapters` share."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..gradcheck.structure import is_float
from .backend import DECLARED, OPERATIONS
from .cases import generator, known_operation
from .specification import Operation


def adapted(given: Mapping[str, Any], forward: Callable[[str, Any], Callable],
            backward: Callable[[str, Any, int], Callable],
            lacks: Iterable[str] = ()) -> dict[str, Any]:
    """A backend's mapping: each operation and its gradient as functions of NumPy arrays.

    given : {operation: function of the library's arrays}; a name that ends in "_backward" brings a
    gradient written by hand, and what a backend declares ("lacks", "tolerances") stays as it is
    forward : (name, function) ->  function of NumPy arrays;  backward : (name, function, how many
    arguments have a gradient) ->  gradient of NumPy arrays;  lacks : what the library has not
    Raises ValueError for a name that is no operation.

    >>> found = adapted({"gram": abs}, lambda name, f: f, lambda name, f, count: (f, count))
    >>> sorted(found), found["gram_backward"]
    (['gram', 'gram_backward', 'lacks'], (<built-in function abs>, 1))
    """
    found: dict[str, Any] = {"lacks": [*lacks, *given.get("lacks", ())]}
    for name, function in given.items():
        if name in DECLARED:
            found.setdefault(name, function)
            continue
        known_operation(name.removesuffix("_backward"))
        found[name] = forward(name, function)
        operation = OPERATIONS.get(name)
        if operation and operation.backward and f"{name}_backward" not in given:
            found[f"{name}_backward"] = backward(name, function, differentiated(operation))
    return found


def differentiated(operation: Operation) -> int:
    """How many of an operation's arguments have a gradient: those in front that are
    floating-point arrays in its first sample.

    >>> differentiated(OPERATIONS["foot_loss"]), differentiated(OPERATIONS["conv1d"])
    (1, 3)
    """
    return sum(is_float(x) for x in example(operation))


def example(operation: Operation) -> tuple:
    """The arguments of an operation's first sample.

    >>> [x.shape for x in example(OPERATIONS["gram"])]
    [(2, 3, 5)]
    """
    return operation.samples(generator(operation, 0))[0].inputs
