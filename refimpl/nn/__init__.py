"""What is a gradient? Each operation is a pure function `f(x, ...)`, its gradient a pure function
`f_backward(dy, x, ...)` right below it.

`dy` is the upstream gradient, of the shape of the output; the other arguments are those of `f`;
what comes back is one gradient for each array. Nothing is modified or remembered. Batches are `(N,
C, T)`: clips, channels, frames. Numbers are float32, float64, longdouble or, where the mathematics
is analytic, complex; or fractions and sympy's expressions, with which the same text computes
exactly (`arguments.are_exact`).

- `conv`: conv1d and its adjoint conv_transpose1d.
- `pool`: max- and average-pooling and their ways back.   `activation`: relu.
- `gram`: the Gram matrix.   `norms`: sizes and errors.   `adam`: the optimiser.
- `conventions`: kinks, ties and forms, with who does otherwise, as data.

`check_gradient` and its companions live in `refimpl.gradcheck` and are found here too.
"""

import importlib

from . import conventions
from .activation import relu, relu_backward
from .adam import adam_start, adam_step
from .conv import conv1d, conv1d_backward, conv_transpose1d, conv_transpose1d_backward
from .gram import gram, gram_backward
from .norms import (absolute_error, absolute_error_backward, l1, l1_backward, mean_squares,
                    mean_squares_backward, norm, norm_backward, squared_error,
                    squared_error_backward, sum_squares, sum_squares_backward)
from .pool import (avg_depool1d, avg_depool1d_backward, avg_pool1d, avg_pool1d_backward, max_pool1d,
                   max_pool1d_backward, max_pool1d_indices, max_unpool1d, max_unpool1d_backward,
                   random_depool1d, random_depool1d_backward)

_CHECKS = ("GradientError", "check_contract", "check_direction", "check_gradient", "check_kink")
__all__ = [name for name in dir() if not name.startswith("_") and name != "importlib"]


def __getattr__(name):
    """The instruments of `refimpl.gradcheck`, loaded when they are first asked for."""
    if name in _CHECKS:
        return getattr(importlib.import_module("refimpl.gradcheck"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
