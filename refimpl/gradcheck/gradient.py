r"""Is a gradient right? Three instruments, none of which knows how the gradient was derived.

| instrument | for | verdict |
| --- | --- | --- |
| complex step | analytic functions | 1e-12 |
| central differences extrapolated to h = 0, Taylor remainder falling as h^2 | all | 1e-8 |
| the derivatives to both sides of a kink, which bracket the claimed one | relu, pools | exact |

A function `f(*inputs)` has one output y. Its backward claims, for a random upstream gradient dy,
the gradient of `sum(dy * y)`. Ones would not do for dy: many wrong gradients are right in their
sum. The instruments themselves are in `derivative`.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import derivative
from .contract import check_contract, copies
from .difference import TINY
from .errors import GradientError, describe
from .report import Report, Row

ANALYTIC, NUMERIC = 1e-12, 1e-8  # tolerances, relative to the largest element of a gradient
UNSURE = 1e-6           # at most this where rounding or a near kink blurs central differences
ELEMENTS, SAMPLE = 2000, 200     # up to so many elements all are checked, beyond it a sample


def check_gradient(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
                   names: Sequence[str] | None = None, seed: int = 0, report: bool = False,
                   contract: bool = True, elements: int = ELEMENTS) -> Report | None:
    """Check a gradient in all its elements; of a large input in a sample, and in all of them
    together along a random line.

    f(*inputs) -> array or number;
    f_backward(dy, *inputs) -> the gradient of the only input or a tuple with one for each;
    inputs : float64 arrays; everything else (None, numbers, whole-number arrays) is passed through
    and has no gradient;
    names : of the inputs, for messages;
    contract : also check what every backward must keep (see `contract.check_contract`);
    elements : an input of more has a sample checked one by one, and is searched for the worst where
    the line disagrees
    ->  Report with report=True, which then holds every failure, else None.
    Raises GradientError with the input's name, the worst element, what was found and what was
    needed, and how to see it again; ValueError for inputs that no verdict can be had on.

    >>> check_gradient(np.sin, lambda dy, x: dy * np.cos(x), np.array([0.5, 1.0]))
    >>> check_gradient(np.sin, lambda dy, x: dy * np.sin(x), np.array([0.5]))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    refimpl.gradcheck.errors.GradientError: input 0[0]: found 0.06..., needed 0.11... by complex...
    """
    names = _names(names, inputs)
    differentiable(inputs, names)
    dy = upstream(f, inputs, seed)
    rng = np.random.default_rng([seed, 1])
    rows, failures = [], []
    for i, claim in _claims(f_backward, dy, inputs, names).items():
        row, failure = _check_input(f, dy, inputs, i, names[i], claim, rng, seed, elements)
        rows.append(row)
        failures += [failure] if failure else []
    for check in [check_direction] + [check_contract] * contract if not failures else []:
        try:
            check(f, f_backward, *inputs, names=names, seed=seed)
        except GradientError as error:
            failures.append(str(error))
    if report:
        return Report(tuple(rows), tuple(failures))
    if failures:
        raise GradientError(failures[0])
    return None


def check_direction(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
                    names: Sequence[str] | None = None, seed: int = 0, directions: int = 2,
                    tolerance: float = NUMERIC) -> None:
    r"""Check a gradient along random lines through all inputs at once, at any size: two derivatives
    of one variable each.

        d/dh sum(dy f(x + h v)) at h = 0   =   sum over inputs <gradient, v>

    And the Taylor remainder  f(x + h v) - f(x) - h <gradient, v>  must fall as h^2.
    Raises GradientError.

    >>> check_direction(np.multiply, lambda dy, a, b: (dy * b, dy * a), np.eye(3), np.ones((3, 3)))
    """
    dy = upstream(f, inputs, seed)
    claims = _claims(f_backward, dy, inputs, _names(names, inputs))
    for number in range(directions):
        where, again = f"along random direction {number}", f"see it again with seed={seed}"
        v = _random_directions(inputs, claims, np.random.default_rng([seed, 2, number]))
        along = derivative.line(f, inputs, v)
        claimed, size = _along(claims, v)
        found, bound = _differentiate(along, dy, claimed, size, tolerance)
        if not abs(found - claimed) <= bound:
            raise GradientError(f"{where}: {describe(claimed, found, bound)} by central "
                                f"differences; {again}")
        slope = derivative.remainder_slope(along, dy, claimed)
        if slope is not None and slope < 1.8:
            raise GradientError(f"{where}: the Taylor remainder falls as h^{slope:.2f}, needed "
                                f"h^2; {again}")


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
    claimed, _ = _along({wrt: claims[wrt]}, {wrt: direction})
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
    chosen = [i for i, x in enumerate(inputs) if isinstance(x, np.ndarray) and x.dtype.kind == "f"]
    if not chosen:
        kinds = ", ".join(type(x).__name__ for x in inputs) or "none"
        raise ValueError(f"inputs: found {kinds}, needed at least one array of float64")
    return chosen


def _check_input(f, dy, inputs, i, name, claim, rng, seed, most):
    """->  Row, message of the worst element or None"""
    x = inputs[i]
    if claim.shape != x.shape:
        return (Row(name, False, False, np.inf, "its shape"),
                f"{name}: found a gradient of shape {claim.shape}, needed {x.shape}, the input's")
    v = _random_directions(inputs, [i], rng)
    analytic = derivative.is_analytic(derivative.line(f, inputs, v), dy)
    elements = np.arange(x.size)
    if x.size > most:
        elements = rng.choice(x.size, min(most, SAMPLE), replace=False)
        if not _line_agrees(f, dy, inputs, i, claim, v[i], analytic):
            elements = np.union1d(elements, _locate(f, dy, inputs, i, claim, v[i], analytic))
    claimed = claim.ravel()[elements].astype(float)
    measured, bounds = _measure_elements(f, dy, inputs, i, claim, elements, analytic)
    differences = np.abs(claimed - measured)
    good = differences <= bounds
    instrument = "complex step" if analytic else "central differences"
    row = Row(name, bool((claimed == measured).all()), bool(good.all()),
              float(differences.max(initial=0.0)),
              f"{instrument}, {len(elements)} of {x.size} elements")
    if good.all():
        return row, None
    differences = np.where(np.isnan(differences), np.inf, differences)
    worst = int(np.argmax(np.where(good, -np.inf, differences)))
    where = ", ".join(str(int(n)) for n in np.unravel_index(elements[worst], x.shape))
    return row, (f"{name}[{where}]: {describe(claimed[worst], measured[worst], bounds[worst])} by "
                 f"{instrument}; {int((~good).sum())} of {len(good)} elements are wrong.\n"
                 "See it again, with f, f_backward and inputs as they are now:\n"
                 f"    dy = np.random.default_rng({seed}).standard_normal(np.shape(f(*inputs)))\n"
                 f"    gradients = f_backward(dy, *inputs)      # the one of {name} at [{where}] "
                 f"should be {float(measured[worst])!r}")


def _measure_elements(f, dy, inputs, i, claim, elements, analytic):
    """Derivatives with respect to single elements, and the difference from the claim that each
    allows.
    """
    x, step = inputs[i], _scale(inputs[i])
    lines = []
    for e in elements:
        v = np.zeros(x.size)
        v[e] = 1.0 if analytic else step
        lines.append(derivative.line(f, inputs, {i: v.reshape(x.shape)}))
    size = max(np.abs(claim).max(initial=0.0), TINY)
    if analytic:
        measured = np.array([derivative.complex_step(along, dy) for along in lines], dtype=float)
        size = max(np.abs(measured).max(initial=0.0), size)
        return measured, np.full(len(elements), ANALYTIC * size)
    pairs = [_differentiate(along, dy, step * claim.flat[e], step * size, NUMERIC)
             for along, e in zip(lines, elements)]
    measured, bounds = np.array(pairs, dtype=float).reshape(len(elements), 2).T / step
    return measured, bounds


def _differentiate(along, dy, claimed, size, tolerance):
    """Central differences, and the difference from the claim that they allow; once more, closer,
    where a kink is near.

    size : of the numbers that the derivative is the sum of
    """
    found, error = derivative.extrapolate(along, dy)
    if not abs(found - claimed) <= tolerance * size:
        closer = derivative.extrapolate(along, dy, derivative.CLOSE_STEPS)
        found, error = min((found, error), closer, key=lambda pair: pair[1])
    return found, max(tolerance * max(abs(found), size), min(10 * error, UNSURE * size))


def _line_agrees(f, dy, inputs, i, claim, v, analytic):
    """Whether all elements of one gradient are right together, along direction v."""
    along = derivative.line(f, inputs, {i: v})
    claimed, size = _along({i: claim}, {i: v})
    if analytic:
        return abs(derivative.complex_step(along, dy) - claimed) <= 10 * ANALYTIC * size
    found, bound = _differentiate(along, dy, claimed, size, NUMERIC)
    return abs(found - claimed) <= bound


def _locate(f, dy, inputs, i, claim, v, analytic):
    """The element where a large gradient is wrong, by halving the line: that half whose derivative
    differs more holds it.   ->  flat index
    """
    def _mismatch(elements):
        part = np.zeros(v.size)
        part[elements] = v.ravel()[elements]
        along = derivative.line(f, inputs, {i: part.reshape(v.shape)})
        found = derivative.complex_step(along, dy) if analytic else None
        found = derivative.extrapolate(along, dy)[0] if found is None else found
        # of these elements alone: no NaN of another one times 0
        claimed = float(np.sum(claim.ravel()[elements] * part[elements]))
        return np.inf if np.isnan(found - claimed) else abs(found - claimed)
    elements = np.arange(v.size)
    while len(elements) > 1:
        elements = max(np.array_split(elements, 2), key=_mismatch)
    return elements[0]


def _along(claims, v):
    """sum <gradient, v>, the claimed derivative along a line, and the size of its terms (as if
    their signs were random).
    """
    terms = [np.ravel(claims[i] * v[i]) for i in v]
    size = float(np.sqrt(sum(np.square(t).sum() for t in terms)))
    return float(sum(t.sum() for t in terms)), max(size, TINY)


def _random_directions(inputs, chosen, rng):
    """A direction for each chosen input, of the input's own size."""
    return {i: _scale(inputs[i]) * rng.standard_normal(inputs[i].shape) for i in chosen}


def _scale(x):
    """The size of an input's elements, to which steps are relative; 1 for zeros."""
    size = float(np.sqrt(np.mean(np.square(x)))) if x.size else 0.0
    return size if 0 < size < np.inf else 1.0


def _claims(f_backward, dy, inputs, names):
    """{input: claimed gradient}, whether the backward returns one array or a tuple."""
    chosen = differentiable(inputs, names)
    gradients = f_backward(*copies((dy, *inputs)))
    gradients = gradients if isinstance(gradients, (tuple, list)) else (gradients,)
    if len(gradients) not in (len(inputs), len(chosen)):
        raise GradientError(f"f_backward: found {len(gradients)} gradients, needed one for each of "
                            f"{', '.join(names)}")
    if len(gradients) == len(inputs):
        gradients = [gradients[i] for i in chosen]
    for i, gradient in zip(chosen, gradients):
        if not isinstance(gradient, (np.ndarray, np.generic)) or gradient.dtype.kind != "f":
            found = getattr(gradient, "dtype", type(gradient).__name__)
            raise GradientError(f"{names[i]}: found a gradient that is {found}, needed a float64 "
                                "array")
    return dict(zip(chosen, map(np.asarray, gradients)))


def _names(names, inputs):
    names = tuple(names) if names is not None else tuple(f"input {i}" for i in range(len(inputs)))
    if len(names) != len(inputs):
        raise ValueError(f"names: found {len(names)}, needed one for each of {len(inputs)} inputs")
    return names
