r"""The convolution of `conv`, faster: overlap-save tiles, and inside a tile the discrete Fourier transform written as small real matrix products.

A tile of n = L + K - 1 input frames gives L output frames. With the n / 2 odd frequencies w_j = pi (2 j + 1) / n no bin is special: each one is a complex number
and the product of two spectra is one complex product a bin. Gauss needs three real products for it, and what they need is folded into the transforms:

    F = [a + b; a; b]                 a = cos(w m), b = -sin(w m),  m = 0 .. n-1     (P, n)   of a tile,     P = 3 n / 2 rows
    H = [c; d - c; c + d]             c = cos(w k), d =  sin(w k),  k = 0 .. K-1     (P, K)   of the filters (d: a correlation conjugates them)
    G = 2/n [cos - sin, -sin, -cos]   of w t,                       t = 0 .. L-1     (L, P)   back to time

    y_tile = G ((F x_tile) * (H w)),   * : for each of the P rows one matrix product over the channels

With K = 25 and n = 64 that is 96 multiplications for 40 outputs of a channel pair, where the direct form needs 1000. Proof by test: `conv` is the definition and
both agree. The backward is the transposed form of the same three matrices.

Same arguments and results as `conv`; strides, dilation, groups and filters narrower than 8 are handed to it. Arrays are computed channel-last, so that every
matrix product writes where the next one reads; the (N, C, T) arrays that come back are transposed views of that.
"""

import functools

import numpy as np

from . import conv

TILE = 64                                                        # frames of a tile for K = 25; the best sizes are flat around it
NARROWEST = 8                                                    # filters below this are faster directly


def conv1d(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    """`conv.conv1d` by tiles."""
    if not _fits(x, w, stride, dilation, groups):
        return conv.conv1d(x, w, b, stride=stride, padding=padding, dilation=dilation, groups=groups)
    T_out, pad = conv.check_conv(x, w, b, stride, padding, dilation, groups)
    y = _correlate(x, w, pad[0], T_out)
    if b is not None:
        y += b
    return y.swapaxes(1, 2)


def conv1d_backward(dy, x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    """`conv.conv1d_backward` by tiles."""
    if not _fits(x, w, stride, dilation, groups):
        return conv.conv1d_backward(dy, x, w, b, stride=stride, padding=padding, dilation=dilation, groups=groups)
    _, pad = conv.check_conv(x, w, b, stride, padding, dilation, groups, dy=dy)
    dx = _correlate(dy, _turned(w), w.shape[2] - 1 - pad[0], x.shape[2]).swapaxes(1, 2)
    return dx, _filter_gradient(dy, x, w, pad[0]), None if b is None else dy.sum(axis=(0, 2))


def conv_transpose1d(h, w, b=None, *, stride=1, padding="same", output_padding=0, dilation=1, groups=1):
    """`conv.conv_transpose1d` by tiles: with stride 1 it is a correlation with the filters turned round in time."""
    if not _fits(h, w, stride, dilation, groups):
        return conv.conv_transpose1d(h, w, b, stride=stride, padding=padding, output_padding=output_padding, dilation=dilation, groups=groups)
    length, pad = conv.check_transpose(h, w, b, stride, padding, output_padding, dilation, groups)
    x = _correlate(h, _turned(w), w.shape[2] - 1 - pad[0], length)
    if b is not None:
        x += b
    return x.swapaxes(1, 2)


def conv_transpose1d_backward(dx, h, w, b=None, *, stride=1, padding="same", output_padding=0, dilation=1, groups=1):
    """`conv.conv_transpose1d_backward` by tiles."""
    if not _fits(h, w, stride, dilation, groups):
        return conv.conv_transpose1d_backward(dx, h, w, b, stride=stride, padding=padding, output_padding=output_padding, dilation=dilation, groups=groups)
    _, pad = conv.check_transpose(h, w, b, stride, padding, output_padding, dilation, groups, dx=dx)
    dh = _correlate(dx, w, pad[0], h.shape[2]).swapaxes(1, 2)
    return dh, _filter_gradient(h, dx, w, pad[0]), None if b is None else dx.sum(axis=(0, 2))


def _fits(x, w, stride, dilation, groups):
    """Whether the tiles serve this call; what they do not serve, or what is wrong, is for `conv`."""
    return (isinstance(w, np.ndarray) and w.dtype == getattr(x, "dtype", None) and w.ndim == 3 and w.shape[2] >= NARROWEST and w.dtype in (np.float32, np.float64)
            and all(type(value) is int and value == 1 for value in (stride, dilation, groups)))


def _turned(w):
    """The filters of the adjoint: input and output channels exchanged, time reversed.   (O, C, K)  ->  (C, O, K)"""
    return w.swapaxes(0, 1)[:, :, ::-1]


@functools.lru_cache(maxsize=64)
def _transforms(K, dtype):
    """F (P, n), H (P, K), G (L, P) for filters of width K."""
    n = max(TILE, 2 * K)                                         # even: the odd frequencies come in pairs
    w = np.pi * (2 * np.arange(n // 2)[:, None] + 1) / n
    a, b = np.cos(w * np.arange(n)), -np.sin(w * np.arange(n))
    c, d = np.cos(w * np.arange(K)), np.sin(w * np.arange(K))
    t = w * np.arange(n - K + 1)
    F = np.concatenate([a + b, a, b])
    H = np.concatenate([c, d - c, c + d])
    G = 2 / n * np.concatenate([np.cos(t) - np.sin(t), -np.sin(t), -np.cos(t)]).T
    return tuple(np.ascontiguousarray(matrix, dtype=dtype) for matrix in (F, H, G))


def _tiles(x, left, T_out, n, L):
    """A padded channel-last copy of x and its overlapping tiles, a view.   (N, C, T)  ->  (N, tiles, n, C)"""
    N, C, T = x.shape
    tiles = -(-T_out // L)
    padded = np.zeros((N, tiles * L + n - L, C), x.dtype)
    begin, first = max(0, left), max(0, -left)                   # a negative pad crops, as the adjoint of a wide padding does
    length = max(0, min(T - first, padded.shape[1] - begin))
    padded[:, begin:begin + length] = x[:, :, first:first + length].swapaxes(1, 2)
    s = padded.strides
    return np.lib.stride_tricks.as_strided(padded, (N, tiles, n, C), (s[0], L * s[1], s[1], s[2]), writeable=False)


def _spectra(F, tiles):
    """F applied to every tile, frequency first.   (P, n), (N, tiles, n, C)  ->  (P, N tiles, C)"""
    N, count, _, C = tiles.shape
    spectra = np.empty((len(F), N, count, C), tiles.dtype)
    np.matmul(F, tiles, out=spectra.transpose(1, 2, 0, 3))
    return spectra.reshape(len(F), N * count, C)


def _correlate(x, w, left, T_out):
    """y[n, t, o] = sum_{c, k} w[o, c, k] x[n, c, t + k - left].   (N, C, T), (O, C, K)  ->  (N, T_out, O)"""
    O, C, K = w.shape
    F, H, G = _transforms(K, w.dtype.char)
    n, L = F.shape[1], len(G)
    tiles = _tiles(x, left, T_out, n, L)
    N, count = tiles.shape[:2]
    filters = (H @ np.ascontiguousarray(w.transpose(2, 1, 0)).reshape(K, C * O)).reshape(len(F), C, O)       # (P, C, O)
    product = (_spectra(F, tiles) @ filters).reshape(len(F), N, count, O)                                    # (P, N, tiles, O)
    y = np.empty((N, count, L, O), w.dtype)
    np.matmul(G, product.transpose(1, 2, 0, 3), out=y)
    return y.reshape(N, count * L, O)[:, :T_out]


def _filter_gradient(dy, x, w, left):
    """dw[o, c, k] = sum_{n, t} dy[n, o, t] x[n, c, t + k - left]:  for each row of the spectra one product over tiles, then H^T."""
    O, C, K = w.shape
    F, H, G = _transforms(K, w.dtype.char)
    n, L = F.shape[1], len(G)
    inputs = _spectra(F, _tiles(x, left, dy.shape[2], n, L))                                             # (P, M, C)
    outputs = _spectra(np.ascontiguousarray(G.T), _tiles(dy, 0, dy.shape[2], L, L))                      # (P, M, O)
    spectra = inputs.swapaxes(1, 2) @ outputs                                                            # (P, C, O)
    dw = H.T @ spectra.reshape(len(F), C * O)                                                            # (K, C O)
    return np.ascontiguousarray(dw.reshape(K, C, O).transpose(2, 1, 0))
