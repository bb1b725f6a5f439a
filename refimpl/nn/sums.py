r"""Sums of many numbers: added up in double precision and rounded once; a scale for large ones;
roots, and directions.

NumPy adds the leading axes of an array one element after the other, in the array's own precision:
in float32 twenty million ones are then 16,777,216, and the bias gradient of a large batch is off
by 1e-3. In double precision the sum is right to the last digit of float32.
"""

from fractions import Fraction
import math
from typing import Any

import numpy as np

from .arguments import in_precision


def wide_sum(x: np.ndarray, axis: int | tuple[int, ...] | None = None) -> Any:
    r"""sum of x over some axes, added up in float64 (or wider) and rounded once to x's precision.

    x : an array of any shape, real or complex;  axis : one axis or several, all unless given
    ->  the array without these axes, of x's dtype

    >>> float(wide_sum(np.full((1 << 25, 1), 1, "float32"), 0)[0])      # NumPy alone: 16777216.0
    33554432.0
    """
    wide = np.promote_types(x.dtype, np.float64)
    total = np.sum(x, axis=axis, dtype=wide)
    return total if wide == x.dtype else total.astype(x.dtype)


def power_of_two(x: np.ndarray, axis: int | tuple[int, ...] | None = None) -> np.ndarray:
    """The power of two at or below the largest size along some axes, and 1 where that is 0,
    infinite or NaN, and for exact numbers.

    Dividing by it changes no digit, and what was divided by it neither overflows nor vanishes when
    it is squared.

    x : an array of any shape;  axis : one axis or several, all unless given
    ->  the array without these axes, real

    >>> power_of_two(np.array([[0.0, 0], [-3, 1], [0, 1e200]]), 1).tolist() == [1, 2, 2.0 ** 664]
    True
    """
    if x.dtype.kind == "O":
        return np.full(np.shape(np.sum(x, axis=axis)), Fraction(1))
    size = np.asarray(np.max(np.abs(x), axis=axis, initial=0))
    usable = (size > 0) & np.isfinite(size)
    _, exponent = np.frexp(np.where(usable, size, 1))
    return np.ldexp(np.ones_like(size), exponent - 1)


def root(x: Any) -> Any:
    """The square root, of exact numbers the exact one.

    any shape  ->  the same.   Raises ValueError for a fraction whose root is none.

    >>> root(np.array([Fraction(9, 4), 0])).tolist()
    [Fraction(3, 2), Fraction(0, 1)]
    """
    return np.frompyfunc(_exact_root, 1, 1)(x) if x.dtype.kind == "O" else np.sqrt(x)


def unit_vectors(v: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions, 0 for a vector of length 0, and lengths. No square on the way overflows, or
    vanishes.

    v : an array of any shape, vectors along an axis
    ->  the same shape, and the same without the axis

    >>> direction, length = unit_vectors(np.array([[3.0, 4.0], [0.0, 0.0]]) * 2.0 ** 700, 1)
    >>> direction.tolist(), (length / 2.0 ** 700).tolist()
    ([[0.6, 0.8], [0.0, 0.0]], [5.0, 0.0])
    """
    with np.errstate(over="ignore", under="ignore"):
        squares = np.sum(v * v, axis=axis)
    real, scale = v.real.dtype, None
    if real != object and not np.all((squares.real > np.finfo(real).tiny / np.finfo(real).eps)
                                     & (squares.real < np.inf)):
        scale = power_of_two(v, axis)
        v = v / np.expand_dims(scale, axis)
        squares = np.sum(v * v, axis=axis)
    length = root(squares)
    direction = v / np.expand_dims(np.where(length == 0, in_precision(1, v), length), axis)
    return direction, length if scale is None else scale * length


def _exact_root(number):
    if not isinstance(number, (Fraction, int)):
        return number ** Fraction(1, 2)                          # an expression
    found = Fraction(math.isqrt(number.numerator), math.isqrt(number.denominator))
    if found * found != number:
        raise ValueError(f"root: found {number}, needed the square of a fraction; take "
                         "floating-point numbers")
    return found
