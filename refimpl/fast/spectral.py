r"""A convolution plan: overlap-save tiles, and inside a tile the discrete Fourier transform written
as small real matrix products.

A tile of n = L + K - 1 input frames gives L output frames. With the h = n / 2 odd frequencies
w_j = pi (2 j + 1) / n no bin is special: each one is a complex number, and there a correlation is
one complex product a channel pair. Gauss needs three real products for it. For a signal a + i b,
with the filters' c = sum_k w_k cos(w_j k) and d = sum_k w_k sin(w_j k) (a correlation takes the
conjugate spectrum):

    q0 = (a + b) c,    q1 = a (d - c),    q2 = -b (c + d)          Im = q0 + q1,    Re = q0 + q2

    F (n, n)   rows cos(w m), -sin(w m)                            tile to [a; b]
    H (3h, K)  rows c, d - c, -(c + d)                             filters to their three spectra
    G (L, n)   columns 2/n [-sin(w t), cos(w t)]                   [Im; Re] back to time

With K = 25 and n = 64 that is 96 multiplications for 40 outputs of a channel pair, where the direct
form needs 1000. Two steps do everything, each the adjoint of the other, so that the backward pass
is the forward one with the matrices transposed:

    analyse     [s1; s2] = M tile,   s0 = s1 + s2
    synthesise  [s1 + s0; s2 + s0],  tile = M [s1; s2]

Arrays are channel-last and every matrix product writes where the next step reads. The direct
convolution of `conv` is the definition; `tiled` says how nearly both agree. One NaN spreads over
its tile.
"""

import functools
from typing import Any

import numpy as np


class Plan:
    r"""Correlations of one size:

        y[b, t, o] = sum_{c, k} w[o, c, k] x[b, t + k - left, c],   x = 0 outside its frames.

    Put x into `input` (B, T, C); then `forward(spectra)` gives y (B, T_out, O), and after it
    `backward(dy, spectra)` the gradients. All arrays that come back belong to the plan and last
    until its next call: a plan allocates when it is made and never again.

    left : zeros before the first frame (negative: frames skipped);  T_out : frames of y, T unless
    given;  n : frames of a tile, chosen unless given

    >>> plan = Plan(1, 12, 1, 1, 8, float, left=0, T_out=5)
    >>> plan.input[:] = 1
    >>> plan.forward(plan.spectra(np.ones((1, 1, 8)))).round(6)[0, :, 0]
    array([8., 8., 8., 8., 8.])
    """

    def __init__(self, B: int, T: int, C: int, O: int, K: int, dtype: Any, *, left: int,
                 T_out: int | None = None, n: int | None = None) -> None:
        self.shape, self.T_out, self.left = (B, T, C, O, K), T if T_out is None else T_out, left
        self.n = n or best_tile(B, self.T_out, C, O, K)
        self.L = self.n - K + 1
        self.tiles = -(-self.T_out // self.L)
        self.F, self.H, self.G = transforms(K, self.n, np.dtype(dtype).char)
        self.dtype = np.dtype(dtype)
        begin, skip = max(0, left), max(0, -left)
        frames = max(self.tiles * self.L + K - 1, begin + T - skip)
        # With `skip` frames more in front, so that `input` is whole.
        self.padded = np.zeros((B, skip + frames, C), dtype)
        self.input = self.padded[:, begin:begin + T]
        self.signal = _overlapping(self.padded[:, skip:], self.tiles, self.n, self.L)
        self._arrays: dict[tuple, np.ndarray] = {}

    def spectra(self, w: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """The filters' part, which can be kept while they do not change.

        (O, C, K)  ->  (3, h, C, O), which may be part of a wider array
        Filters that lie in memory as (K, C, O) need no copy.
        """
        O, C, K = w.shape
        by_width = np.ascontiguousarray(w.transpose(2, 1, 0))
        out = np.empty((3, self.n // 2, C, O), self.dtype) if out is None else out
        rows = out.reshape(len(self.H), C, O)
        if out.flags.c_contiguous:
            np.matmul(self.H, by_width.reshape(K, C * O), out=rows.reshape(-1, C * O))
        else:
            np.matmul(self.H, by_width.swapaxes(0, 1), out=rows.swapaxes(0, 1))
        return out

    def analyse(self) -> np.ndarray:
        """The spectra of `input`, kept for `backward`.   ->  (3, h, B tiles, C)"""
        X = self._spectrum("X", self.shape[2])
        self._analyse(self.F, self.signal, X)
        return X

    def forward(self, spectra: np.ndarray) -> np.ndarray:
        """y (B, T_out, O) of `input`. The spectra may be `in_columns`."""
        B, O = self.shape[0], spectra[0, 0].size // self.shape[2]
        Y = self._spectrum("Y", O)
        self._multiply(self.analyse(), spectra, Y)
        y = self._array("y", (B, self.tiles, self.L, O))
        self._synthesise(self.G, Y, y)
        return y.reshape(B, self.tiles * self.L, O)[:, :self.T_out]

    def backward(self, dy: np.ndarray, spectra: np.ndarray | None, *, to_input: bool = True,
                 to_filters: bool = True) -> tuple[Any, Any]:
        """dy (B, T_out, O)  ->  dx (B, T, C) or None, dw (O, C, K) or None. The gradient of the
        filters needs `forward` (or `analyse`) before it.

        dy and spectra may be those of some of the O output channels only.
        """
        B, O = self.shape[0], dy.shape[2]
        padded = self._array("dy", (B, self.tiles * self.L, O))
        padded[:, :self.T_out] = dy
        padded[:, self.T_out:] = 0
        dY = self._spectrum("Y", O)
        self._analyse(self.G.T, padded.reshape(B, self.tiles, self.L, O), dY)
        dw = self._filter_gradient(dY) if to_filters else None
        return (self._input_gradient(dY, spectra) if to_input else None), dw

    def _filter_gradient(self, dY):
        """dV = X^T dY for each row of the spectra, then H^T."""
        _, _, C, _, K = self.shape
        O = dY.shape[3]
        dV = self._array("dV", (3, self.n // 2, C, O))
        self._multiply(self._spectrum("X", C).swapaxes(2, 3), dY, dV)
        dw = np.matmul(self.H.T, dV.reshape(len(self.H), C * O), out=self._array("dw", (K, C * O)))
        return dw.reshape(K, C, O).transpose(2, 1, 0)

    def _input_gradient(self, dY, spectra):
        """dX = dY V^T, back to time by F^T, and overlapping tiles added."""
        B, T, C, _, _ = self.shape
        dX = self._spectrum("dX", C)
        self._multiply(dY, spectra.swapaxes(2, 3), dX)
        tiles = self._array("dtiles", (B, self.tiles, self.n, C))
        self._synthesise(self.F.T, dX, tiles)
        dpadded = self._array("dpadded", self.padded.shape)
        dpadded[:] = 0
        begin, skip = max(0, self.left), max(0, -self.left)
        # Each frame lies in ceil(n / L) tiles: first pieces, second pieces ... And clip by clip: of
        # four axes at once NumPy would make a copy.
        for offset in range(0, self.n, self.L):
            width = min(self.L, self.n - offset)
            pieces = _overlapping(dpadded[:, skip + offset:], self.tiles, width, self.L,
                                  writeable=True)
            for one, tile in zip(pieces, tiles[:, :, offset:offset + width]):
                one += tile
        return dpadded[:, begin:begin + T]

    def _analyse(self, M, tiles, spectrum):
        """[s1; s2] = M tile,  s0 = s1 + s2.   (n, r), (B, tiles, r, C)  ->  (3, h, B tiles, C)"""
        B, count, _, C = tiles.shape
        rows = spectrum[1:].reshape(self.n, B, count, C).transpose(1, 2, 0, 3)
        np.matmul(M, tiles, out=rows)
        np.add(spectrum[1], spectrum[2], out=spectrum[0])

    def _synthesise(self, M, spectrum, tiles):
        """[s1 + s0; s2 + s0],  tile = M [s1; s2].

        (r, n), (3, h, B tiles, O)  ->  (B, tiles, r, O)
        """
        B, count, _, O = tiles.shape
        spectrum[1:] += spectrum[0]
        rows = spectrum[1:].reshape(self.n, B, count, O).transpose(1, 2, 0, 3)
        np.matmul(M, rows, out=tiles)

    def _multiply(self, A, B, out):
        """One matrix product for each of the 3h rows, and for each block of columns."""
        rows = len(self.H)
        A, B, out = (a.reshape((rows,) + a.shape[2:]) for a in (A, B, out))
        if B.ndim == 4:
            A, out = A[:, None], out.reshape(rows, -1, *B.shape[1::2]).swapaxes(1, 2)
        np.matmul(A, B, out=out)

    def _spectrum(self, name, channels):
        return self._array(name, (3, self.n // 2, self.shape[0] * self.tiles, channels))

    def _array(self, name, shape):
        if (name, shape) not in self._arrays:
            self._arrays[name, shape] = np.empty(shape, self.dtype)
        return self._arrays[name, shape]


def in_columns(spectra: np.ndarray) -> np.ndarray:
    """Spectra to be kept, in blocks of columns of at most 512 bytes: rows of a power of two of more
    bytes meet in the same few lines of the processor's first cache.

    (3, h, C, O)  ->  (3, h, blocks, C, O / blocks)

    >>> in_columns(np.ones((3, 2, 5, 256), np.float32)).shape
    (3, 2, 2, 5, 128)
    """
    C, O = spectra.shape[2:]
    blocks = -(-O * spectra.itemsize // 512)
    blocks = blocks if O % blocks == 0 else 1
    columns = spectra.reshape(*spectra.shape[:3], blocks, O // blocks)
    return np.ascontiguousarray(columns.swapaxes(2, 3))


def _overlapping(signal, tiles, n, step, *, writeable=False):
    """Windows of a signal, a view.   (B, frames, C)  ->  (B, tiles, n, C)"""
    B, _, C = signal.shape
    s = signal.strides
    return np.lib.stride_tricks.as_strided(
        signal, (B, tiles, n, C), (s[0], step * s[1], s[1], s[2]), writeable=writeable)


@functools.lru_cache(maxsize=64)
def transforms(K: int, n: int, dtype: Any) -> tuple[np.ndarray, ...]:
    """F (n, n), H (3h, K) and G (n - K + 1, n) for filters of width K and tiles of n frames, n
    even.

    >>> [matrix.shape for matrix in transforms(3, 8, "d")]
    [(8, 8), (12, 3), (6, 8)]
    """
    w = np.pi * (2 * np.arange(n // 2)[:, None] + 1) / n
    m, k, t = np.arange(n), np.arange(K), np.arange(n - K + 1)
    c, d = np.cos(w * k), np.sin(w * k)
    F = np.concatenate([np.cos(w * m), -np.sin(w * m)])
    H = np.concatenate([c, d - c, -(c + d)])
    G = 2 / n * np.concatenate([-np.sin(w * t), np.cos(w * t)]).T
    return tuple(np.ascontiguousarray(matrix, dtype=dtype) for matrix in (F, H, G))


def best_tile(B: int, T: int, C: int, O: int, K: int) -> int:
    """The tile with the least work: 3h products of (B tiles, C) with (C, O), whose rows BLAS takes
    by twos and whose (C, O) part costs about as much to fetch as eight rows to multiply
    (measured; the optimum is flat), and the two transforms of each tile.   ->  n, a multiple of 4

    >>> best_tile(8, 240, 64, 64, 25), best_tile(1, 240, 256, 256, 25)
    (64, 48)
    """
    def _cost(n: int) -> float:
        L, rows = n - K + 1, B * -(-T // (n - K + 1))
        return 1.5 * n * (2 * -(-rows // 2) + 8) * C * O + rows * n * (n * C + L * O)
    smallest = 4 * -(-(K + 7) // 4)
    return min(range(smallest, smallest + 8 * K, 4), key=_cost)
