"""What one call says, held against what it should say."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..gradcheck.contract import changed
from ..gradcheck.difference import differences, largest
from .backend import Backend, ask
from .calls import Case
from .specification import has_type


class Difference(Exception):
    """What is wrong with a result, found and expected in a few words or numbers, and the worst
    element.
    """

    def __init__(self, message: str, found: Any = "", expected: Any = "", **worst: Any) -> None:
        super().__init__(message)
        self.worst, self.found, self.expected = worst, found, expected


def call(case: Case, backend: Backend, upstream: np.ndarray | None = None,
         writeable: bool = True) -> tuple:
    """Outputs of the function for copies of the case's arguments, which it must leave alone."""
    arguments, attributes = case.fresh(writeable)
    before = case.arguments
    if upstream is not None:
        before = (upstream, *before[1:])
        arguments = (upstream.copy(), *arguments[1:])
    try:
        return ask(backend.functions[case.function], arguments, attributes)
    finally:
        for name, _ in changed((*case.names[:len(before)], *case.attributes),
                               (*before, *case.attributes.values()),
                               (*arguments, *attributes.values())):
            raise Difference(f"changed its argument {name}, needed to leave it alone",
                             f"changed {name}", f"{name} left alone")


def compare(found: tuple, case: Case, allowances: Sequence[Any]) -> float:
    """Raise Difference unless all outputs have the expected shape, type and values.

    allowances : of `Case.allowances`   ->  largest difference relative to the largest element
    """
    expected, worst = case.expected or (), 0.0
    while len(found) > len(expected) and found[-1] is None:      # the gradients of constants
        found = found[:-1]
    if len(found) != len(expected):
        raise Difference(f"found {len(found)} outputs, needed {len(expected)}",
                         f"{len(found)} outputs", f"{len(expected)} outputs")
    free = case.free or (None,) * len(expected)
    for number, (a, b, allowed, either) in enumerate(zip(found, expected, allowances, free)):
        label = output_name(case, number)
        if b is not None and a is None:
            raise Difference(f"{label}: found None, needed an array of shape {b.shape}",
                             "None", f"shape {b.shape}")
        if b is not None:
            if either is not None and np.shape(a) == np.shape(b):
                a = np.where(either & np.isnan(a), b.astype(a.dtype), a)
            worst = max(worst, _compare_arrays(label, a, np.asarray(b), allowed, case))
    return worst


def output_name(case: Case, number: int) -> str:
    """What a message calls an output of the case's function."""
    if case.function.endswith("_backward"):
        names = case.operation.arguments
        return f"gradient of {names[number] if number < len(names) else number}"
    return "output" if len(case.expected or ()) == 1 else f"output {number}"


def _compare_arrays(label, found, expected, allowed, case):
    if found.shape != expected.shape:
        raise Difference(f"{label}: found shape {found.shape}, needed {expected.shape}",
                         f"shape {found.shape}", f"shape {expected.shape}")
    if not has_type(found, expected, case.precision):
        dtype = case.precision if expected.dtype.kind == "f" else expected.dtype
        raise Difference(f"{label}: found dtype {found.dtype}, needed {dtype}",
                         f"dtype {found.dtype}", f"dtype {dtype}")
    if not expected.size:
        return 0.0
    off = differences(found, expected)
    allowed = np.broadcast_to(allowed, off.shape)
    beyond = np.where(off > allowed, np.where(off < np.inf, off - allowed, np.inf), 0.0)
    worst, size = np.unravel_index(np.argmax(beyond), off.shape), largest(expected) or 1.0
    if beyond[worst] > 0:
        index, values = [int(i) for i in worst], (float(found[worst]), float(expected[worst]))
        raise Difference(f"{label}, worst at {index}: got {values[0]:.17g}, wanted "
                         f"{values[1]:.17g} ({off[worst]:.3g} off, {allowed[worst]:.2g} allowed; "
                         f"{int((beyond > 0).sum())} of {off.size} elements differ)", *values,
                         output=label, index=index, got=values[0], wanted=values[1],
                         relative=float(off[worst] / size))
    return float(off.max(initial=0.0) / size)
