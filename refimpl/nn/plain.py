r"""The plain convolution, as one first reads it: stride 1, zeros so that the output is as long as
the input, no groups.

`conv.conv1d` with its defaults gives the same numbers (tested); this one is for reading.
"""

import numpy as np

from .sums import wide_sum


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray) -> np.ndarray:
    r"""y[n, o, t] = b[o] + sum_{c, k} w[o, c, k] x[n, c, t + k - left],
    left = (K - 1) // 2, x = 0 outside

    x : (N, C, T), w : (O, C, K), b : (O,)  ->  (N, O, T)

    >>> conv1d(np.array([[[1.0, 2, 3, 4]]]), np.array([[[1.0, 0, -1]]]), np.zeros(1))
    array([[[-2., -2., -2.,  3.]]])
    """
    N, C, T = x.shape
    O, C, K = w.shape
    left = (K - 1) // 2
    padded = np.pad(x, ((0, 0), (0, 0), (left, K - 1 - left)))
    y = np.zeros((N, O, T), x.dtype) + b[:, None]
    for k in range(K):
        y += w[:, :, k] @ padded[:, :, k:k + T]                  # (O, C) @ (N, C, T)
    return y


def conv1d_backward(dy: np.ndarray, x: np.ndarray, w: np.ndarray,
                    b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    r"""Follow each product of the forward pass back to its two factors.

    y += w_k @ tap_k   hence   dtap_k += w_k^T @ dy   and   dw_k += sum_n dy_n @ tap_k,n^T

    dy : (N, O, T)  ->  dx (N, C, T), dw (O, C, K), db (O,)

    >>> x, w = np.array([[[1.0, 2, 3, 4]]]), np.array([[[1.0, 0, -1]]])
    >>> conv1d_backward(np.ones((1, 1, 4)), x, w, np.zeros(1))[0]
    array([[[ 1.,  0.,  0., -1.]]])
    """
    N, C, T = x.shape
    O, C, K = w.shape
    left = (K - 1) // 2
    padded = np.pad(x, ((0, 0), (0, 0), (left, K - 1 - left)))
    dpadded, dw = np.zeros_like(padded), np.zeros_like(w)
    for k in range(K):
        dpadded[:, :, k:k + T] += w[:, :, k].T @ dy
        dw[:, :, k] = wide_sum(dy @ padded[:, :, k:k + T].swapaxes(1, 2), 0)
    return dpadded[:, :, left:left + T], dw, wide_sum(dy, (0, 2))
