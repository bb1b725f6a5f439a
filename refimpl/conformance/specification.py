"""What the kit knows of an operation: one record each, with inputs that try it and inputs that it
must refuse.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Sample:
    """One set of inputs.

    inputs : arrays (None where one is left out);  attributes : keyword arguments;  smooth : whether
    the gradient can be measured (no tie, no kink, no NaN here);  known : {"outputs": tuple,
    "upstream": array, "gradients": tuple} worked by hand, where a rule and not the mathematics
    decides;  factors : on the tolerance of each output, beyond the operation's own (searches that
    others end earlier).
    """

    label: str
    inputs: tuple
    attributes: dict = field(default_factory=dict)
    smooth: bool = True
    known: dict = None
    factors: tuple = ()


@dataclass(frozen=True)
class Bad:
    """Inputs that must be refused; the reference's message names this argument."""

    label: str
    inputs: tuple
    attributes: dict
    argument: str


@dataclass(frozen=True)
class Operation:
    """One operation of the reference.

    name : what a backend calls it; its gradient is name + "_backward";  arguments : names of the
    inputs;  f, backward : the reference;
    definition : the same mathematics derived a second time, slow and plain, float64 or complex;
    same : (outputs found, arguments, attributes) ->  whether they answer the question as well as
    the reference's (a tie that a rule decides), "" or what they follow;  samples : rng ->  list of
    Sample;
    bad : () ->  list of Bad;  batched : inputs whose first axis is the batch;  tolerance : factor
    on a backend's tolerance (long sums, searches);
    precisions : that it is tried in;  backward : None where there is no gradient.
    """

    name: str
    arguments: tuple
    f: callable
    backward: callable
    definition: callable
    samples: callable
    bad: callable = list
    batched: tuple = (0,)
    tolerance: float = 1.0
    precisions: tuple = ("float64", "float32")
    equation: str = ""
    same: callable = None


class PythonNumber(np.ndarray):
    """What was a Python float: a number without a precision of its own."""


def as_tuple(result):
    """The outputs of a function, or the gradients of a backward, as a tuple of arrays; None is
    kept.
    """
    parts = result if isinstance(result, (tuple, list)) else (result,)
    return tuple(None if part is None else np.asarray(part).view(PythonNumber) if type(part) is
                 float else np.asarray(part) for part in parts)


def cast(inputs, dtype):
    """Floating-point inputs in another precision; whole numbers, labels and None as they are."""
    return tuple(
        x.astype(dtype) if isinstance(x, np.ndarray) and x.dtype.kind == "f" else x for x in inputs)


def largest(wanted):
    """The largest finite element's size, 1 where all are 0: what differences are measured in."""
    wanted = np.asarray(wanted)
    wanted = wanted if wanted.dtype.kind in "fc" else wanted.astype(float)
    return float(np.abs(wanted[np.isfinite(wanted)]).max(initial=0.0)) or 1.0


def relative_difference(found, wanted):
    """How far each element is off, in units of the largest finite element wanted (of 1 where all
    are 0); NaN agrees with NaN alone.

    Two arrays of one shape  ->  array of that shape, inf where one is finite and the other is not
    """
    found, wanted = np.asarray(found), np.asarray(wanted)
    if wanted.dtype.kind not in "fc":
        found, wanted = found.astype(float), wanted.astype(float)
    finite = np.isfinite(wanted)
    off = np.where((found == wanted) | (np.isnan(found) & np.isnan(wanted)), 0.0, np.inf)
    both = finite & np.isfinite(found)
    off[both] = np.abs(found[both] - wanted[both]) / largest(wanted)
    return off
