r"""Is a gradient right? Three instruments, none of which knows how the gradient was derived.

| instrument | for | verdict |
| --- | --- | --- |
| complex step, `Im f(x + i h e) / h` with h = 1e-30: no difference is taken, so nothing cancels | analytic functions | 1e-12 |
| central differences, extrapolated to h = 0, and the rate at which the Taylor remainder falls (as h^2) | everything | 1e-8 |
| the derivatives to the left and to the right of a kink, which must bracket the claimed one | relu, pools, norms at 0 | exact |

A function `f(*inputs)` has one output y. Its backward claims, for a random upstream gradient dy, the gradient of `sum(dy * y)`.
Ones would not do for dy: many wrong gradients are right in their sum.
"""

from dataclasses import dataclass

import numpy as np

from .contract import check_contract
from .errors import GradientError, describe

COMPLEX_STEP = 1e-30
ANALYTIC, NUMERIC = 1e-12, 1e-8                                  # tolerances, relative to the largest element of a gradient
STEPS = 1e-3 * 4.0 ** -np.arange(6)                              # of the central differences: 1e-3 ... 1e-6
CLOSE_STEPS = STEPS[-1] * 4.0 ** -np.arange(3)                   # where a kink lies within the larger ones; rounding then allows only
NEAR_KINK = 1e-6                                                 # this tolerance
ELEMENTS = 2000                                                  # up to so many elements all are checked, beyond it a sample


@dataclass(frozen=True)
class Row:
    """One input's verdict. exact : equal to the last bit;  approximate : within the tolerance;  difference : the largest one found."""

    name: str
    exact: bool
    approximate: bool
    difference: float
    tolerance: float
    instrument: str
    elements: int


@dataclass(frozen=True)
class Report:
    """All rows; prints as a table `name | exact | approximate | max difference`."""

    rows: tuple

    @property
    def passed(self):
        return all(row.approximate for row in self.rows)

    def __str__(self):
        width = max([4] + [len(row.name) for row in self.rows])
        lines = [f"{'name':{width}} | exact | approximate | max difference | checked by"]
        lines += [f"{row.name:{width}} | {str(row.exact):5} | {str(row.approximate):11} | {row.difference:14.3e} | "
                  f"{row.instrument}, {row.elements} elements" for row in self.rows]
        return "\n".join(lines)


def check_gradient(f, f_backward, *inputs, names=None, seed=0, report=False, contract=True):
    """Check a gradient in all its elements (of a large input in a sample and along random directions).

    f(*inputs) -> array or number;  f_backward(dy, *inputs) -> the gradient of the only input or a tuple with one for each;
    inputs : float64 arrays; None and whole numbers are passed through and have no gradient;  names : of the inputs, for messages;
    contract : also check what every backward must keep (see `contract.check_contract`)
    ->  Report with report=True, else None.
    Raises GradientError with the input's name, the worst element, what was found and what was needed, and how to see it again.
    """
    names = _names(names, inputs)
    dy = upstream(f, inputs, seed)
    claims = _claims(f_backward, dy, inputs, names)
    rng = np.random.default_rng([seed, 1])
    rows, failures = [], []
    for i in differentiable(inputs):
        row, failure = _check_input(f, dy, inputs, i, names[i], claims[i], rng, seed)
        rows.append(row)
        failures += [failure] if failure else []
    if failures and not report:
        raise GradientError(failures[0])
    if contract and not failures:
        check_contract(f, f_backward, *inputs, names=names, seed=seed)
    if not report:
        check_direction(f, f_backward, *inputs, seed=seed)
    return Report(tuple(rows)) if report else None


def check_direction(f, f_backward, *inputs, seed=0, directions=2, tolerance=NUMERIC):
    r"""Check a gradient along random directions through all inputs at once, at any size: two derivatives of one variable each.

        d/dh sum(dy f(x + h v)) at h = 0   =   sum over inputs <gradient, v>

    And the Taylor remainder  f(x + h v) - f(x) - h <gradient, v>  must fall as h^2.   Raises GradientError.
    """
    dy = upstream(f, inputs, seed)
    chosen = differentiable(inputs)
    claims = _claims(f_backward, dy, inputs, _names(None, inputs))
    for number in range(directions):
        rng = np.random.default_rng([seed, 2, number])
        v = {i: rng.standard_normal(inputs[i].shape) for i in chosen}
        terms = [claims[i] * v[i] for i in chosen]
        claimed = float(sum(t.sum() for t in terms))
        size = float(sum(np.abs(t).sum() for t in terms)) / np.sqrt(max(1, sum(t.size for t in terms)))

        def along(h):
            return _weighted(f, dy, [x + h * v[i] if i in v else x for i, x in enumerate(inputs)])

        found, allowed = extrapolate(along)[0], tolerance
        if not abs(found - claimed) <= allowed * max(abs(found), size) and has_kink(along):
            found, allowed = extrapolate(along, CLOSE_STEPS)[0], NEAR_KINK
        if not abs(found - claimed) <= allowed * max(abs(found), size, np.finfo(float).tiny):
            raise GradientError(f"along random direction {number}: {describe(claimed, found, allowed * max(abs(found), size))}; the central differences disagree; "
                                f"see it again with seed={seed}")
        slope = remainder_slope(along, claimed)
        if slope is not None and slope < 1.8:
            raise GradientError(f"along random direction {number}: the Taylor remainder falls as h^{slope:.2f}, needed h^2; "
                                f"see it again with seed={seed}")


def check_kink(f, f_backward, *inputs, direction, wrt=0, seed=0, tolerance=1e-6):
    """At a kink: the derivatives to both sides along a direction bracket the claimed one.

    direction : array like inputs[wrt]   ->  left, claimed, right derivative.   Raises GradientError.
    """
    dy = upstream(f, inputs, seed)
    claimed = float(np.sum(_claims(f_backward, dy, inputs, _names(None, inputs))[wrt] * direction))
    here = _weighted(f, dy, inputs)

    def moved(h):
        return _weighted(f, dy, [x + h * direction if i == wrt else x for i, x in enumerate(inputs)])

    h = 1e-7
    left, right = (here - moved(-h)) / h, (moved(h) - here) / h
    slack = tolerance * max(abs(left), abs(right), 1.0)
    if not min(left, right) - slack <= claimed <= max(left, right) + slack:
        raise GradientError(f"at the kink: found {claimed:.6g}, needed a value between the one-sided derivatives {left:.6g} and {right:.6g}")
    return left, claimed, right


def upstream(f, inputs, seed):
    """A random upstream gradient of the shape of the output, float64, the same for the same seed."""
    return np.random.default_rng(seed).standard_normal(np.shape(f(*inputs)))


def differentiable(inputs):
    """Indices of the inputs that have a gradient: arrays of floating-point numbers."""
    return [i for i, x in enumerate(inputs) if isinstance(x, np.ndarray) and x.dtype.kind == "f"]


def complex_step(f, dy, inputs, i, index):
    """Derivative of sum(dy f) with respect to one element, to the last digits; None when f is not analytic there."""
    x = inputs[i].astype(np.result_type(inputs[i], np.complex64))
    x[index] += 1j * COMPLEX_STEP
    try:
        y = f(*inputs[:i], x, *inputs[i + 1:])
    except (ValueError, TypeError):
        return None
    return float(np.sum(dy * np.imag(y))) / COMPLEX_STEP if np.iscomplexobj(y) else None


def extrapolate(phi, steps=STEPS):
    r"""Derivative of phi at 0 by central differences with steps h, extrapolated to h = 0 (Richardson, Ridders):

        D_0(h) = (phi(h) - phi(-h)) / 2 h,    D_k(h) = D_{k-1}(h) + (D_{k-1}(h) - D_{k-1}(4 h)) / (16^k - 1)

    The entry in least doubt is taken: large steps meet kinks (neighbours differ), small ones meet rounding (of phi, divided by h).

    ->  derivative, its doubt
    """
    best, error, previous = np.nan, np.inf, []
    for h in steps:
        up, down = phi(h), phi(-h)
        row = [(up - down) / (2 * h)]
        rounding = np.finfo(float).eps * max(abs(up), abs(down)) / h
        for k, coarser in enumerate(previous, start=1):
            row.append(row[-1] + (row[-1] - coarser) / (16.0 ** k - 1))
            doubt = max(abs(row[-1] - row[-2]), abs(row[-1] - coarser)) + rounding
            if doubt <= error:
                best, error = row[-1], doubt
        previous = row
    return best, error


def has_kink(phi, steps=STEPS):
    """Whether the slopes to both sides differ by an amount that does not shrink with the step, as it does where phi is smooth."""
    here = phi(0.0)
    jumps = np.array([abs(phi(h) - 2 * here + phi(-h)) / h for h in steps])
    rounding = 1e-14 * max(abs(here), abs(phi(steps[0]))) / steps
    return bool(np.any((jumps[1:] > 0.5 * jumps[:-1]) & (jumps[1:] > 10 * rounding[1:])))


def remainder_slope(phi, derivative, steps=(1e-3, 5e-4, 2.5e-4, 1.25e-4)):
    """The power of h with which phi(h) - phi(0) - h derivative falls; None where rounding or a kink hides it or phi is linear."""
    here = phi(0.0)
    remainders = np.array([abs(phi(h) - here - h * derivative) for h in steps])
    rounding = 1e-13 * (abs(here) + abs(derivative) * steps[0])
    if not remainders.min() > 100 * rounding:
        return None
    slopes = np.diff(np.log(remainders)) / np.diff(np.log(steps))
    return float(slopes.mean()) if np.ptp(slopes) < 0.1 else None


def _check_input(f, dy, inputs, i, name, claim, rng, seed):
    """->  Row, message of the worst element or None"""
    x = inputs[i]
    if claim.shape != x.shape:
        raise GradientError(f"{name}: found a gradient of shape {claim.shape}, needed {x.shape}, the input's")
    elements = list(np.ndindex(x.shape))
    if len(elements) > ELEMENTS:
        elements = [elements[e] for e in rng.choice(len(elements), ELEMENTS // 10, replace=False)]
    analytic = bool(elements) and complex_step(f, dy, inputs, i, elements[0]) is not None
    measured = np.array([_measure(f, dy, inputs, i, e, analytic) for e in elements])
    claimed = np.array([claim[e] for e in elements], dtype=float)
    tolerance = ANALYTIC if analytic else NUMERIC
    size = max(np.abs(measured).max(initial=0.0), np.abs(claim).max(initial=0.0), np.finfo(float).tiny)
    bound = tolerance * size
    differences = np.abs(claimed - measured)
    good = differences <= bound
    for e in np.flatnonzero(~good) if not analytic else ():
        phi = _along_element(f, dy, inputs, i, elements[e])
        if has_kink(phi):                                        # a step crossed a kink: measure again, closer than it
            measured[e] = extrapolate(phi, CLOSE_STEPS)[0]
            differences[e] = abs(claimed[e] - measured[e])
            good[e] = differences[e] <= NEAR_KINK * size
    row = Row(name, bool((claimed == measured).all()), bool(good.all()), float(differences.max(initial=0.0)), bound,
              "complex step" if analytic else "central differences", len(elements))
    if good.all():
        return row, None
    worst = int(np.argmax(np.where(np.isnan(differences), np.inf, differences)))
    where = ", ".join(map(str, elements[worst]))
    return row, (f"{name}[{where}]: {describe(claimed[worst], measured[worst], bound)} by {row.instrument}; {int((~good).sum())} of {len(good)} "
                 f"elements are wrong.\nSee it again:\n    dy = np.random.default_rng({seed}).standard_normal(np.shape(f(*inputs)))\n"
                 f"    gradients = f_backward(dy, *inputs)      # the one of {name} at [{where}] should be {measured[worst]!r}")


def _measure(f, dy, inputs, i, index, analytic):
    if analytic:
        derivative = complex_step(f, dy, inputs, i, index)
        if derivative is not None:
            return derivative
    return extrapolate(_along_element(f, dy, inputs, i, index))[0]


def _along_element(f, dy, inputs, i, index):
    """sum(dy f) as a function of a step h of one element."""
    def phi(h):
        x = inputs[i].copy()
        x[index] += h
        return _weighted(f, dy, [*inputs[:i], x, *inputs[i + 1:]])
    return phi


def _weighted(f, dy, inputs):
    return float(np.sum(dy * f(*inputs)))


def _claims(f_backward, dy, inputs, names):
    """{input: claimed gradient}, whether the backward returns one array or a tuple."""
    gradients = f_backward(dy.copy(), *(x.copy() if isinstance(x, np.ndarray) else x for x in inputs))
    gradients = gradients if isinstance(gradients, (tuple, list)) else (gradients,)
    chosen = differentiable(inputs)
    if len(gradients) not in (len(inputs), len(chosen)):
        raise GradientError(f"f_backward: found {len(gradients)} gradients, needed one for each of {', '.join(names)}")
    if len(gradients) == len(inputs):
        gradients = [gradients[i] for i in chosen]
    for i, gradient in zip(chosen, gradients):
        if not isinstance(gradient, (np.ndarray, np.generic)):
            raise GradientError(f"{names[i]}: found a gradient that is {type(gradient).__name__}, needed an array")
    return dict(zip(chosen, map(np.asarray, gradients)))


def _names(names, inputs):
    names = tuple(names) if names is not None else tuple(f"input {i}" for i in range(len(inputs)))
    if len(names) != len(inputs):
        raise ValueError(f"names: found {len(names)}, needed one for each of {len(inputs)} inputs")
    return names
