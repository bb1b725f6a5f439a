"""Answers to 14_align_and_interpolate.ipynb."""

import numpy as np

from refimpl.torresani2006 import align


def my_accumulate(d):
    P, Q = d.shape
    C = np.empty((P, Q))
    for p in range(P):
        for q in range(Q):
            before = [C[p - 1, q - 1] if p and q else np.inf, C[p - 1, q] if p else np.inf,
                      C[p, q - 1] if q else np.inf]
            C[p, q] = d[p, q] + (min(before) if p or q else 0.0)
    return C


def my_dtw(X, Y):
    C = my_accumulate(align.distances(X, Y))
    p, q = len(X) - 1, len(Y) - 1
    path = [(p, q)]
    while p or q:
        if p and q:
            # of equal ones min takes the first
            ways = [(p - 1, q - 1), (p - 1, q), (p, q - 1)]
            p, q = min(ways, key=lambda way: C[way])
        else:
            p, q = (p - 1, q) if p else (p, q - 1)
        path.append((p, q))
    return C[-1, -1], np.array(path[::-1])


def my_blend(X, Y, path, alpha):
    curve, n0, n1 = align.time_curve(path)
    T = round((1 - alpha) * len(X) + alpha * len(Y))
    k = np.arange(T)
    n = (((1 - alpha) * align.read_at(n0, k * (len(X) - 1) / (T - 1))
          + alpha * align.read_at(n1, k * (len(Y) - 1) / (T - 1))))
    n = np.maximum.accumulate(np.clip(n, 0, len(curve) - 1))
    n[0], n[-1] = 0, len(curve) - 1
    p, q = align.read_at(curve, n).T
    return (1 - alpha) * align.read_at(X, p) + alpha * align.read_at(Y, q)


def my_blend_roots(A, B, alpha):
    B = B.copy()
    B[:, 3] -= 2 * np.pi * np.round((B[0, 3] - A[0, 3]) / (2 * np.pi))
    # height and heading; the floor is replaced below
    out = (1 - alpha) * A + alpha * B
    felt = sum(weight * align.turned(np.diff(R[:, [0, 2]], axis=0), -R[:-1, 3], "y") for weight,
               R in ((1 - alpha, A), (alpha, B)))
    out[1:, [0, 2]] = out[0, [0, 2]] + np.cumsum(align.turned(felt, out[:-1, 3], "y"), axis=0)
    return out
