r"""The decoder at half resolution: what `networks.decode` says at full resolution, with half the
frames and 13 taps instead of 25.

Average-depooling gives both frames of a pair the same value, so each of two neighbouring taps of a
filter meets it:

    D[2u] = D[2u+1] = E[u],   E = H / 2 - b0
    X[c, 2u + r] = sum_{m, k} W0[m, c, K-1-k] D[m, 2u + r + k - l]
                 = sum_{m, j} V[(r, c), m, j] E[m, u + j - left],
    V[(r, c), m, j] = sum over k with (r + k - l) // 2 = j - left of W0[m, c, K-1-k],
    l = K - 1 - (K - 1) // 2,   r = 0 or 1

One correlation to 132 channels, 66 for the even frames and 66 for the odd ones, which lie beside
each other in channel-last order as they should.
"""

import numpy as np


def taps(K: int) -> tuple[np.ndarray, int, int]:
    """Where each tap of a filter goes.

    ->  j (2, K) for the even and odd frames, number of half-resolution taps, zeros before the first
    frame

    >>> taps(25)[1:]
    (13, 6)
    """
    reach = K - 1 - (K - 1) // 2
    j = (np.arange(2)[:, None] + np.arange(K) - reach) // 2
    return j - j.min(), int(j.max() - j.min()) + 1, int(-j.min())


def half_filters(W0: np.ndarray) -> np.ndarray:
    """V of the equation above.   (m, C, K)  ->  (2 C, m, taps)

    >>> half_filters(np.array([[[1.0, 2, 3]]])).tolist()
    [[[3.0, 3.0, 0.0]], [[0.0, 5.0, 1.0]]]
    """
    m, C, K = W0.shape
    j, count, _ = taps(K)
    V = np.zeros((count, 2, m, C), W0.dtype)
    by_tap = W0[:, :, ::-1].transpose(2, 0, 1)                   # (K, m, C)
    for r in (0, 1):
        for k in range(K):
            V[j[r, k], r] += by_tap[k]
    return V.transpose(1, 3, 2, 0).reshape(2 * C, m, count)


def half_filters_backward(dV: np.ndarray, K: int) -> np.ndarray:
    """Every tap gets the gradient of its sum, for even and odd frames.

    (2 C, m, taps)  ->  (m, C, K)
    """
    _, m, count = dV.shape
    j, _, _ = taps(K)
    by_tap = dV.reshape(2, -1, m, count).transpose(0, 3, 2, 1)   # (2, taps, m, C)
    dW0 = by_tap[0, j[0]] + by_tap[1, j[1]]                      # (K, m, C)
    return dW0.transpose(1, 2, 0)[:, :, ::-1]


def pool_into(Z: np.ndarray, H: np.ndarray, first: np.ndarray, active: np.ndarray) -> None:
    """H = relu(max-pool(Z)); where the first of a pair is the largest (the tie rule), and where H
    is above 0.   Z : (B, T, m)  ->  (B, T / 2, m)"""
    even, odd = Z[:, 0::2], Z[:, 1::2]
    np.greater_equal(even, odd, out=first)
    np.maximum(even, odd, out=H)
    np.maximum(H, 0, out=H)
    np.greater(H, 0, out=active)


def unpool_into(dH: np.ndarray, first: np.ndarray, active: np.ndarray, dZ: np.ndarray) -> None:
    """The gradient goes to the first largest of each pair, where the unit is active. dH is used up.

    (B, T / 2, m)  ->  dZ (B, T / 2, 2, m)
    """
    dH *= active
    np.multiply(dH, first, out=dZ[:, :, 0])
    np.subtract(dH, dZ[:, :, 0], out=dZ[:, :, 1])


def check_even(T: int) -> None:
    """Raise ValueError for an odd number of frames, which the pooling cannot halve."""
    if T % 2:
        raise ValueError(f"T: found {T} frames, needed an even number for the pooling; cut or "
                         "double the last frame")
