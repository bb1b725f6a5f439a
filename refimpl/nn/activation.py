"""The activation function."""

import numpy as np

from .arguments import check_arrays, check_shape


def relu(x):
    r"""Rectified linear unit:   y = max(x, 0).   Any shape; NaN stays NaN."""
    check_arrays(x=x, real=True)
    return np.maximum(x, x.dtype.type(0))


def relu_backward(dy, x):
    r"""dx = dy where x > 0, and 0 elsewhere, also at the kink x = 0 and where x is NaN."""
    check_arrays(x=x, dy=dy, real=True)
    check_shape("dy", dy, x.shape, ", the shape of x")
    return np.where(x > 0, dy, dy.dtype.type(0))
