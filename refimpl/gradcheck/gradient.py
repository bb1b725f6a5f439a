r"""Is a gradient right? Three instruments, none of which knows how the gradient was derived.

| instrument | for | what decides |
| --- | --- | --- |
| complex step | analytic functions | rounding: 1e-13 of the terms that an element sums |
| central differences extrapolated to h = 0 | all others | the extrapolation's own error |
| slopes to both sides | what neither agrees with | between them is right, outside is wrong |

A function `f(*inputs)` has one output y. Its backward claims, for a random upstream gradient dy,
the gradient of `sum(dy * y)`. Ones would not do for dy: many wrong gradients are right in their
sum. The instruments themselves are in `derivative` and `slope`. Each element of a gradient is
measured by steps of its own and held to a bound of its own. Where f has too few digits for a
verdict the check says so: undecided is neither right nor wrong.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import derivative
from .contract import check_contract, copies, same_bits
from .elements import (agrees_along, judge_elements, random_directions, summed_along,
                       undecided)
from .errors import GradientError, UndecidedError, describe
from .report import Report, Row
from .structure import flattened, is_float, paired

ELEMENTS, SAMPLE = 2000, 200     # up to so many elements all are checked, beyond it a sample


def check_gradient(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
                   names: Sequence[str] | None = None, seed: int = 0, report: bool = False,
                   contract: bool = True, elements: int = ELEMENTS) -> Report | None:
    """Check a gradient in all its elements; of a large input in a sample, and in all of them
    together along a random line.

    f(*inputs) -> array or number, or a tuple of arrays;
    f_backward(dy, *inputs) -> the gradient of the only input or a tuple with one for each; None for
    an input that is a constant, which is then not checked;
    inputs : float64 arrays, or dicts, lists and tuples of them; everything else (None, numbers,
    whole-number arrays) is passed through and has no gradient;
    names : of the inputs, for messages;
    contract : also check what every backward must keep (see `contract.check_contract`), and one
    line each through inputs of the other sign and through a single clip, where f takes them;
    elements : an input of more has a sample checked one by one, and is searched for the worst where
    the line disagrees
    ->  Report with report=True, which then holds every failure, else None.
    Raises GradientError with the input's name, the worst element, what was found and what was
    needed, and how to see it again; UndecidedError where f has not the digits for a verdict;
    ValueError for inputs that no verdict can be had on.

    >>> check_gradient(np.sin, lambda dy, x: dy * np.cos(x), np.array([0.5, 1.0]))
    >>> check_gradient(np.sin, lambda dy, x: dy * np.sin(x), np.array([0.5]))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    refimpl.gradcheck.errors.GradientError: input 0[0]: found 0.06..., needed 0.11... by complex...
    """
    f, f_backward, arrays, names = flattened(f, f_backward, inputs, _names(names, inputs))
    differentiable(arrays, names)
    dy = upstream(f, arrays, seed)
    rng = np.random.default_rng([seed, 1])
    claims = _claims(f_backward, dy, arrays, names)
    rows: list[Row] = []
    failures, doubts = _repeated(claims, f_backward, dy, arrays, names, "on a second call"), []
    for i, claim in claims.items() if not failures else ():
        row, failure, doubt = judge_elements(f, f_backward, dy, arrays, i, names[i], claim, rng,
                                             seed, elements, SAMPLE)
        rows.append(row)
        failures += [failure] if failure else []
        doubts += [doubt] if doubt else []
    notes = [f"{names[i]}: no gradient is claimed, it is taken for a constant"
             for i in differentiable(arrays, names) if i not in claims]
    if contract and not failures:
        try:
            check_contract(f, f_backward, *arrays, names=names, seed=seed)
            notes += _elsewhere(f, f_backward, arrays, names, seed)
        except UndecidedError:
            pass
        except GradientError as error:
            failures.append(str(error))
    failures = failures or _repeated(claims, f_backward, dy, arrays, names,
                                     "after all the other calls")
    if report:
        return Report(tuple(rows), tuple(failures), tuple(doubts), tuple(notes))
    if failures:
        raise GradientError(failures[0])
    if doubts:
        raise UndecidedError(doubts[0])
    return None


def check_direction(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
                    names: Sequence[str] | None = None, seed: int = 0, directions: int = 2,
                    tolerance: float = 0.0) -> None:
    r"""Check a gradient along random lines through all inputs at once, at any size: two derivatives
    of one variable each.

        d/dh sum(dy f(x + h v)) at h = 0   =   sum over inputs <gradient, v>

    Where the two differ, the Taylor remainder  f(x + h v) - f(x) - h <gradient, v>  does not fall
    as h^2; the rate is named.

    tolerance : allowed beyond what cannot be told, relative to the terms of the sum
    Raises GradientError, UndecidedError where kinks or rounding hide the slope.

    >>> check_direction(np.multiply, lambda dy, a, b: (dy * b, dy * a), np.eye(3), np.ones((3, 3)))
    """
    f, f_backward, arrays, names = flattened(f, f_backward, inputs, _names(names, inputs))
    dy = upstream(f, arrays, seed)
    claims = _claims(f_backward, dy, arrays, names)
    for number in range(directions):
        where, again = f"along random direction {number}", f"see it again with seed={seed}"
        v = random_directions(arrays, claims, np.random.default_rng([seed, 2, number]))
        along = derivative.line(f, arrays, v)
        agrees, slope, claimed, allowed = agrees_along(along, dy, claims, v, tolerance)
        if agrees is None:
            raise UndecidedError(f"{where}: {undecided(claimed, slope)}; {again}")
        if not agrees:
            rate = derivative.remainder_slope(along, dy, claimed)
            falls = f"; the Taylor remainder falls as h^{rate:.2f}, needed h^2" if rate else ""
            raise GradientError(f"{where}: {describe(claimed, slope.value, allowed)} by central "
                                f"differences{falls}; {again}")


def check_kink(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
               direction: np.ndarray, wrt: int = 0, seed: int = 0,
               tolerance: float = 1e-6) -> tuple[float, float, float]:
    """At a kink: the derivatives to both sides along a direction bracket the claimed one.

    direction : array like inputs[wrt]
    ->  left, claimed, right derivative, for comparison with the policy.   Raises GradientError.

    >>> left, claimed, right = check_kink(np.abs, lambda dy, x: dy * np.sign(x), np.zeros(1),
    ...                                   direction=np.ones(1))
    >>> claimed, bool(np.isclose(left, -right))
    (0.0, True)
    """
    dy = upstream(f, inputs, seed)
    claims = _claims(f_backward, dy, inputs, _names(None, inputs))
    claimed, _ = summed_along({wrt: claims[wrt]}, {wrt: direction})
    left, right = derivative.one_sided(derivative.line(f, inputs, {wrt: direction}), dy)
    margin = tolerance * max(abs(left), abs(right))
    if not min(left, right) - margin <= claimed <= max(left, right) + margin:
        raise GradientError(f"at the kink: found {claimed:.6g}, needed a value between the "
                            f"one-sided derivatives {left:.6g} and {right:.6g}")
    return left, claimed, right


def upstream(f: Callable[..., Any], inputs: Sequence[Any], seed: int) -> np.ndarray:
    """A random upstream gradient of the shape of the output, float64, the same for the same seed.

    Raises ValueError for an output of another precision.

    >>> upstream(np.negative, [np.zeros((2, 3))], seed=0).shape
    (2, 3)
    """
    y = np.asarray(f(*inputs))
    if y.dtype != np.float64:
        raise ValueError(f"f: found an output of dtype {y.dtype}, needed one array of float64; "
                         "verdicts need its digits")
    return np.asarray(np.random.default_rng(seed).standard_normal(y.shape))


def differentiable(inputs: Sequence[Any], names: Sequence[str]) -> list[int]:
    """Indices of the inputs that have a gradient: arrays of float64.

    Raises ValueError for another precision, or where there is none.

    >>> differentiable([np.zeros(2), 3, np.arange(2)], ["x", "power", "places"])
    [0]
    """
    for name, x in zip(names, inputs):
        if isinstance(x, np.ndarray) and x.dtype.kind in ("f", "c") and x.dtype != np.float64:
            raise ValueError(f"{name}: found dtype {x.dtype}, needed float64; verdicts need its "
                             f"digits, try {name}.astype(float)")
    chosen = [i for i, x in enumerate(inputs) if is_float(x)]
    if not chosen:
        kinds = ", ".join(type(x).__name__ for x in inputs) or "none"
        raise ValueError(f"inputs: found {kinds}, needed at least one array of float64")
    return chosen


def _repeated(claims, f_backward, dy, inputs, names, when):
    """->  messages: which gradients are no longer what they were"""
    again = _claims(f_backward, dy, inputs, names)
    return [f"{names[i]}: found another gradient {when} with the same arguments; needed the same "
            "bits" for i in claims if i not in again or not same_bits(claims[i], again[i])]


def _elsewhere(f, f_backward, inputs, names, seed):
    """A line through inputs of the other sign, and one through the first clip alone.   ->  what was
    looked at;   raises GradientError
    """
    notes = []
    for what, others in _other_inputs(inputs):
        try:
            with np.errstate(all="ignore"):
                dy = upstream(f, others, seed)
                claims = _claims(f_backward, dy, others, names)
                v = random_directions(others, claims, np.random.default_rng([seed, 4]), own=True)
                agrees, slope, claimed, allowed = agrees_along(
                    derivative.line(f, others, v), dy, claims, v, 1e-6)
        except Exception:                        # whatever it is: f is not for these
            continue
        if agrees:
            notes.append(f"a line through {what} agrees")
        elif agrees is not None:
            raise GradientError(f"for {what}, along a random line: "
                                f"{describe(claimed, slope.value, allowed)}; if f_backward is not "
                                "made for these, contract=False leaves them out")
    return notes


def _other_inputs(inputs):
    """(what, inputs) that check other branches than the given ones."""
    yield "inputs of the other sign", [-x if is_float(x) else x for x in inputs]
    first = next((x for x in inputs if is_float(x) and x.ndim > 1), None)
    if first is not None and len(first) > 1:
        yield "the first clip alone", [x[:1] if isinstance(x, np.ndarray) and x.ndim and
                                       (x is first or len(x) == len(first)) else x for x in inputs]


def _claims(f_backward, dy, inputs, names):
    """{input: claimed gradient}, whether the backward returns one array or a tuple."""
    chosen = differentiable(inputs, names)
    gradients = f_backward(*copies((dy, *inputs)))
    gradients = gradients if isinstance(gradients, (tuple, list)) else (gradients,)
    if len(gradients) not in (len(inputs), len(chosen)):
        raise GradientError(f"f_backward: found {len(gradients)} gradients, needed one for each of "
                            f"{', '.join(names)}")
    claimed = paired(gradients, inputs)
    if not claimed:
        raise GradientError("f_backward: found NoneType for every gradient, needed one for each of "
                            f"{', '.join(names)}")
    for i, gradient in claimed.items():
        if not isinstance(gradient, (np.ndarray, np.generic)) or gradient.dtype.kind != "f":
            found = getattr(gradient, "dtype", type(gradient).__name__)
            raise GradientError(f"{names[i]}: found a gradient that is {found}, needed a float64 "
                                "array")
        if gradient.dtype != np.float64:
            raise GradientError(f"{names[i]}: found a gradient of dtype {gradient.dtype}, needed "
                                "float64, as its input")
    return {i: np.asarray(gradient) for i, gradient in claimed.items()}


def _names(names, inputs):
    names = tuple(names) if names is not None else tuple(f"input {i}" for i in range(len(inputs)))
    if len(names) != len(inputs):
        raise ValueError(f"names: found {len(names)}, needed one for each of {len(inputs)} inputs")
    return names
