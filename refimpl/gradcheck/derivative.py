r"""Three ways to measure a derivative without knowing how it was derived.

All of them walk through a function's inputs in a straight line,

    along(h) = f(x_0 + h v_0, x_1 + h v_1, ...)

and measure, for an upstream gradient dy of the shape of the output,

    d/dh sum(dy * along(h)) at h = 0

which is the sum of <gradient_i, v_i> over the inputs if the gradients are right. One number is
measured, whatever the size of f: one random line checks all elements of all inputs together.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any
import warnings

import numpy as np

Line = Callable[[Any], np.ndarray]

COMPLEX_STEP = 1e-30
STEPS = 4e-3 * 4.0 ** -np.arange(7)              # of the central differences: 4e-3 ... 1e-6
FAR = 1e8                # an output that does not move over this step does not depend on the line


def line(f: Callable[..., Any], inputs: Sequence[Any],
         directions: Mapping[int, np.ndarray]) -> Line:
    """The straight line through the inputs in directions {i: v_i}; inputs that are not named stay.
    ->  along(h)

    >>> along = line(np.multiply, (np.array([1.0, 2.0]), 3.0), {0: np.array([1.0, 0.0])})
    >>> along(0.5).tolist()
    [4.5, 6.0]
    """
    def _along(h):
        return f(*(x + h * directions[i] if i in directions else x for i, x in enumerate(inputs)))
    return _along


def value_at(along: Line, h: float, here: np.ndarray) -> np.ndarray:
    """along(h), and NaN where the function refuses what lies there.

    here : along(0), for the shape
    """
    try:
        there = np.asarray(along(h))
    except Exception:                            # whatever it is: the function has no value there
        return np.full(np.shape(here), np.nan)
    return there if there.shape == np.shape(here) else np.full(np.shape(here), np.nan)


def complex_step(along: Line, dy: np.ndarray, step: float = COMPLEX_STEP) -> float | None:
    r"""The derivative of an analytic function by a step in the imaginary direction. No difference
    is taken, so nothing cancels and h may be tiny:

        along(i h) = along(0) + i h along'(0) - h^2 / 2 along''(0) - ...

    hence  along'(0) = Im along(i h) / h + O(h^2).

    ->  derivative, or None where the function does not take complex numbers or does not keep them

    >>> complex_step(lambda h: np.exp(h), np.ones(()))
    1.0
    """
    found = complex_step_with_terms(along, dy, step)
    return found and found[0]


def complex_step_with_terms(along: Line, dy: np.ndarray, step: float = COMPLEX_STEP
                            ) -> tuple[float, float] | None:
    """`complex_step`, and the size of what it sums, sum |dy_j dy_j/dh|, to which its rounding is
    relative.

    >>> complex_step_with_terms(lambda h: np.array([h, -h]), np.ones(2))
    (0.0, 2.0)
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")           # NumPy only warns when it drops an imaginary part
        try:
            y = along(1j * step)
        except Exception:                        # whatever it is: this function is for real numbers
            return None
    if not np.iscomplexobj(y):
        return None
    terms = dy * (np.imag(y) / step)
    return float(np.sum(terms)), float(np.abs(terms).sum())


def extrapolate(along: Line, dy: np.ndarray,
                steps: Sequence[float] | np.ndarray = STEPS) -> tuple[float, float]:
    r"""Central differences, which err by h^2, h^4, ..., extrapolated to h = 0 (Richardson; Ridders'
    choice of the best):

        D_0(h) = sum dy (along(h) - along(-h)) / 2 h
        D_k(h) = D_{k-1}(h) + (D_{k-1}(h) - D_{k-1}(4 h)) / (16^k - 1)

    Large steps meet kinks and curvature, small ones rounding: the entry that differs least from its
    neighbours is taken.

    steps : falling by a factor of 4
    ->  derivative, and that difference as an estimate of its error, at least the rounding of f
    over h

    >>> slope, error = extrapolate(lambda h: np.exp(h), np.ones(()))
    >>> abs(slope - 1) < 1e-12, error < 1e-11
    (True, True)
    """
    return extrapolate_with_jump(along, dy, steps)[:2]


def extrapolate_with_jump(along: Line, dy: np.ndarray,
                          steps: Sequence[float] | np.ndarray = STEPS
                          ) -> tuple[float, float, float]:
    """`extrapolate`, and how far the quotients to both sides are apart at the smallest step: at a
    kink, or with one within that step, as far as the slopes.

    >>> slope, _, jump = extrapolate_with_jump(np.abs, np.ones(()))
    >>> slope, jump
    (0.0, 2.0)
    """
    here, smallest = along(0.0), float(np.nextafter(0, 1))
    free = independent(along, here)
    best, error, jump = np.nan, np.inf, np.inf
    previous: list[float] = []
    for h in steps:
        with np.errstate(all="ignore"):
            above, below = value_at(along, h, here), value_at(along, -h, here)
            # output by output: a difference of sums would cost digits
            row = [float(np.sum(dy * (above - below))) / (2 * h)]
            jump = abs(float(np.sum(dy * (above - here))) + float(np.sum(dy * (below - here)))) / h
            still = (above == below) & (above == here)
            lost = np.finfo(float).eps * np.abs(dy * here)
            # what moves is rounded at each step, what does not may have moved by less than a digit
            rounding = (float(np.sum(lost, where=~still)) / h + smallest * len(steps) / h
                        + float(np.sum(lost, where=still & ~free)) / steps[0])
        for k, coarser in enumerate(previous, start=1):
            row.append(row[-1] + (row[-1] - coarser) / (16.0 ** k - 1))
            estimate = max(abs(row[-1] - row[-2]), abs(row[-1] - coarser), rounding)
            if estimate <= error:
                best, error = row[-1], estimate
        previous = row
    return float(best), float(error), float(jump)


def independent(along: Line, here: np.ndarray) -> np.ndarray:
    """Which outputs do not depend on the line at all: not even a very long step moves them.

    >>> x = np.array([1.0, 2.0])
    >>> independent(lambda h: x + np.array([h, 0.0]), x).tolist()
    [False, True]
    """
    with np.errstate(all="ignore"):
        far = [value_at(along, h, here) for h in (FAR, -FAR)]
    return np.asarray((far[0] == here) & (far[1] == here))


def is_analytic(along: Line, dy: np.ndarray, tolerance: float = 1e-6) -> bool:
    r"""Whether the complex step is to be trusted: a function may keep complex numbers and yet not
    be analytic.

    |x|, conjugates and comparisons break the Cauchy-Riemann equations; then the two derivatives
    along a random line differ.

    >>> is_analytic(lambda h: (2.0 + h) ** 2, np.ones(()))
    True
    >>> is_analytic(lambda h: np.conj(2.0 + h), np.ones(()))
    False
    """
    imaginary = complex_step(along, dy)
    if imaginary is None or not np.isfinite(imaginary):
        return False
    real, error = extrapolate(along, dy)
    return abs(real - imaginary) <= tolerance * max(abs(real), abs(imaginary)) + 10 * error


def one_sided(along: Line, dy: np.ndarray, h: float = 1e-7) -> tuple[float, float]:
    """The derivatives to the left and to the right. Their error is of first order, so that
    2 d(h / 2) - d(h) removes most of it.

    >>> [round(slope, 6) for slope in one_sided(np.abs, np.ones(()))]
    [-1.0, 1.0]
    """
    here = along(0.0)

    def _slope(h):
        return float(np.sum(dy * (along(h) - here))) / h
    return 2 * _slope(-h / 2) - _slope(-h), 2 * _slope(h / 2) - _slope(h)


def remainder_slope(along: Line, dy: np.ndarray, derivative: float,
                    steps: Sequence[float] = (1e-3, 5e-4, 2.5e-4, 1.25e-4)) -> float | None:
    r"""The power of h with which Taylor's remainder  along(h) - along(0) - h derivative  falls: 2
    if the derivative is right, 1 if not.

    ->  power, or None where it cannot be told: rounding or a kink hides it, or the function is
    linear

    >>> [round(remainder_slope(np.exp, np.ones(()), slope)) for slope in (1.0, 1.1)]
    [2, 1]
    """
    here = along(0.0)
    rises = [float(np.sum(dy * (value_at(along, h, here) - here))) for h in steps]
    remainders = np.abs(np.array(rises) - np.array(steps) * derivative)
    rounding = 1e-13 * (float(np.sum(np.abs(dy * here))) + abs(derivative) * steps[0])
    if not remainders.min() > 100 * rounding:
        return None
    slopes = np.diff(np.log(remainders)) / np.diff(np.log(steps))
    return float(slopes.mean()) if np.ptp(slopes) < 0.1 else None
