r"""Sums of many numbers: added up in double precision and rounded once; and a scale for large ones.

NumPy adds the leading axes of an array one element after the other, in the array's own precision:
in float32 twenty million ones are then 16,777,216, and the bias gradient of a large batch is off
by 1e-3. In double precision the sum is right to the last digit of float32.
"""

from typing import Any

import numpy as np


def wide_sum(x: np.ndarray, axis: int | tuple[int, ...] | None = None) -> Any:
    r"""sum of x over some axes, added up in float64 (or wider) and rounded once to x's precision.

    x : an array of any shape, real or complex;  axis : one axis or several, all unless given
    ->  the array without these axes, of x's dtype

    >>> float(wide_sum(np.full((1 << 25, 1), 1, "float32"), 0)[0])      # NumPy alone: 16777216.0
    33554432.0
    """
    return np.sum(x, axis=axis, dtype=np.promote_types(x.dtype, np.float64)).astype(x.dtype)


def power_of_two(size: np.ndarray) -> np.ndarray:
    """The power of two at or below each size, and 1 where it is 0, infinite or NaN.

    Dividing by it changes no digit, and what was divided by it neither overflows nor vanishes when
    it is squared.   any shape, real  ->  the same

    >>> power_of_two(np.array([0.0, 3.0, 1e200])).tolist() == [1.0, 2.0, 2.0 ** 664]
    True
    """
    size = np.asarray(size)
    usable = (size > 0) & np.isfinite(size)
    _, exponent = np.frexp(np.where(usable, size, 1))
    return np.ldexp(np.ones_like(size), exponent - 1)
