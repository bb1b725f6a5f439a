r"""The convolutions of `nn.conv`, faster: by the tiles of `spectral`.

Same arguments and results as `nn.conv`, which is the definition; strides, dilation, groups, filters
narrower than `narrowest` (8), and arrays that hold NaN or infinity are handed to it. The (N, C, T)
arrays that come back are transposed views of channel-last ones. Who runs the same sizes many times
keeps a `spectral.Plan`.

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

from typing import Any

import numpy as np

from ..nn import conv
from ..nn.sums import wide_sum
from .spectral import Plan

NARROWEST = 8                                     # filters below this are faster directly


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
           narrowest: int = NARROWEST, **options: Any) -> np.ndarray:
    """`nn.conv1d` by tiles, with its options.

    >>> x, w = np.arange(24.0).reshape(1, 2, 12), np.arange(48.0).reshape(3, 2, 8)
    >>> np.allclose(conv1d(x, w), conv.conv1d(x, w))
    True
    """
    if not _fits(narrowest, options, w, x):
        return conv.conv1d(x, w, b, **options)
    T_out, pad, _ = conv.check_conv(x, w, b, 1, options.get("padding", "same"), 1, 1)
    return _correlate(x, w, pad[0], T_out, b)


def conv1d_backward(dy: np.ndarray, x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
                    narrowest: int = NARROWEST, **options: Any,
                    ) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """`nn.conv1d_backward` by tiles, with its options.

    >>> x, w, dy = np.ones((1, 2, 12)), np.arange(48.0).reshape(3, 2, 8), np.ones((1, 3, 12))
    >>> np.allclose(conv1d_backward(dy, x, w)[1], conv.conv1d_backward(dy, x, w)[1])
    True
    """
    if not _fits(narrowest, options, w, x, dy):
        return conv.conv1d_backward(dy, x, w, b, **options)
    T_out, pad, _ = conv.check_conv(x, w, b, 1, options.get("padding", "same"), 1, 1, dy=dy)
    dx, dw = _backward(dy, x, w, pad[0], T_out)
    return dx, dw, None if b is None else wide_sum(dy, (0, 2))


def conv_transpose1d(h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *,
                     narrowest: int = NARROWEST, **options: Any) -> np.ndarray:
    """`nn.conv_transpose1d` by tiles, with its options: with stride 1 it is a correlation with the
    filters turned round in time.

    >>> h, w = np.arange(36.0).reshape(1, 3, 12), np.arange(48.0).reshape(3, 2, 8)
    >>> np.allclose(conv_transpose1d(h, w), conv.conv_transpose1d(h, w))
    True
    """
    if not _fits(narrowest, options, w, h):
        return conv.conv_transpose1d(h, w, b, **options)
    length, pad = _transpose_sizes(h, w, b, options)
    return _correlate(h, _turned(w), w.shape[2] - 1 - pad, length, b)


def conv_transpose1d_backward(dx: np.ndarray, h: np.ndarray, w: np.ndarray,
                              b: np.ndarray | None = None, *, narrowest: int = NARROWEST,
                              **options: Any,
                              ) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """`nn.conv_transpose1d_backward` by tiles, with its options.

    >>> h, w, dx = np.ones((1, 3, 12)), np.arange(48.0).reshape(3, 2, 8), np.ones((1, 2, 12))
    >>> direct = conv.conv_transpose1d_backward(dx, h, w)
    >>> np.allclose(conv_transpose1d_backward(dx, h, w)[0], direct[0])
    True
    """
    if not _fits(narrowest, options, w, h, dx):
        return conv.conv_transpose1d_backward(dx, h, w, b, **options)
    length, pad = _transpose_sizes(h, w, b, options, dx)
    dh, d_turned = _backward(dx, h, _turned(w), w.shape[2] - 1 - pad, length)
    return dh, _turned(d_turned), None if b is None else wide_sum(dx, (0, 2))


def _fits(narrowest, options, w, *others):
    """Whether the tiles serve this call; what they do not serve, or what is wrong, is for
    `nn.conv`."""
    ones = [options.get(name, 1) for name in ("stride", "dilation", "groups")]
    return (all(type(value) is int and value == 1 for value in ones)
            and isinstance(w, np.ndarray) and w.ndim == 3 and w.shape[2] >= narrowest
            and w.dtype in (np.float32, np.float64)
            and all(isinstance(a, np.ndarray) and a.dtype == w.dtype for a in others)
            and all(np.isfinite(a).all() for a in (w, *others)))


def _transpose_sizes(h, w, b, options, dx=None):
    """->  frames of the output, zeros on its left"""
    length, pad, _ = conv.check_transpose(h, w, b, 1, options.get("padding", "same"),
                                          options.get("output_padding", 0), 1, 1, dx=dx)
    return length, pad[0]


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
