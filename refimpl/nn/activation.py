"""The activation function."""

import numpy as np

from .arguments import check_arrays


def relu(x: np.ndarray) -> np.ndarray:
    r"""The rectified linear unit,   y = max(x, 0).   Any shape; NaN stays NaN.

    >>> relu(np.array([-1.0, 0.0, 2.0, np.nan]))
    array([ 0.,  0.,  2., nan])
    """
    check_arrays(x=x, real=True)
    return np.maximum(x, x.dtype.type(0))


def relu_backward(dy: np.ndarray, x: np.ndarray) -> np.ndarray:
    r"""dx = dy where x > 0, and 0 elsewhere, also at the kink x = 0 and where x is NaN.

    >>> relu_backward(np.full(4, 5.0), np.array([-1.0, 0.0, 2.0, np.nan]))
    array([0., 0., 5., 0.])
    """
    check_arrays(x=x, dy=dy, real=True, shape=x, because=", the shape of x")
    return np.where(x > 0, dy, dy.dtype.type(0))
