r"""Measures of size, one number for each clip (all axes but the first), and errors between two arrays.

For complex input the squares are `r^2`, not `|r|^2`: the functions stay analytic, so that the complex step can differentiate them.
"""

import numpy as np

from .arguments import check_arrays, check_shape


def sum_squares(r):
    r"""S[n] = sum r[n]^2.   r : (N, ...)  ->  (N,)"""
    _check(r)
    return np.sum(r * r, axis=_rest(r))


def sum_squares_backward(dS, r):
    r"""dr[n] = 2 r[n] dS[n].   dS : (N,)  ->  (N, ...)"""
    _check(r, dS=dS)
    return 2 * _spread(dS, r) * r


def mean_squares(r):
    r"""M[n] = mean r[n]^2.   r : (N, ...)  ->  (N,)"""
    return sum_squares(r) / _count(r)


def mean_squares_backward(dM, r):
    r"""dr[n] = 2 r[n] dM[n] / number of elements of r[n].   dM : (N,)  ->  (N, ...)"""
    _check(r, dM=dM)
    return sum_squares_backward(dM, r) / _count(r)


def norm(r):
    r"""Euclidean norm (the || || of Holden 2017, eqs. 4 and 5):   y[n] = sqrt(sum r[n]^2)

    r : (N, ...)  ->  (N,). Divided by the largest element first, so that squares neither overflow nor vanish.
    """
    _check(r)
    largest = np.max(np.abs(r), axis=_rest(r), initial=0)
    scale = np.where((largest > 0) & np.isfinite(largest), largest, 1).astype(r.real.dtype)
    return scale * np.sqrt(sum_squares(r / _spread(scale, r)))


def norm_backward(dy, r):
    r"""dr[n] = dy[n] r[n] / ||r[n]||, and 0 where r[n] = 0 (the kink rule).   dy : (N,)  ->  (N, ...)"""
    _check(r, dy=dy)
    y = norm(r)
    return _spread(dy, r) * (r / _spread(np.where(y == 0, r.dtype.type(1), y), r))


def l1(a):
    r"""Sum of absolute values (the sparsity of Holden 2017, eq. 3).   any shape  ->  scalar"""
    check_arrays(a=a, real=True)
    return np.sum(np.abs(a))


def l1_backward(dy, a):
    r"""da = sign(a) dy, 0 at a = 0 (the kink rule).   dy : scalar  ->  the shape of a"""
    check_arrays(a=a, real=True)
    return np.sign(a) * _number("dy", dy, a)


def squared_error(x, y, *, reduction="mean"):
    r"""(x - y)^2 of each element, their mean or their sum.   reduction : "none", "mean" or "sum"   x, y : one shape"""
    _check_pair(x, y)
    return _reduce((x - y) ** 2, reduction)


def squared_error_backward(dloss, x, y, *, reduction="mean"):
    """dx = 2 (x - y) dloss, divided by the number of elements for a mean; dy = -dx.   ->  dx, dy"""
    _check_pair(x, y)
    dx = 2 * (x - y) * _unreduce(dloss, x, reduction)
    return dx, -dx


def absolute_error(x, y, *, reduction="mean"):
    r"""|x - y| of each element, their mean or their sum.   reduction : "none", "mean" or "sum"   x, y : one shape"""
    _check_pair(x, y, real=True)
    return _reduce(np.abs(x - y), reduction)


def absolute_error_backward(dloss, x, y, *, reduction="mean"):
    """dx = sign(x - y) dloss, 0 at x = y (the kink rule), divided by the number of elements for a mean; dy = -dx.   ->  dx, dy"""
    _check_pair(x, y, real=True)
    dx = np.sign(x - y) * _unreduce(dloss, x, reduction)
    return dx, -dx


def _reduce(errors, reduction):
    _check_reduction(reduction, errors)
    return errors if reduction == "none" else errors.sum() if reduction == "sum" else errors.mean()


def _unreduce(dloss, x, reduction):
    """The gradient of one element's error."""
    _check_reduction(reduction, x)
    if reduction == "none":
        check_arrays(x=x, dloss=dloss)
        check_shape("dloss", dloss, x.shape, ", the shape of the output")
        return dloss
    dloss = _number("dloss", dloss, x)
    return dloss / x.real.dtype.type(x.size) if reduction == "mean" else dloss


def _number(name, value, like):
    """The upstream gradient of a scalar, in the precision of an array; a Python number will do."""
    check_shape(name, value, (), ", a number")
    if np.asarray(value).dtype.kind not in ("f", "c", "i", "u"):
        raise ValueError(f"{name}: found {value!r}, needed a number")
    return np.asarray(value).astype(like.real.dtype if np.asarray(value).dtype.kind != "c" else np.result_type(like, np.complex64))[()]


def _check_reduction(reduction, errors):
    if reduction not in ("none", "mean", "sum"):
        raise ValueError(f"reduction: found {reduction!r}, needed 'none', 'mean' or 'sum'")
    if reduction == "mean" and not errors.size:
        raise ValueError(f"x: found shape {errors.shape}, needed at least one element for a mean; use reduction='sum'")


def _check_pair(x, y, real=False):
    check_arrays(x=x, y=y, real=real)
    check_shape("y", y, x.shape, ", the shape of x")


def _check(r, **upstream):
    """upstream : the upstream gradient under its name, if there is one"""
    check_arrays(r=r, **upstream)
    if r.ndim < 1:
        raise ValueError("r: found a scalar, needed shape (N, ...) with one clip a row")
    for name, gradient in upstream.items():
        check_shape(name, gradient, (len(r),), ", one number for each clip")


def _rest(r):
    return tuple(range(1, r.ndim))


def _spread(per_clip, r):
    """(N,)  ->  (N, 1, ..., 1)"""
    return per_clip.reshape(per_clip.shape + (1,) * (r.ndim - 1))


def _count(r):
    count = int(np.prod(r.shape[1:]))
    if not count:
        raise ValueError(f"r: found shape {r.shape}, needed at least one element in each clip for a mean")
    return r.real.dtype.type(count)
