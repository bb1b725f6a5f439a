"""What the kit knows of an operation: one specification each, with inputs that try it and inputs
that it must refuse.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
import sys
from types import ModuleType
from typing import Any

import numpy as np

from ..gradcheck.structure import is_float

Array = np.ndarray


@dataclass(frozen=True)
class Sample:
    """One set of inputs.

    inputs : arrays (None where one is left out);  attributes : keyword arguments;  smooth : whether
    the gradient can be measured (no tie, no kink, no NaN here);  known : {"outputs": tuple,
    "upstream": array, "gradients": tuple} worked by hand, where a rule and not the mathematics
    decides;  factors : on the tolerance of each output, beyond the operation's own (searches that
    others end earlier);  exact : nothing is rounded (a choice between near numbers);  large : too
    large for the second derivation's loops;  upstream : its gradient, a random one unless given;
    firm : the differences that it begins with are exact, however far its numbers are from 0.
    """

    label: str
    inputs: tuple
    attributes: dict[str, Any] = field(default_factory=dict)
    smooth: bool = True
    known: Mapping[str, Any] | None = None
    factors: tuple[float, ...] = ()
    exact: bool = False
    large: bool = False
    upstream: Any = None
    firm: bool = False


def ruled(label: str, inputs: tuple, output: Any, upstream: Any, *gradients: Any,
          attributes: Mapping[str, Any] | None = None) -> Sample:
    """A Sample at a tie, a kink or NaN, where a rule decides: output and gradients are known."""
    known = {"outputs": (np.array(output),), "upstream": np.array(upstream),
             "gradients": tuple(map(np.array, gradients))}
    return Sample(label, inputs, dict(attributes or {}), smooth=False, known=known)


def called(label: str, *inputs: Any, factors: Any = (), exact: Any = False, large: Any = False,
           upstream: Any = None, firm: Any = False, **attributes: Any) -> Sample:
    """A Sample written as the call that it is.

    >>> called("both", 1.0, 2.0, padding=1) == Sample("both", (1.0, 2.0), {"padding": 1})
    True
    """
    return Sample(label, inputs, attributes, True, None, factors, exact, large, upstream, firm)


@dataclass(frozen=True)
class Bad:
    """Inputs that must be refused; the reference's message names this argument."""

    label: str
    inputs: tuple
    argument: str
    attributes: dict[str, Any] = field(default_factory=dict)


def refused(label: str, argument: str, *inputs: Any, **attributes: Any) -> Bad:
    """A Bad written as the call that it is."""
    return Bad(label, inputs, argument, attributes)


@dataclass(frozen=True)
class Operation:
    """The specification of one operation of the reference.

    name : what a backend calls it; its gradient is name + "_backward";  arguments : names of the
    inputs;  f, backward : the reference;
    definition : the same mathematics derived a second time, slow and plain, float64 or complex;
    same : (outputs found, arguments, attributes) ->  whether they answer the question as well as
    the reference's (a tie that a rule decides), "" or what they follow;  samples : rng ->  list of
    Sample;
    ground : more of them, where real kernels break;  bad : () ->  list of Bad;  batched : inputs
    whose first axis is the batch;  tolerance : factor on a backend's tolerance (searches);
    whole_range : nothing overflows or vanishes before the answer does;  terms : of a Sample ->
    what each term of a sum comes to, so that none is too small to be seen;
    precisions : that it is tried in;  backward : None where there is no gradient;  grows : many
    steps follow one another, so that rounding grows: the answer may be as far off as it goes when
    the inputs move by their last digit.
    """

    name: str
    arguments: tuple[str, ...]
    f: Callable[..., Any]
    backward: Callable[..., Any] | None
    definition: Callable[..., Any]
    samples: Callable[[np.random.Generator], list[Sample]]
    bad: Callable[[], list[Bad]] = list
    batched: tuple[int, ...] = (0,)
    tolerance: float = 1.0
    precisions: tuple[str, ...] = ("float64", "float32")
    equation: str = ""
    same: Callable[[tuple, tuple, dict[str, Any]], str] | None = None
    ground: Callable[[np.random.Generator], list[Sample]] = lambda rng: []
    whole_range: bool = False
    grows: bool = False
    terms: Callable[[Sample], Mapping[str, float]] | None = None

    def __reduce__(self) -> tuple:
        """It travels to another process by its name."""
        return _by_name, (self.name,)


def _by_name(name):
    from .backend import OPERATIONS
    return OPERATIONS[name]


def operation(f: Callable[..., Any], arguments: str, definitions: ModuleType,
              samples: Callable[[np.random.Generator], list[Sample]],
              bad: Callable[[], list[Bad]] = list, equation: str = "", *, name: str = "",
              suffix: str = "", **rest: Any) -> Operation:
    """The Operation of a function whose backward stands beside it, in the same module, and whose
    definition has the operation's name in `definitions`.

    arguments : their names, with spaces between them;  name : of the operation, the function's own
    unless given;  suffix : behind the name
    """
    name = name or f.__name__
    backward = getattr(sys.modules[f.__module__], f"{f.__name__}_backward", None)
    return Operation(name + suffix, tuple(arguments.split()), f, backward,
                     getattr(definitions, name), samples, bad, equation=equation, **rest)


class PythonNumber(np.ndarray):
    """What was a Python float: a number without a precision of its own."""


def has_type(found: np.ndarray, expected: np.ndarray, precision: str) -> bool:
    """Whether an output has the precision asked for, or whole numbers where these are expected."""
    if isinstance(found, PythonNumber) and expected.dtype.kind == "f" and expected.ndim == 0:
        return True                                              # it has no precision of its own
    dtype = np.dtype(precision) if expected.dtype.kind == "f" else expected.dtype
    return found.dtype == dtype or (dtype.kind in "iu" and found.dtype.kind in "iu")


def as_tuple(result: Any) -> tuple[Any, ...]:
    """The outputs of a function, or the gradients of a backward, as a tuple of arrays; None is
    kept, and what a mask covers is no number.

    >>> as_tuple((np.zeros(2), None))
    (array([0., 0.]), None)
    """
    parts = [part.filled(np.nan) if isinstance(part, np.ma.MaskedArray) and part.dtype.kind == "f"
             else part for part in (result if isinstance(result, (tuple, list)) else (result,))]
    return tuple(None if part is None else np.asarray(part).view(PythonNumber)
                 if type(part) is float else np.asarray(part) for part in parts)


def cast(values: Iterable[Any], dtype: Any) -> tuple:
    """Floating-point arrays in another precision; whole numbers, labels and None as they are.

    >>> cast((np.zeros(1), None), np.float32)
    (array([0.], dtype=float32), None)
    """
    with np.errstate(over="ignore"):
        return tuple(x.astype(dtype) if is_float(x) else x for x in values)


def cast_attributes(attributes: Mapping[str, Any], dtype: Any) -> dict[str, Any]:
    """The same for keyword arguments."""
    return dict(zip(attributes, cast(attributes.values(), dtype)))
