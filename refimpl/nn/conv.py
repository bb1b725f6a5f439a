r"""Convolution over time, as deep learning means it (a cross-correlation), its adjoint, and the
gradients of both.

The direct form: a sum over the K taps of a filter, each tap one matrix product. It is the
definition; a faster form must agree with it. Tap k of a padded signal is the part of it that filter
element k meets:

    tap_k[t] = padded[t stride + k dilation],   t = 0 .. T_out - 1

All that follows is   y = sum_k W_k tap_k   and the two ways of walking it backwards.
"""

from typing import Any

import numpy as np

from .arguments import check_arrays, check_whole
from .sums import wide_sum

Geometry = tuple[int, tuple[int, int], tuple[int, int, int]]


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
           padding: str | int | tuple = "same", dilation: int = 1, groups: int = 1) -> np.ndarray:
    r"""Cross-correlation along the last axis, the * in equations 1 and 2 of Holden et al.

        y[n, o, t] = b[o] + sum_{c, k} w[o, c, k] x[n, c, t stride + k dilation - pad_left]

    With stride 1, zeros on both sides and one group it is, in five lines:

        left = (K - 1) // 2
        padded = np.pad(x, ((0, 0), (0, 0), (left, K - 1 - left)))
        y = np.zeros((N, O, T)) + b[:, None]
        for k in range(K):
            y += w[:, :, k] @ padded[:, :, k:k + T]              # (O, C) @ (N, C, T)

    x : (N, C, T), w : (O, C / groups, K), b : (O,) or None  ->  y : (N, O, T_out)
    padding : zeros on both sides: "same" (T_out = T, needs stride 1; of the dilation (K - 1) zeros
    the smaller half goes to the left), "valid" (none), a whole number, or a pair (left, right).
    groups : output channels of one group see the input channels of the same group only.

        T_out = floor((T + pad_left + pad_right - dilation (K - 1) - 1) / stride) + 1

    Raises ValueError for shapes that do not fit, mixed precisions, or a filter too wide to make any
    output.

    >>> conv1d(np.array([[[1.0, 2, 3, 4]]]), np.array([[[1.0, 0, -1]]]))
    array([[[-2., -2., -2.,  3.]]])
    """
    T_out, pad, steps = check_conv(x, w, b, stride, padding, dilation, groups)
    W, taps = _taps(np.pad(x, ((0, 0), (0, 0), pad)), w, T_out, *steps)
    y = sum(map(np.matmul, W, taps))           # W_k @ tap_k   (N, groups, O / groups, T_out)
    y = y.reshape(len(x), len(w), T_out)
    return y if b is None else y + b[:, None]


def conv1d_backward(dy: np.ndarray, x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
                    stride: int = 1, padding: str | int | tuple = "same", dilation: int = 1,
                    groups: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    r"""Each product w x gives its upstream gradient to both factors:

        dx[n, c, s] = sum_{o, k, t : t stride + k dilation - pad_left = s} w[o, c, k] dy[n, o, t]
                      (= conv_transpose1d(dy, w))
        dw[o, c, k] = sum_{n, t} dy[n, o, t] x[n, c, t stride + k dilation - pad_left]
        db[o]       = sum_{n, t} dy[n, o, t]

    dy : (N, O, T_out)  ->  dx (N, C, T), dw (O, C / groups, K), db (O,) or None

    >>> x, w = np.array([[[1.0, 2, 3, 4]]]), np.array([[[1.0, 0, -1]]])
    >>> conv1d_backward(np.ones((1, 1, 4)), x, w)[0]
    array([[[ 1.,  0.,  0., -1.]]])
    """
    _, pad, steps = check_conv(x, w, b, stride, padding, dilation, groups, dy)
    dx = _spread(dy, w, x.shape[2], pad, *steps)
    dw = _filter_gradient(dy, np.pad(x, ((0, 0), (0, 0), pad)), w, *steps)
    return dx, dw, None if b is None else wide_sum(dy, (0, 2))


def conv_transpose1d(h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
                     padding: str | int | tuple = "same", output_padding: int = 0,
                     dilation: int = 1, groups: int = 1) -> np.ndarray:
    r"""The adjoint of `conv1d` in x, with the same filters: the deconvolution in equation 2 of
    Holden et al.

        <conv1d(x, w), h> = <x, conv_transpose1d(h, w)>

        x[n, c, s] = b[c] + sum_{o, k, t : t stride + k dilation - pad_left = s}
                            w[o, c, k] h[n, o, t]

    h : (N, O, T), w : (O, C / groups, K), b : (C,) or None
    ->  (N, C, (T - 1) stride + dilation (K - 1) + 1 - pads + output_padding)
    padding, dilation, groups : as in `conv1d`.   output_padding : with a stride several lengths T
    of x give the same number of outputs; this chooses among them, below stride or below dilation

    >>> conv_transpose1d(np.array([[[1.0, 2]]]), np.array([[[1.0, 10]]]), stride=2, padding=0)
    array([[[ 1., 10.,  2., 20.]]])
    """
    length, pad, steps = check_transpose(h, w, b, stride, padding, output_padding, dilation, groups)
    x = _spread(h, w, length, pad, *steps)
    return x if b is None else x + b[:, None]


def conv_transpose1d_backward(
        dx: np.ndarray, h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
        stride: int = 1, padding: str | int | tuple = "same", output_padding: int = 0,
        dilation: int = 1, groups: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    r"""The adjoint of the adjoint is the convolution itself:

        dh = conv1d(dx, w),
        dw[o, c, k] = sum_{n, t} h[n, o, t] dx[n, c, t stride + k dilation - pad_left],
        db[c] = sum_{n, s} dx[n, c, s]

    dx : the shape of the output  ->  dh (N, O, T), dw (O, C / groups, K), db (C,) or None

    >>> h, w = np.array([[[1.0, 2]]]), np.array([[[1.0, 10]]])
    >>> conv_transpose1d_backward(np.ones((1, 1, 4)), h, w, stride=2, padding=0)[:2]
    (array([[[11., 11.]]]), array([[[3., 3.]]]))
    """
    _, pad, steps = check_transpose(h, w, b, stride, padding, output_padding, dilation, groups, dx)
    padded = np.pad(dx, ((0, 0), (0, 0), pad))
    dh = sum(map(np.matmul, *_taps(padded, w, h.shape[2], *steps))).reshape(h.shape)
    dw = _filter_gradient(h, padded, w, *steps)
    return dh, dw, None if b is None else wide_sum(dx, (0, 2))


def _taps(padded, w, T_out, stride, dilation, groups):
    """The filters W (K, groups, O / groups, C / groups) and what each of them meets, a view of the
    padded signal, taps (K, N, groups, C / groups, T_out)."""
    O, C, K = w.shape
    n, c, t = padded.strides
    W = np.ascontiguousarray(w.transpose(2, 0, 1)).reshape(K, groups, O // groups, C)
    return W, np.lib.stride_tricks.as_strided(
        padded, (K, len(padded), groups, C, T_out), (dilation * t, n, C * c, c, stride * t))


def _spread(h, w, length, pad, stride, dilation, groups):
    """tap_k += W_k^T h.   (N, O, T)  ->  (N, C, length)"""
    padded = np.zeros((len(h), w.shape[1] * groups, length + sum(pad)), np.result_type(h, w))
    h = h.reshape(len(h), groups, len(w) // groups, h.shape[2])      # output channels by group
    for W_k, tap_k in zip(*_taps(padded, w, h.shape[3], stride, dilation, groups)):
        tap_k += W_k.swapaxes(1, 2) @ h
    return np.ascontiguousarray(padded[:, :, pad[0]:pad[0] + length])


def _filter_gradient(dy, padded, w, stride, dilation, groups):
    """dW_k = dy tap_k^T, clip and frame taken as one long axis.   ->  (O, C / groups, K)"""
    (N, O, T_out), C = dy.shape, w.shape[1]
    _, taps = _taps(padded, w, T_out, stride, dilation, groups)
    dy = dy.swapaxes(0, 1).reshape(groups, O // groups, N * T_out)
    columns = (tap_k.reshape(groups, C, N * T_out)               # (groups, C / groups, N T_out)
               for tap_k in taps.transpose(0, 2, 3, 1, 4))
    return np.stack([dy @ column.swapaxes(1, 2) for column in columns], axis=-1).reshape(w.shape)


def check_conv(x: Any, w: Any, b: Any, stride: Any, padding: Any, dilation: Any, groups: Any,
               dy: Any = None, *, adjoint: bool = False, output_padding: Any = 0) -> Geometry:
    """Everything that can be wrong with the arguments of `conv1d` and its backward, or of its
    adjoint, whose x is called h and whose dy is called dx.

    ->  T_out, (pad_left, pad_right), (stride, dilation, groups)

    >>> check_conv(np.zeros((2, 3, 9)), np.zeros((4, 3, 5)), None, 1, "same", 1, 1)
    (9, (2, 2), (1, 1, 1))
    """
    name, upstream = ("h", "dx") if adjoint else ("x", "dy")
    check_arrays(**{name: x}, w=w, b=b, ndim={name: 3, "w": 3, "b": 1})
    stride, dilation, groups, more = map(
        check_whole, ("stride", "dilation", "groups", "output_padding"),
        (stride, dilation, groups, output_padding), (1, 1, 1, 0))
    T, (O, C, K), span = x.shape[2], w.shape, dilation * (w.shape[2] - 1)
    into, out = (O, C * groups) if adjoint else (C * groups, O)
    if K < 1 or O < 1 or O % groups:
        raise ValueError(f"w: found shape {w.shape}, needed (O, C / groups, K) with K at least 1 "
                         f"and O a multiple of groups = {groups}")
    if x.shape[1] != into:
        raise ValueError(f"{name}: found shape {x.shape}, needed (N, {into}, T) for w of shape "
                         f"{w.shape}{'' if adjoint else f' and groups = {groups}'}")
    if b is not None and len(b) != out:
        raise ValueError(f"b: found shape {b.shape}, needed ({out},), one for each output channel"
                         f"{', groups times C / groups' if adjoint else ''} of w {w.shape}")
    if stride != 1 and isinstance(padding, str) and padding == "same":
        raise ValueError(f"padding: found 'same' with stride {stride}, needed stride 1; give the "
                         "zeros as a number or a pair")
    if more >= max(stride, dilation):
        raise ValueError(f"output_padding: found {more}, needed less than stride {stride} or "
                         f"dilation {dilation}")
    named = {"same": (span // 2, span - span // 2), "valid": (0, 0)}
    pad = (named[padding] if isinstance(padding, str) and padding in named
           else check_padding(padding))
    if adjoint:
        T_out = (T - 1) * stride + span + 1 - sum(pad) + more
        fit = f", needed enough for an output; padding {pad} would leave {T_out} frames"
    else:
        T_out = (T + sum(pad) - span - 1) // stride + 1
        fit = (f" and {sum(pad)} of padding, needed at least {span + 1} for one output of filters "
               f"{K} wide with dilation {dilation}")
    if T < 1 or T_out < 1:
        raise ValueError(f"{name}: found {T} frames{fit}")
    if dy is not None:
        check_arrays(**{name: x, upstream: dy}, shape=(len(x), out, T_out))
    return T_out, pad, (stride, dilation, groups)


def check_transpose(h: Any, w: Any, b: Any, stride: Any, padding: Any, output_padding: Any,
                    dilation: Any, groups: Any, dx: Any = None) -> Geometry:
    """The same for `conv_transpose1d` and its backward.

    >>> check_transpose(np.zeros((2, 4, 9)), np.zeros((4, 3, 5)), None, 2, 1, 1, 1, 1)
    (20, (1, 1), (2, 1, 1))
    """
    return check_conv(h, w, b, stride, padding, dilation, groups, dx, adjoint=True,
                      output_padding=output_padding)


def check_padding(padding: Any) -> tuple[int, int]:
    """Zeros to the left and to the right.

    >>> check_padding(2), check_padding((0, 3))
    ((2, 2), (0, 3))
    """
    pair = tuple(padding) if isinstance(padding, (tuple, list)) else (padding, padding)
    if len(pair) != 2 or not all(isinstance(p, (int, np.integer)) and not isinstance(p, bool)
                                 and p >= 0 for p in pair):
        raise ValueError(f"padding: found {padding!r}, needed 'same', 'valid', a whole number from "
                         "0 on or a pair of them")
    return check_whole("padding", pair[0], 0), check_whole("padding", pair[1], 0)


def uniform_filters(rng: np.random.Generator, c_out: int, c_in: int, width: int,
                    dtype: Any = np.float32) -> np.ndarray:
    r"""Initial filters, uniform in +-sqrt(6 / (fan_in + fan_out)).

    fan_in = c_in width, fan_out = c_out width   ->  (c_out, c_in, width)

    >>> bool(np.abs(uniform_filters(np.random.default_rng(0), 4, 2, 25)).max() <= 0.2)
    True
    """
    bound = np.sqrt(6.0 / ((c_in + c_out) * width))
    return rng.uniform(-bound, bound, size=(c_out, c_in, width)).astype(dtype)
