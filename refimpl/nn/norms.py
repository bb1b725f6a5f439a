r"""Measures of size, one number for each clip (all axes but the first), and errors between two
arrays.

For complex input the squares are `r^2`, not `|r|^2`: the functions stay analytic, so that the
complex step can differentiate them.

No norm, sum or mean overflows or vanishes before its own result does: the numbers are first divided
by the power of two next to the largest of them, which changes no digit, and are added up in double
precision. (Of two arrays x and y the difference x - y itself must be a number that can be held.)
"""

import math
from typing import Any

import numpy as np

from .arguments import are_exact, check_arrays, check_shape, in_precision
from .sums import power_of_two, root, wide_sum


def sum_squares(r: np.ndarray) -> np.ndarray:
    r"""S[n] = sum r[n]^2.   r : (N, ...)  ->  (N,)

    >>> sum_squares(np.array([[3.0, 4.0], [0.0, 2.0]]))
    array([25.,  4.])
    """
    scale, _, squares = _scaled(r)
    return squares * scale * scale


def sum_squares_backward(dS: np.ndarray, r: np.ndarray) -> np.ndarray:
    r"""dr[n] = 2 r[n] dS[n].   dS : (N,)  ->  (N, ...)

    >>> sum_squares_backward(np.array([1.0]), np.array([[3.0, 4.0]]))
    array([[6., 8.]])
    """
    _check(r, dS=dS)
    return 2 * (_spread(dS, r) * r)


def mean_squares(r: np.ndarray) -> np.ndarray:
    r"""M[n] = mean r[n]^2.   r : (N, ...), at least one element in each clip  ->  (N,)

    >>> mean_squares(np.array([[3.0, 4.0]]))
    array([12.5])
    """
    scale, _, squares = _scaled(r, mean=True)
    return squares / math.prod(r.shape[1:]) * scale * scale


def mean_squares_backward(dM: np.ndarray, r: np.ndarray) -> np.ndarray:
    r"""dr[n] = 2 r[n] dM[n] / number of elements of r[n].   dM : (N,)  ->  (N, ...)

    >>> mean_squares_backward(np.array([1.0]), np.array([[3.0, 4.0]]))
    array([[3., 4.]])
    """
    _check(r, mean=True, dM=dM)
    return 2 * _share(r, _spread(dM, r), math.prod(r.shape[1:]))


def norm(r: np.ndarray) -> np.ndarray:
    r"""The Euclidean norm, the bars in the content and style losses of Holden et al.:

        y[n] = sqrt(sum r[n]^2)

    r : (N, ...)  ->  (N,)

    >>> norm(np.array([[3.0, 4.0], [0.0, 0.0]]))
    array([5., 0.])
    >>> norm(np.array([[3e200, 4e200]]))                      # 9e400 would be infinite
    array([5.e+200])
    """
    scale, _, squares = _scaled(r)
    return scale * root(squares)


def norm_backward(dy: np.ndarray, r: np.ndarray) -> np.ndarray:
    r"""dr[n] = dy[n] r[n] / ||r[n]||, and 0 where r[n] = 0 (the kink rule).

    dy : (N,)  ->  (N, ...)

    >>> norm_backward(np.array([1.0]), np.array([[3.0, 4.0]]))
    array([[0.6, 0.8]])
    """
    _check(r, dy=dy)
    _, part, squares = _scaled(r)
    y = root(squares)                                      # of r divided by its scale, as `part` is
    return _spread(dy, r) * (part / _spread(np.where(y == 0, r.dtype.type(1), y), r))


def l1(a: np.ndarray) -> Any:
    r"""Sum of absolute values (the sparsity of the autoencoder's loss).   any shape  ->  scalar

    >>> float(l1(np.array([-3.0, 0.0, 5.0])))
    8.0
    """
    check_arrays(a=a, real=True)
    return wide_sum(np.abs(a))


def l1_backward(dy: Any, a: np.ndarray) -> np.ndarray:
    r"""da = sign(a) dy, 0 at a = 0 (the kink rule), NaN at NaN.   dy : scalar  ->  the shape of a

    >>> l1_backward(2.0, np.array([-3.0, 0.0, 5.0]))
    array([-2.,  0.,  2.])
    """
    check_arrays(a=a, real=True)
    return np.sign(a) * _number("dy", dy, a)


def squared_error(x: np.ndarray, y: np.ndarray, *, reduction: str = "mean") -> Any:
    r"""(x - y)^2 of each element, their mean or their sum.

    x, y : one shape;  reduction : "none", "mean" or "sum"  ->  that shape, or a scalar

    >>> float(squared_error(np.array([1.0, 2.0]), np.array([1.0, 4.0])))
    2.0
    """
    _check_pair(x, y, reduction)
    if reduction == "none":
        return (x - y) * (x - y)
    return (mean_squares if reduction == "mean" else sum_squares)((x - y)[None])[0]


def squared_error_backward(dloss: Any, x: np.ndarray, y: np.ndarray, *,
                           reduction: str = "mean") -> tuple[np.ndarray, np.ndarray]:
    """dx = 2 (x - y) dloss, divided by the number of elements for a mean; dy = -dx.   ->  dx, dy

    >>> squared_error_backward(1.0, np.array([1.0, 2.0]), np.array([1.0, 4.0]))[0]
    array([ 0., -2.])
    """
    _check_pair(x, y, reduction)
    upstream, count = _upstream(dloss, x, reduction)
    dx = 2 * _share(x - y, upstream, count)
    return dx, -dx


def absolute_error(x: np.ndarray, y: np.ndarray, *, reduction: str = "mean") -> Any:
    r"""|x - y| of each element, their mean or their sum.

    x, y : one shape;  reduction : "none", "mean" or "sum"  ->  that shape, or a scalar

    >>> float(absolute_error(np.array([1.0, 2.0]), np.array([1.0, 4.0])))
    1.0
    """
    _check_pair(x, y, reduction, real=True)
    errors = np.abs(x - y)
    if reduction == "none":
        return errors
    scale = power_of_two(errors)
    return wide_sum(errors / scale) / (x.size if reduction == "mean" else 1) * scale


def absolute_error_backward(dloss: Any, x: np.ndarray, y: np.ndarray, *,
                            reduction: str = "mean") -> tuple[np.ndarray, np.ndarray]:
    """dx = sign(x - y) dloss, divided by the number of elements for a mean; dy = -dx.   ->  dx, dy

    At x = y it is 0 (the kink rule).

    >>> absolute_error_backward(1.0, np.array([1.0, 2.0]), np.array([1.0, 4.0]))[0]
    array([ 0. , -0.5])
    """
    _check_pair(x, y, reduction, real=True)
    upstream, count = _upstream(dloss, x, reduction)
    dx = np.sign(x - y) * (upstream / in_precision(count, x))
    return dx, -dx


def _scaled(r, mean=False):
    """The power of two next to the largest element of each clip (N,), r divided by it (N, ...), and
    the sum of the squares of that (N,)."""
    _check(r, mean)
    rest = tuple(range(1, r.ndim))
    scale = power_of_two(r, rest)
    part = r / _spread(scale, r)
    return scale, part, wide_sum(part * part, rest)


def _spread(per_clip, r):
    """(N,)  ->  (N, 1, ..., 1)"""
    return per_clip.reshape(per_clip.shape + (1,) * (r.ndim - 1))


def _upstream(dloss, x, reduction):
    """The upstream gradient, and the number of elements that share it."""
    if reduction == "none":
        check_arrays(x=x, dloss=dloss, shape=x.shape)
        return dloss, 1
    return _number("dloss", dloss, x), x.size if reduction == "mean" else 1


def _share(r, upstream, count):
    """r upstream / count. A large upstream gradient is divided before the product, which might
    overflow, a small one after it, for it might have few digits left."""
    if r.dtype.kind == "O":
        return r * upstream / in_precision(count, r)
    before = np.where(np.abs(upstream) < 1, 1, count).astype(r.real.dtype)
    return r * (upstream / before) / (count / before)


def _number(name, value, like):
    """The upstream gradient of a scalar, in the precision of an array; a Python number will do."""
    check_shape(name, value, (), ", a number")
    number = np.asarray(value)
    if like.dtype.kind == "O":
        if number.dtype.kind not in "iu" and not are_exact(number):
            raise ValueError(f"{name}: found {value!r}, needed an exact number")
        return in_precision(number, like)
    if number.dtype.kind not in "fciu":
        raise ValueError(f"{name}: found {value!r}, needed a number")
    least = np.complex64 if number.dtype.kind == "c" else np.float32
    return number.astype(np.result_type(like.real.dtype, least))[()]


def _check(r, mean=False, **upstream):
    """upstream : the upstream gradient under its name, if there is one"""
    check_arrays(r=r)
    if r.ndim < 1:
        raise ValueError("r: found a scalar, needed shape (N, ...) with one clip a row")
    for name, gradient in upstream.items():
        check_arrays(r=r, **{name: gradient}, shape=r.shape[:1],
                     because=", one number for each clip")
    if mean and not math.prod(r.shape[1:]):
        raise ValueError(f"r: found shape {r.shape}, needed at least one element in each clip for "
                         "a mean")


def _check_pair(x, y, reduction, real=False):
    check_arrays(x=x, y=y, real=real, shape=x, because=", the shape of x")
    if reduction not in ("none", "mean", "sum"):
        raise ValueError(f"reduction: found {reduction!r}, needed 'none', 'mean' or 'sum'")
    if reduction == "mean" and not x.size:
        raise ValueError(f"x: found shape {x.shape}, needed at least one element for a mean; "
                         "use reduction='sum'")
