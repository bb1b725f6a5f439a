r"""Convolution over time, as deep learning means it (a cross-correlation), its adjoint, and the
gradients of both.

The direct form: a sum over the K taps of a filter, each tap one matrix product. It is the
definition; `plain` has the same for the simplest case in the fewest lines, and a faster form must
agree with this one.
"""

from typing import Any

import numpy as np

from .arguments import check_arrays, check_shape, check_whole
from .sums import wide_sum


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
           padding: str | int | tuple = "same", dilation: int = 1, groups: int = 1) -> np.ndarray:
    r"""Cross-correlation along the last axis (Holden 2017, the * of eqs. 1 and 2).

        y[n, o, t] = b[o] + sum_{c, k} w[o, c, k] x[n, c, t stride + k dilation - pad_left]

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
    y = _gather(_pad(x, pad), w, T_out, *steps)
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
    _, pad, steps = check_conv(x, w, b, stride, padding, dilation, groups, dy=dy)
    dx = _crop(_scatter(dy, w, sum(pad) + x.shape[2], *steps), pad[0], x.shape[2])
    dw = _filter_gradient(dy, _pad(x, pad), w.shape, *steps)
    return dx, dw, None if b is None else wide_sum(dy, (0, 2))


def conv_transpose1d(h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
                     padding: str | int | tuple = "same", output_padding: int = 0,
                     dilation: int = 1, groups: int = 1) -> np.ndarray:
    r"""The adjoint of `conv1d` in x, with the same filters (the deconvolution of Holden 2017,
    eq. 2):

        <conv1d(x, w), h> = <x, conv_transpose1d(h, w)>

        x[n, c, s] = b[c] + sum_{o, k, t : t stride + k dilation - pad_left = s}
                            w[o, c, k] h[n, o, t]

    h : (N, O, T), w : (O, C / groups, K), b : (C,) or None
    ->  (N, C, (T - 1) stride + dilation (K - 1) + 1 - pads + output_padding)
    output_padding : with a stride several lengths T of x give the same number of outputs; this
    chooses among them.

    >>> conv_transpose1d(np.array([[[1.0, 2]]]), np.array([[[1.0, 10]]]), stride=2, padding=0)
    array([[[ 1., 10.,  2., 20.]]])
    """
    length, pad, steps = check_transpose(h, w, b, stride, padding, output_padding, dilation,
                                         groups)
    x = _crop(_scatter(h, w, pad[0] + length, *steps), pad[0], length)
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
    _, pad, steps = check_transpose(h, w, b, stride, padding, output_padding, dilation, groups,
                                    dx=dx)
    padded = _pad(dx, pad)
    dh = _gather(padded, w, h.shape[2], *steps)
    dw = _filter_gradient(h, padded, w.shape, *steps)
    return dh, dw, None if b is None else wide_sum(dx, (0, 2))


# The three sums over taps. Tap k of a padded signal is the part of it that filter element k meets:
#     tap_k[t] = padded[t stride + k dilation],   t = 0 .. T_out - 1


def _tap(padded, k, T_out, stride, dilation):
    begin = k * dilation
    return padded[..., begin:begin + (T_out - 1) * stride + 1:stride]


def _taps(padded, K, T_out, stride, dilation):
    """All taps in turn, each with its last axis contiguous, as matrix products need it."""
    for k in range(K):
        tap = _tap(padded, k, T_out, stride, dilation)
        yield tap if stride == 1 else np.ascontiguousarray(tap)


def _filters_by_tap(w, groups):
    """(O, C / g, K)  ->  contiguous (K, g, O / g, C / g)"""
    O, C, K = w.shape
    return np.ascontiguousarray(w.transpose(2, 0, 1)).reshape(K, groups, O // groups, C)


def _gather(padded, w, T_out, stride, dilation, groups):
    """y_t = sum_k W_k tap_k: convolution of a padded signal (N, C, T_padded)  ->  (N, O, T_out)"""
    N, C, length = padded.shape
    padded = padded.reshape(N, groups, C // groups, length)
    filters = _filters_by_tap(w, groups)
    y = np.zeros((N, groups, len(w) // groups, T_out), np.result_type(padded, w))
    product = np.empty_like(y)                                   # one buffer for all taps
    for W_k, tap in zip(filters, _taps(padded, len(filters), T_out, stride, dilation)):
        y += np.matmul(W_k, tap, out=product)      # (g, O / g, C / g) @ (N, g, C / g, T_out)
    return y.reshape(N, len(w), T_out)


def _scatter(h, w, length, stride, dilation, groups):
    """tap_k += W_k^T h: the adjoint of `_gather`.   h (N, O, T)  ->  padded (N, C, >= length)"""
    N, O, T = h.shape
    length = max(length, _full_length(h, w, stride, dilation))
    filters = _filters_by_tap(w, groups)
    h = np.ascontiguousarray(h).reshape(N, groups, O // groups, T)
    padded = np.zeros((N, groups, w.shape[1], length), np.result_type(h, w))
    product = np.empty(padded.shape[:3] + (T,), padded.dtype)
    for k, W_k in enumerate(filters):
        _tap(padded, k, T, stride, dilation)[...] += np.matmul(W_k.swapaxes(1, 2), h, out=product)
    return padded.reshape(N, groups * w.shape[1], length)


def _filter_gradient(dy, padded, shape, stride, dilation, groups):
    """dW_k = dy tap_k^T, clip and frame taken as one long axis: one matrix product a tap.

    ->  (O, C / g, K)
    """
    O, C, K = shape
    N, _, T_out = dy.shape
    rows = np.ascontiguousarray(dy.transpose(1, 0, 2)).reshape(groups, O // groups, N * T_out)
    signal = np.ascontiguousarray(padded.transpose(1, 0, 2))     # (g C / g, N, T_padded)
    dw = np.empty((K, groups, O // groups, C), np.result_type(dy, padded))
    for k in range(K):
        columns = np.ascontiguousarray(_tap(signal, k, T_out, stride, dilation)).reshape(
            groups, C, N * T_out)
        np.matmul(rows, columns.swapaxes(1, 2), out=dw[k])
    return np.ascontiguousarray(dw.reshape(K, O, C).transpose(1, 2, 0))


def _pad(x, pad):
    padded = np.zeros(x.shape[:2] + (pad[0] + x.shape[2] + pad[1],), x.dtype)
    padded[:, :, pad[0]:pad[0] + x.shape[2]] = x
    return padded


def _crop(padded, left, length):
    return np.ascontiguousarray(padded[:, :, left:left + length])


def _full_length(h, w, stride, dilation):
    """Frames that the taps of an output of h's length reach."""
    return (h.shape[2] - 1) * stride + dilation * (w.shape[2] - 1) + 1


def _padding(padding, K, stride, dilation):
    """Zeros to the left and to the right."""
    if isinstance(padding, str) and padding == "valid":
        return 0, 0
    if isinstance(padding, str) and padding == "same":
        if stride != 1:
            raise ValueError(f"padding: found 'same' with stride {stride}, needed stride 1; give "
                             "the zeros as a number or a pair")
        total = dilation * (K - 1)
        return total // 2, total - total // 2
    pair = tuple(padding) if isinstance(padding, (tuple, list)) else (padding, padding)
    whole = [isinstance(p, (int, np.integer)) and not isinstance(p, (bool, np.bool_)) and p >= 0
             for p in pair]
    if len(pair) != 2 or not all(whole):
        raise ValueError(f"padding: found {padding!r}, needed 'same', 'valid', a whole number from "
                         "0 on or a pair of them")
    return check_whole("padding", pair[0], 0), check_whole("padding", pair[1], 0)


def _check_filters(w, stride, dilation, groups):
    """->  stride, dilation, groups as Python's whole numbers, which do not wrap around"""
    stride, dilation = check_whole("stride", stride, 1), check_whole("dilation", dilation, 1)
    groups = check_whole("groups", groups, 1)
    if w.shape[2] < 1 or len(w) % groups or len(w) == 0:
        raise ValueError(f"w: found shape {w.shape}, needed (O, C / groups, K) with K at least "
                         f"1 and O a multiple of groups = {groups}")
    return stride, dilation, groups


def check_conv(x: Any, w: Any, b: Any, stride: Any, padding: Any, dilation: Any, groups: Any,
               dy: Any = None) -> tuple[int, tuple[int, int], tuple[int, int, int]]:
    """Everything that can be wrong with the arguments of `conv1d` and its backward.

    ->  T_out, (pad_left, pad_right), (stride, dilation, groups)

    >>> check_conv(np.zeros((2, 3, 9)), np.zeros((4, 3, 5)), None, 1, "same", 1, 1)
    (9, (2, 2), (1, 1, 1))
    """
    check_arrays(x=x, w=w, b=b, ndim={"x": 3, "w": 3, "b": 1})
    stride, dilation, groups = _check_filters(w, stride, dilation, groups)
    if x.shape[1] != w.shape[1] * groups:
        raise ValueError(f"x: found shape {x.shape}, needed (N, {w.shape[1] * groups}, T) for w of "
                         f"shape {w.shape} and groups = {groups}")
    if b is not None:
        check_shape("b", b, (len(w),), f", one for each output channel of w {w.shape}")
    pad = _padding(padding, w.shape[2], stride, dilation)
    reach = dilation * (w.shape[2] - 1) + 1
    if x.shape[2] < 1 or x.shape[2] + sum(pad) < reach:
        raise ValueError(f"x: found {x.shape[2]} frames and {sum(pad)} of padding, needed at least "
                         f"{reach} for one output of filters {w.shape[2]} wide with dilation "
                         f"{dilation}")
    T_out = (x.shape[2] + sum(pad) - reach) // stride + 1
    if dy is not None:
        check_arrays(x=x, dy=dy)
        check_shape("dy", dy, (len(x), len(w), T_out), ", the shape of the output")
    return T_out, pad, (stride, dilation, groups)


def check_transpose(h: Any, w: Any, b: Any, stride: Any, padding: Any, output_padding: Any,
                    dilation: Any, groups: Any, dx: Any = None,
                    ) -> tuple[int, tuple[int, int], tuple[int, int, int]]:
    """The same for `conv_transpose1d` and its backward.

    ->  length of the output, (pad_left, pad_right), (stride, dilation, groups)

    >>> check_transpose(np.zeros((2, 4, 9)), np.zeros((4, 3, 5)), None, 2, 1, 1, 1, 1)
    (20, (1, 1), (2, 1, 1))
    """
    check_arrays(h=h, w=w, b=b, ndim={"h": 3, "w": 3, "b": 1})
    stride, dilation, groups = _check_filters(w, stride, dilation, groups)
    output_padding = check_whole("output_padding", output_padding, 0)
    if output_padding and output_padding >= max(stride, dilation):
        raise ValueError(f"output_padding: found {output_padding}, needed less than stride "
                         f"{stride} or dilation {dilation}")
    if h.shape[1] != len(w):
        raise ValueError(f"h: found shape {h.shape}, needed (N, {len(w)}, T) for w of shape "
                         f"{w.shape}")
    if b is not None:
        check_shape("b", b, (w.shape[1] * groups,),
                    f", one for each output channel, groups times C / groups of w {w.shape}")
    pad = _padding(padding, w.shape[2], stride, dilation)
    length = _full_length(h, w, stride, dilation) - sum(pad) + output_padding
    if h.shape[2] < 1 or length < 1:
        raise ValueError(f"h: found {h.shape[2]} frames, needed enough for an output; padding "
                         f"{pad} would leave {length} frames")
    if dx is not None:
        check_arrays(h=h, dx=dx)
        check_shape("dx", dx, (len(h), w.shape[1] * groups, length), ", the shape of the output")
    return length, pad, (stride, dilation, groups)
