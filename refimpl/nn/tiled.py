r"""The convolutions of `conv`, faster: by the tiles of `plan`.

Same arguments and results as `conv`, which is the definition; strides, dilation, groups, filters
narrower than 8, and arrays that hold NaN or infinity are handed to it. The (N, C, T) arrays that
come back are transposed views of channel-last ones. Who runs the same sizes many times keeps a
`plan.Plan`.

How nearly the same: the rounding error of a frame is that of the loudest frame of its tile (40
frames, say), where the direct form's is its own. On arrays of one size both agree to 1e-13 of the
largest element (float32: 1e-6). Quiet frames beside frames that are `ratio` times as loud, relative
error of the quiet ones:

    ratio                  1e2        1e3        1e6
    float32, tiled         2e-5       2e-4       0.2
    float64, tiled         5e-13      5e-12      5e-9
    float32, direct        4e-7       4e-7       4e-7

Zeros and ones under filters of ones come out as 1e-15 and 1e-7 where the direct form gives 0.
Networks here run on normalised motion, whose frames are all of one size. The same trade is made by
FFT and Winograd kernels.
"""

import numpy as np

from . import conv
from .plan import Plan
from .sums import wide_sum

NARROWEST = 8                                               # filters below this are faster directly


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
           padding: str | int | tuple = "same", dilation: int = 1, groups: int = 1) -> np.ndarray:
    """`conv.conv1d` by tiles.

    >>> x, w = np.arange(24.0).reshape(1, 2, 12), np.arange(48.0).reshape(3, 2, 8)
    >>> np.allclose(conv1d(x, w), conv.conv1d(x, w))
    True
    """
    if not _fits(x, w, stride, dilation, groups):
        return conv.conv1d(x, w, b, stride=stride, padding=padding, dilation=dilation,
                           groups=groups)
    T_out, pad, _ = conv.check_conv(x, w, b, stride, padding, dilation, groups)
    return _correlate(x, w, pad[0], T_out, b)


def conv1d_backward(dy: np.ndarray, x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
                    stride: int = 1, padding: str | int | tuple = "same", dilation: int = 1,
                    groups: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """`conv.conv1d_backward` by tiles.

    >>> x, w, dy = np.ones((1, 2, 12)), np.arange(48.0).reshape(3, 2, 8), np.ones((1, 3, 12))
    >>> np.allclose(conv1d_backward(dy, x, w)[1], conv.conv1d_backward(dy, x, w)[1])
    True
    """
    if not _fits(x, w, stride, dilation, groups, dy):
        return conv.conv1d_backward(dy, x, w, b, stride=stride, padding=padding, dilation=dilation,
                                    groups=groups)
    T_out, pad, _ = conv.check_conv(x, w, b, stride, padding, dilation, groups, dy=dy)
    dx, dw = _backward(dy, x, w, pad[0], T_out)
    return dx, dw, None if b is None else wide_sum(dy, (0, 2))


def conv_transpose1d(h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
                     padding: str | int | tuple = "same", output_padding: int = 0,
                     dilation: int = 1, groups: int = 1) -> np.ndarray:
    """`conv.conv_transpose1d` by tiles: with stride 1 it is a correlation with the filters turned
    round in time.

    >>> h, w = np.arange(36.0).reshape(1, 3, 12), np.arange(48.0).reshape(3, 2, 8)
    >>> np.allclose(conv_transpose1d(h, w), conv.conv_transpose1d(h, w))
    True
    """
    if not _fits(h, w, stride, dilation, groups):
        return conv.conv_transpose1d(
            h, w, b, stride=stride, padding=padding, output_padding=output_padding,
            dilation=dilation, groups=groups)
    length, pad, _ = conv.check_transpose(h, w, b, stride, padding, output_padding, dilation,
                                          groups)
    return _correlate(h, _turned(w), w.shape[2] - 1 - pad[0], length, b)


def conv_transpose1d_backward(
        dx: np.ndarray, h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
        stride: int = 1, padding: str | int | tuple = "same", output_padding: int = 0,
        dilation: int = 1, groups: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """`conv.conv_transpose1d_backward` by tiles.

    >>> h, w, dx = np.ones((1, 3, 12)), np.arange(48.0).reshape(3, 2, 8), np.ones((1, 2, 12))
    >>> direct = conv.conv_transpose1d_backward(dx, h, w)
    >>> np.allclose(conv_transpose1d_backward(dx, h, w)[0], direct[0])
    True
    """
    if not _fits(h, w, stride, dilation, groups, dx):
        return conv.conv_transpose1d_backward(
            dx, h, w, b, stride=stride, padding=padding, output_padding=output_padding,
            dilation=dilation, groups=groups)
    length, pad, _ = conv.check_transpose(h, w, b, stride, padding, output_padding, dilation,
                                          groups, dx=dx)
    dh, d_turned = _backward(dx, h, _turned(w), w.shape[2] - 1 - pad[0], length)
    return dh, _turned(d_turned), None if b is None else wide_sum(dx, (0, 2))


def _fits(x, w, stride, dilation, groups, *others):
    """Whether the tiles serve this call; what they do not serve, or what is wrong, is for
    `conv`."""
    return (all(type(value) is int and value == 1 for value in (stride, dilation, groups))
            and isinstance(w, np.ndarray) and w.ndim == 3 and w.shape[2] >= NARROWEST
            and w.dtype in (np.float32, np.float64)
            and all(isinstance(a, np.ndarray) and a.dtype == w.dtype for a in (x, *others))
            and all(np.isfinite(a).all() for a in (x, w, *others)))


def _turned(w):
    """The filters of the adjoint: input and output channels exchanged, time reversed.

    (O, C, K)  ->  (C, O, K)
    """
    return w.swapaxes(0, 1)[:, :, ::-1]


def _plan(x, w, left, T_out):
    """A plan that holds x."""
    plan = Plan(len(x), x.shape[2], w.shape[1], w.shape[0], w.shape[2], w.dtype, left=left,
                T_out=T_out)
    plan.input[:] = x.swapaxes(1, 2)
    return plan


def _correlate(x, w, left, T_out, b):
    """y[n, o, t] = b[o] + sum_{c, k} w[o, c, k] x[n, c, t + k - left].

    (N, C, T), (O, C, K)  ->  (N, O, T_out)
    """
    plan = _plan(x, w, left, T_out)
    y = plan.forward(plan.spectra(w))
    if b is not None:
        y += b
    return y.swapaxes(1, 2)


def _backward(dy, x, w, left, T_out):
    """Gradients of `_correlate`.   (N, O, T_out)  ->  dx (N, C, T), dw (O, C, K)"""
    plan = _plan(x, w, left, T_out)
    plan.analyse()
    dx, dw = plan.backward(dy.swapaxes(1, 2), plan.spectra(w))
    return dx.swapaxes(1, 2), dw
