"""Answers to 13_fast_convolution.ipynb."""

import numpy as np


def my_transform(n):
    omega = np.pi * (2 * np.arange(n // 2) + 1) / n
    angles = omega[:, None] * np.arange(n)
    return np.concatenate([np.cos(angles), -np.sin(angles)])


def my_three_products(a, b, c, d):
    q0, q1, q2 = (a + b) @ c, a @ (d - c), -b @ (c + d)
    return q0 + q2, q0 + q1


def my_overlap_save(x, K, n, correlate):
    L = n - K + 1
    wanted = len(x) - K + 1
    padded = np.concatenate([x, np.zeros(n)])
    pieces = [correlate(padded[begin:begin + n]) for begin in range(0, wanted, L)]
    return np.concatenate(pieces)[:wanted]
